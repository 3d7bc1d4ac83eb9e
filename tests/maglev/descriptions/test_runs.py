"""Closed loops as one FMU: bit for bit the runs of controller and plant under our master."""

import runpy
from collections.abc import Sequence
from pathlib import Path

import fmpy
import numpy as np
import pytest
from command_line import run_script
from fmpy.util import read_csv

from maglev.cosim.master import FmuSetup, Master, Recording
from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.fmi.definition import Variable
from maglev.runs.preparation import prepare
from maglev.runs.results import write_csv
from maglev.scenario.layers import PACKAGED
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import RunPlan
from maglev.scenario.settings import start_values

INPUTS = PACKAGED / "inputs"
FILES = {"2dof-setpoints.csv": ("ClosedLoop2DOF", "2dof-setpoints"),
         "3dof-setpoints.csv": ("ClosedLoop3DOF", "3dof-setpoints-improved"),
         "5dof-setpoints.csv": ("ClosedLoop5DOF", "5dof-setpoints")}
LOOPS = [name for name in DEFINITIONS if name.startswith("ClosedLoop")]


def starts_of(plan: RunPlan) -> dict[str, float | bool]:
    """Start values of a plan, under their names in a loop."""
    return {f"{part}.{variable}": value.value for part, fmu in plan.fmus.items()
            for variable, value in fmu.start.items()}


def in_parts(variable: Variable) -> str:
    """Name, in a run of controller and plant, of an input or a parameter of their loop."""
    name = variable.name
    return f"{variable.place.partition('.')[0]}.{name}" if variable.causality == "input" else name


def simulate(loop: str, folder: Path, plan: RunPlan, given: Recording, every: int) -> Recording:
    """Run of a loop with what a run of the plan was given, in communication steps of several samples."""
    drives = {f"loop.{v.name}": given.columns[in_parts(v)][::every].tolist() for v in definition(loop).variables
              if v.causality != "output" and in_parts(v) in given.columns}
    with Master([FmuSetup("loop", folder / f"{loop}.fmu", starts_of(plan))], [],
                every * plan.step) as master:
        return master.run(plan.stop_time, drives)


def assert_same(recording: Recording, expected: Recording, every: int) -> None:
    """Every output has the same bits."""
    outputs = {name.removeprefix("loop."): column for name, column in recording.columns.items()
               if name.startswith(("loop.controller.", "loop.plant."))}
    driven = {name for name in expected.columns if name.endswith((".reference", ".reference_rate", ".force"))}
    assert set(outputs) == set(expected.columns) - driven
    for name, column in outputs.items():
        assert column.astype(np.float64).tobytes() == \
            expected.columns[name][::every].astype(np.float64).tobytes(), name


@pytest.mark.parametrize(("loop", "run", "settings", "every"), [
    ("ClosedLoop2DOF", "2dof-setpoints", [], 1),
    ("ClosedLoop3DOF", "3dof-setpoints-improved", [], 1),
    # Communication steps of several samples.
    ("ClosedLoop2DOF", "2dof-setpoints", [], 4),
    ("ClosedLoop3DOF", "3dof-setpoints-improved", [], 500),
    ("ClosedLoop5DOF", "5dof-setpoints", [], 5),
    # Parameters, and a start elsewhere than where the controller's inputs start.
    ("ClosedLoop3DOF", "3dof-setpoints", ["plant.y.position_start=23.456mm", "plant.x.friction.coulomb=1N"], 1),
    ("ClosedLoop2DOF", "2dof-setpoints-low-overshoot", ["plant.v.position_start=18.1mm"], 1),
    # Stops are met, and commands limited.
    ("ClosedLoop3DOF", "3dof-setpoints-large-no-antiwindup", [], 1),
    # The other laws; references that change at every sample; a trip.
    ("ClosedLoopLinear2DOF", "2dof-step-4-linear", ["controller.trip_error=18mm"], 1),
    ("ClosedLoopPID2DOF", "2dof-tracking-pid", [], 1),
    ("ClosedLoopLinear3DOF", "3dof-step-1-improved-linear", [], 1),
    ("ClosedLoopScheduled3DOF", "3dof-scheduled-large", [], 5),
    ("ClosedLoopPID3DOF", "3dof-tracking-pid", ["controller.y.prefilter=20rad/s"], 1),
])
def test_a_loop_is_the_run_of_our_master_bit_for_bit(native_fmus: Path, loop: str, run: str, settings: Sequence[str],
                                                     every: int) -> None:
    plan = load_plan(run).model_copy(update={"stop_time": 3.0})
    experiment = prepare(plan, native_fmus, {}, start_values(settings))
    assert experiment.plan.fmus["controller"].model == definition(loop).description.split()[3]
    expected = experiment.run()
    assert_same(simulate(loop, native_fmus, experiment.plan, expected, every), expected, every)
    for axis in plan.axes.values():
        assert np.ptp(expected.columns[axis.position]) > 1e-4, "something has to move for this to mean anything"


@pytest.mark.few(1)
@pytest.mark.parametrize("stage", ["3dof", "2dof", "5dof"])
def test_an_adaptive_loop_is_that_run_while_its_constants_move(native_fmus: Path, stage: str) -> None:
    """Also when a third of the thrust is lost after 6 s: a parameter of the loop that changes."""
    plan = load_plan(f"{stage}-thrust-loss-adaptive").model_copy(update={"stop_time": 8.0})
    experiment = prepare(plan, native_fmus, {}, {})
    expected = experiment.run()
    assert_same(simulate(f"ClosedLoopAdaptive{stage.upper()}", native_fmus, experiment.plan, expected, 1), expected, 1)
    lost = expected.columns["plant.C1"]
    assert lost[-1] < 0.7 * lost[0]
    adapted = [column for name, column in expected.columns.items() if name.startswith("controller.adapted.")]
    assert sum(np.ptp(column) > 1e-3 * column[0] for column in adapted) > 1


@pytest.mark.few(2)
@pytest.mark.parametrize("file", FILES)
def test_the_committed_inputs_give_the_run_of_their_scenario(either_kind: Path, file: str) -> None:
    """In fmpy, with nothing else set: the defaults of the loops are those of the scenarios."""
    loop, run = FILES[file]
    plan = load_plan(run).model_copy(update={"stop_time": 1.1})
    expected = prepare(plan, either_kind, {}, {}).run()
    result = fmpy.simulate_fmu(str(either_kind / f"{loop}.fmu"), input=read_csv(INPUTS / file),
                               output_interval=plan.step, stop_time=1.1)
    columns = {f"loop.{name}": result[name] for name in result.dtype.names if name != "time"}
    assert_same(Recording(result["time"], columns), expected, 1)
    assert max(np.ptp(result[axis.position]) for axis in plan.axes.values()) > 1e-3, "the step at 1 s is in it"


# A script is of a stage, and takes any of its loops.
@pytest.mark.few(1)
@pytest.mark.parametrize("name", [name if name in [f"ClosedLoop{stage.suffix}" for stage in PACKAGED_STAGES.values()]
                                  else pytest.param(name, marks=pytest.mark.thorough) for name in LOOPS])
def test_script_runs_each_loop(native_fmus: Path, tmp_path: Path, name: str) -> None:
    """It ends where it is told to, and the references step at 1 s."""
    stage = next(stage for stage in PACKAGED_STAGES.values() if name.endswith(stage.suffix))
    run_script(f"closed_loop_{stage.name}.sh", native_fmus, tmp_path / "out.csv", LOOP=name, STOP_TIME="1.005")
    result = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True, dtype=float, deletechars="")
    step = load_plan(FILES[f"{stage.name}-setpoints.csv"][1]).step
    assert len(result) - 1 == round(1.005 / step)
    error = result[f"controller.{stage.vertical.name}.error"]
    assert np.abs(error[:round(1.0 / step)]).max() < 3e-4 < 1.5e-3 < np.abs(error[round(1.0 / step) + 1])


@pytest.mark.parametrize("file", FILES)
def test_input_files_say_what_the_scenario_says(file: str, tmp_path: Path) -> None:
    script = runpy.run_path(str(Path(__file__).parents[3] / "tools" / "write_inputs.py"))
    assert script["FILES"] == FILES
    recording = script["inputs"](*FILES[file])
    write_csv(tmp_path / "inputs.csv", recording)
    assert (tmp_path / "inputs.csv").read_bytes() == (INPUTS / file).read_bytes()
    plan = load_plan(FILES[file][1])
    for t in np.arange(0.0, plan.stop_time, 0.1):
        row = np.searchsorted(recording.time, t + 1e-9, side="right") - 1
        for signal in plan.signals:
            assert recording.columns[signal.to.partition(".")[2]][row] == signal.value(t)


def test_a_push_moves_the_mover_of_the_loop_as_that_of_the_plant(native_fmus: Path) -> None:
    plan = load_plan("3dof-setpoints-improved")
    push = [5.0 * (k >= 100) for k in range(1001)]
    parts = [FmuSetup(name, native_fmus / f"{fmu.model}.fmu") for name, fmu in plan.fmus.items()]
    with Master(parts, list(plan.wires.values()), plan.step) as master:
        expected = master.run(0.2, {"plant.x.force": push})
    with Master([FmuSetup("loop", native_fmus / "ClosedLoop3DOF.fmu")], [], plan.step) as master:
        recording = master.run(0.2, {"loop.x.force": push})
    assert_same(recording, expected, 1)
    assert np.ptp(recording.columns["loop.plant.x.position"]) > 1e-4


@pytest.mark.few(5)
@pytest.mark.parametrize("name", LOOPS)
def test_default_experiment_levitates_with_nothing_set(native_fmus: Path, name: str) -> None:
    result = fmpy.simulate_fmu(str(native_fmus / f"{name}.fmu"))
    # 26 s, in the steps of 40 ms that fmpy makes of 10 ms.
    assert len(result) == 651 and result["time"][-1] == pytest.approx(26.0)
    for column in result.dtype.names:
        if column.endswith(".error"):
            assert np.abs(result[column][100:]).max() < 1e-4, column
    assert not result["plant.at_stop"].any() and not result["controller.tripped"].any()
