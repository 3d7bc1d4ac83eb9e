"""The step loop in C: bit for bit the one in Python, with its refusals and interruptions, and never a wrong library."""

import ctypes
import math
import os
import shutil
import signal
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sampled_loop import PHASES

from fmi_export.native.build import host_platform
from fmi_export.native.compiler import library
from maglev.cosim import step_loop, stepping
from maglev.cosim.master import FmuSetup, Master, Recording, RunFailed, RunInterrupted
from maglev.cosim.order import Order
from maglev.cosim.port_map import PortMap, Scale
from maglev.cosim.step_loop import LIBRARY, SOURCE, source, step_function, version
from maglev.cosim.wiring import Call
from maglev.experiment.preparation import prepare
from maglev.schema.loading import load_plan

MOTORS = ("alpha", "beta")
CONNECTIONS = [(f"controller.{motor}.{phase}", f"plant.{motor}.{phase}") for motor in MOTORS for phase in PHASES] + [
    (f"plant.{axis}.encoder", f"controller.{axis}.measured") for axis in "yxz"]
STEP = 2e-4   # s


@pytest.fixture(scope="session")
def without_loop(native_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the native FMUs alone."""
    folder = tmp_path_factory.mktemp("without_loop")
    for path in native_fmus.glob("*.fmu"):
        (folder / path.name).symlink_to(path)
    return folder


@pytest.fixture
def loops(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether each run took the loop in C."""
    found: list[bool] = []

    def compiled(phases: Sequence[Sequence[Call]], folders: Sequence[Path], counter: memoryview) -> Any:
        loop = step_loop.compiled(phases, folders, counter)
        found.append(loop is not None)
        return loop

    monkeypatch.setattr(stepping, "compiled", compiled)
    return found


def require_equal(one: Recording, other: Recording) -> None:
    assert list(one.columns) == list(other.columns)
    for name, column in one.columns.items():
        assert column.tobytes() == other.columns[name].tobytes(), name


def flown(folder: Path, steps: int, ports: PortMap | None = None, order: Order = "sequential",
          drives: dict[str, list[float]] | None = None) -> Recording:
    with Master([FmuSetup("controller", folder / "Regulator3DOF.fmu", {}, ports),
                 FmuSetup("plant", folder / "Plant3DOF.fmu")], CONNECTIONS, STEP, order) as master:
        return master.run(steps * STEP, drives or {"controller.x.reference": [0.005] * (steps + 1)})


@pytest.mark.parametrize("order", ["sequential", "jacobi"])
@pytest.mark.parametrize("name", ["2dof-setpoints", "3dof-setpoints-improved", "3dof-smooth-scheduled",
                                  "3dof-tracking-pid", "2dof-identification-rig"])
def test_loops_agree(native_fmus: Path, without_loop: Path, loops: list[bool], name: str, order: Order) -> None:
    plan = load_plan(name).model_copy(update={"stop_time": 1.5})
    compiled, plain = (prepare(plan, folder, {}, {}, order=order).run() for folder in (native_fmus, without_loop))
    assert loops == [True, False]
    require_equal(compiled, plain)
    assert any(np.ptp(column) > 1e-4 for name, column in compiled.columns.items() if name.endswith(".position"))


@pytest.mark.parametrize("order", ["sequential", "jacobi"])
@pytest.mark.parametrize("own", [3 * STEP, STEP / 3])
def test_loops_agree_on_rates(native_fmus: Path, without_loop: Path, loops: list[bool], own: float,
                              order: Order) -> None:
    """The plant takes three steps in one, or one in three; 900 steps are no multiple of what goes at once."""
    found = []
    for folder in (native_fmus, without_loop):
        with Master([FmuSetup("controller", folder / "Regulator3DOF.fmu"),
                     FmuSetup("plant", folder / "Plant3DOF.fmu", {}, PortMap(step=own))], CONNECTIONS, STEP,
                    order) as master:
            found.append(master.run(900 * STEP, {"controller.x.reference": [0.005] * 901}))
    assert loops == [True, False]
    require_equal(*found)
    assert np.ptp(found[0].columns["plant.x.position"]) > 1e-4


@pytest.mark.parametrize("at", [0, 100, 499, 500, 777])
def test_refused_step(native_fmus: Path, without_loop: Path, loops: list[bool], at: int) -> None:
    drives = {"controller.x.reference": [0.005] * at + [math.nan] * (1001 - at)}
    failures = []
    for folder in (native_fmus, without_loop):
        with pytest.raises(RunFailed) as failure:
            flown(folder, 1000, drives=drives)
        failures.append(failure.value)
    assert loops == [True, False]
    assert str(failures[0]) == str(failures[1])
    assert f"at t = {at * STEP:.9g} s" in str(failures[0])
    assert "x.reference = nan m" in str(failures[0])
    assert len(failures[0].recording.time) == at + 1
    require_equal(failures[0].recording, failures[1].recording)


@pytest.mark.parametrize("beside", [".", "python"])
def test_fmus_that_run_python_take_the_loop_of_native_ones(fmus: Path, native_fmus: Path, loops: list[bool],
                                                           tmp_path: Path, beside: str) -> None:
    """With a folder of native FMUs in or beside their own: the same run, and the same refusal."""
    drives = {"controller.x.reference": [0.005] * 550 + [math.nan] * 51}
    (tmp_path / "plain").mkdir()
    (tmp_path / "looped" / beside).mkdir(parents=True)
    (tmp_path / "looped" / "native").symlink_to(native_fmus)
    failures = []
    for folder in (tmp_path / "looped" / beside, tmp_path / "plain"):
        for name in ("Regulator3DOF.fmu", "Plant3DOF.fmu"):
            (folder / name).symlink_to(fmus / name)
        with pytest.raises(RunFailed) as failure:
            flown(folder, 600, drives=drives)
        failures.append(failure.value)
    assert loops == [True, False]
    assert str(failures[0]) == str(failures[1])
    assert "x.reference = nan m" in str(failures[0])
    assert len(failures[0].recording.time) == 551
    require_equal(failures[0].recording, failures[1].recording)


def test_interrupted_in_a_callback(native_fmus: Path, loops: list[bool]) -> None:
    """Python functions with C types are called as C functions are; Ctrl-C ends the run behind the steps under way."""
    calls = 0

    def interrupt(_instance: int | None, _time: float, _step: float, _keep: int) -> int:
        nonlocal calls
        calls += 1
        if calls == 124:
            os.kill(os.getpid(), signal.SIGINT)
        return 0

    callback = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_void_p, ctypes.c_double, ctypes.c_double,
                                ctypes.c_int)(interrupt)
    with Master([FmuSetup("controller", native_fmus / "Regulator3DOF.fmu"),
                 FmuSetup("plant", native_fmus / "Plant3DOF.fmu")], CONNECTIONS, STEP) as master:
        master.fmus["controller"].do_step = callback
        with pytest.raises(RunInterrupted, match=r"at t = 0\.1 s: interrupted") as failure:
            master.run(0.2)
    assert loops == [True]
    assert calls == 500
    assert len(failure.value.recording.time) == 501


def test_converted_units_take_the_loop_in_python(native_fmus: Path, loops: list[bool]) -> None:
    with Master([FmuSetup("plant", native_fmus / "Plant3DOF.fmu")], [], STEP) as master:
        master.fmus["plant"].scales = {"y.position": Scale(1000.0, 1.0)}
        position = master.run(0.01).columns["plant.y.position"]
    assert loops == [False]
    assert position[0] == pytest.approx(25e-6)


@pytest.mark.parametrize("text", [
    source().replace(str(version()), str(version() + 1)),
    source().replace("maglev_step_over", "step_over_else"),
    "int nothing;\n", None])
def test_a_library_of_another_version_is_left_alone(native_fmus: Path, without_loop: Path, tmp_path: Path,
                                                    loops: list[bool], text: str | None) -> None:
    for name in ("Regulator3DOF.fmu", "Plant3DOF.fmu"):
        shutil.copy(native_fmus / name, tmp_path)
    platform, = host_platform().values()
    (tmp_path / LIBRARY).write_bytes(b"no library" if text is None else library({"loop.c": text}, "loop", platform))
    require_equal(flown(tmp_path, 600), flown(without_loop, 600))
    assert loops == [False, False]


def test_the_version_is_of_the_text(native_fmus: Path) -> None:
    assert step_function(native_fmus / LIBRARY) is not None
    assert SOURCE.read_text(encoding="utf-8") in source()
