"""The FMUs' blocks in one loop: bit for bit the calls of the FMUs, which say what is refused."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from sampled_loop import PHASES

from maglev.cosim.master import FmuSetup, Master, Recording, RunFailed
from maglev.cosim.order import Order
from maglev.cosim.port_map import PortMap
from maglev.experiment.preparation import prepare
from maglev.schema.layers import packaged_runs
from maglev.schema.loading import load_plan

CONNECTIONS = [(f"controller.{motor}.{phase}", f"plant.{motor}.{phase}") for motor in ("alpha", "beta")
               for phase in PHASES] + [(f"plant.{axis}.encoder", f"controller.{axis}.measured") for axis in "yxz"]
STEP = 2e-4   # s
STEPS = 1001


def both(master: Master, stop_time: float, drives: Mapping[str, object]) -> list[Recording | RunFailed]:
    """A flight with calls, and one with the blocks; and that these were there."""
    master.wire(stop_time, drives)   # type: ignore[arg-type]
    found: list[Recording | RunFailed] = []
    counted = []
    for build in (False, True):
        if build:
            master.with_blocks(True)
            assert master.blocks is not None
        before = master.observer.counter[0]
        try:
            found.append(master.fly({}))
        except RunFailed as failure:
            found.append(failure)
        counted.append(master.observer.counter[0] - before)
    assert counted[0] == counted[1]   # as many calls as were made, or stood for
    return found


def require_equal(one: Recording, other: Recording) -> None:
    assert list(one.columns) == list(other.columns)
    for name, column in one.columns.items():
        assert column.tobytes() == other.columns[name].tobytes(), name


def require_same_flight(fmus: Path, name: str, stop_time: float | None, order: Order) -> None:
    plan = load_plan(name)
    if stop_time is not None:
        plan = plan.model_copy(update={"stop_time": stop_time})
    experiment = prepare(plan, fmus, {}, {}, order=order)
    with Master(experiment.setups(), experiment.connections, experiment.step, order) as master:
        calls, blocks = both(master, plan.stop_time, experiment.drives(experiment.check()))
    if isinstance(calls, RunFailed):   # such as of an experiment that shows a refusal
        assert isinstance(blocks, RunFailed)
        assert str(calls) == str(blocks)
        calls, blocks = calls.recording, blocks.recording
    assert isinstance(blocks, Recording)
    require_equal(calls, blocks)
    assert any(np.ptp(column) > 0.0 for column in calls.columns.values())


@pytest.mark.parametrize(("name", "order"), [
    ("2dof-faults-lost", "sequential"), ("3dof-setpoints-improved", "jacobi"), ("5dof-setpoints", "sequential"),
    ("3dof-measurement-jitter", "sequential"), ("3dof-estimator-matched", "sequential")])
def test_it_gives_the_bits_of_the_calls(native_fmus: Path, name: str, order: Order) -> None:
    require_same_flight(native_fmus, name, 1.5, order)


@pytest.mark.thorough
@pytest.mark.parametrize("name", list(packaged_runs()))
def test_it_gives_the_bits_of_every_run(native_fmus: Path, name: str) -> None:
    """With the FMUs' own values where a run takes some from another."""
    require_same_flight(native_fmus, name, None, "sequential")


def stage(fmus: Path, start: Mapping[str, float] | None = None, ports: PortMap | None = None) -> Master:
    return Master([FmuSetup("controller", fmus / "Regulator3DOF.fmu", start or {}),
                   FmuSetup("plant", fmus / "Plant3DOF.fmu", {}, ports)], CONNECTIONS, STEP)


@pytest.mark.parametrize("at", [0, 100, 499, 500, 777])
@pytest.mark.parametrize("value", [math.nan, 200.0])
def test_a_value_that_is_refused(native_fmus: Path, at: int, value: float) -> None:
    """Of no number, and of one out of range: the same message at the same time, and the same recording until then."""
    with stage(native_fmus) as master:
        calls, blocks = both(master, (STEPS - 1) * STEP,
                             {"controller.x.reference": [0.005] * at + [value] * (STEPS - at)})
    assert isinstance(calls, RunFailed)
    assert isinstance(blocks, RunFailed)
    assert str(calls) == str(blocks)
    assert f"at t = {at * STEP:.9g} s" in str(blocks)
    assert f"x.reference = {value:g}" in str(blocks)
    assert len(blocks.recording.time) == at + 1
    require_equal(calls.recording, blocks.recording)


def test_a_step_that_is_refused(native_fmus: Path) -> None:
    with stage(native_fmus, {"sample_time": 7e-4}) as master:
        calls, blocks = both(master, (STEPS - 1) * STEP, {"controller.x.reference": [0.005] * STEPS})
    assert isinstance(blocks, RunFailed)
    assert str(calls) == str(blocks)
    assert "sample_time" in str(blocks)


@pytest.mark.parametrize("own", [STEP / 2, 2 * STEP])
def test_an_fmu_with_other_steps(native_fmus: Path, own: float) -> None:
    """Of two steps in one the loop makes both; where steps differ from each other, the calls are made."""
    drives = {"controller.x.reference": [0.005] * STEPS}
    with stage(native_fmus, ports=PortMap(step=own)) as master:
        if own < STEP:
            calls, blocks = both(master, (STEPS - 1) * STEP, drives)
            assert isinstance(calls, Recording)
            assert isinstance(blocks, Recording)
            require_equal(calls, blocks)
        else:
            master.wire((STEPS - 1) * STEP, drives)
            master.with_blocks(True)
            assert master.blocks is None


def test_only_native_fmus_of_this_installation_are_taken(fmus: Path, native_fmus: Path, fmi3_fmus: Path,
                                                         tmp_path: Path) -> None:
    other = tmp_path / "Plant3DOF.fmu"
    other.write_bytes((native_fmus / "Plant3DOF.fmu").read_bytes() + b"\n")   # behind the archive, which nobody reads
    for plant, taken in ((native_fmus / "Plant3DOF.fmu", True), (other, True), (fmus / "Plant3DOF.fmu", False),
                         (fmi3_fmus / "Plant3DOF.fmu", False)):
        with Master([FmuSetup("plant", plant)], [], STEP) as master:
            master.wire(STEP, {})
            master.with_blocks(True)
            assert (master.blocks is not None) == taken, plant
