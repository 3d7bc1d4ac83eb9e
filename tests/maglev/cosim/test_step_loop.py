"""The step loop in C: bit for bit the one in Python, with its refusals and interruptions, and never a wrong library."""

import ctypes
import math
import os
import shutil
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path

import numpy as np
import pytest
from facts import raises, require_facts, warns
from sampled_loop import PHASES

import maglev
from maglev.cosim import Order, step_loop
from maglev.cosim.master import FmuSetup, Master, Recording, RunFailed, RunInterrupted
from maglev.cosim.port_map import PortMap, Scale
from maglev.cosim.step_loop import LIBRARY, SOURCE, build_loop, keep_loop, own_loop, source, step_function, version
from maglev.cosim.wiring import Call
from maglev.files.cache import Kept
from maglev.files.errors import FmuError
from maglev.fmi.compiler import library
from maglev.fmi.native_build import host_platform
from maglev.runs.preparation import prepare
from maglev.scenario.loading import load_plan

MOTORS = ("alpha", "beta")
CONNECTIONS = [(f"controller.{motor}.{phase}", f"plant.{motor}.{phase}") for motor in MOTORS for phase in PHASES] + [
    (f"plant.{axis}.encoder", f"controller.{axis}.measured") for axis in "yxz"]
STEP = 2e-4   # s


@pytest.fixture(scope="session", autouse=True)
def with_loop(native_fmus: Path) -> None:
    """The loop is there, for native FMUs were built."""
    assert own_loop() is not None


@contextmanager
def no_loop() -> Iterator[None]:
    """A user who has built no native FMU."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("maglev.cosim.master.own_loop", lambda: None)
        patch.setattr("maglev.runs.preparation.own_loop", lambda: None)
        yield


@pytest.fixture
def loops(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether each run took the loop in C."""
    found: list[bool] = []

    class Watched(step_loop.Stepper):
        def __init__(self, phases: Sequence[Sequence[Call]], loop: Kept | None = None,
                     counter: memoryview | None = None):
            super().__init__(phases, loop, counter)
            found.append(self.loop is not None)

    monkeypatch.setattr("maglev.cosim.master.Stepper", Watched)
    return found


def require_equal(one: Recording, other: Recording) -> None:
    assert list(one.columns) == list(other.columns)
    for name, column in one.columns.items():
        assert column.tobytes() == other.columns[name].tobytes(), name


def simulated(folder: Path, steps: int, ports: PortMap | None = None, order: Order = "sequential",
          drives: dict[str, list[float]] | None = None) -> Recording:
    with Master([FmuSetup("controller", folder / "Regulator3DOF.fmu", {}, ports),
                 FmuSetup("plant", folder / "Plant3DOF.fmu")], CONNECTIONS, STEP, order) as master:
        return master.run(steps * STEP, drives or {"controller.x.reference": [0.005] * (steps + 1)})


@pytest.mark.parametrize("order", ["sequential", "jacobi"])
@pytest.mark.parametrize("name", ["2dof-setpoints", "3dof-setpoints-improved", "3dof-smooth-scheduled",
                                  "3dof-tracking-pid", "2dof-identification-rig"])
def test_loops_agree(native_fmus: Path, loops: list[bool], name: str, order: Order) -> None:
    plan = load_plan(name).model_copy(update={"stop_time": 1.5})
    compiled = prepare(plan, native_fmus, {}, {}, {"order": order}).run()
    with no_loop():
        plain = prepare(plan, native_fmus, {}, {}, {"order": order}).run()
    assert loops == [True, False]
    require_equal(compiled, plain)
    assert any(np.ptp(column) > 1e-4 for name, column in compiled.columns.items() if name.endswith(".position"))


@pytest.mark.parametrize("order", ["sequential", "jacobi"])
@pytest.mark.parametrize("own", [3 * STEP, STEP / 3])
def test_loops_agree_on_rates(native_fmus: Path, loops: list[bool], own: float, order: Order) -> None:
    """The plant takes three steps in one, or one in three; 900 steps are no multiple of what goes at once."""
    found = []
    for given in (nullcontext, no_loop):
        with given(), Master([FmuSetup("controller", native_fmus / "Regulator3DOF.fmu"),
                              FmuSetup("plant", native_fmus / "Plant3DOF.fmu", {}, PortMap(step=own))], CONNECTIONS,
                             STEP, order) as master:
            found.append(master.run(900 * STEP, {"controller.x.reference": [0.005] * 901}))
    assert loops == [True, False]
    require_equal(*found)
    assert np.ptp(found[0].columns["plant.x.position"]) > 1e-4


@pytest.mark.parametrize("at", [0, 100, 499, 500, 777])
def test_refused_step(native_fmus: Path, loops: list[bool], at: int) -> None:
    drives = {"controller.x.reference": [0.005] * at + [math.nan] * (1001 - at)}
    failures = []
    for given in (nullcontext, no_loop):
        with given(), pytest.raises(RunFailed) as failure:
            simulated(native_fmus, 1000, drives=drives)
        failures.append(failure.value)
    assert loops == [True, False]
    assert str(failures[0]) == str(failures[1])
    require_facts(failures[0], f"{at * STEP:.9g} s", "x.reference", "nan m")
    assert len(failures[0].recording.time) == at + 1
    require_equal(failures[0].recording, failures[1].recording)


def test_fmus_that_run_python_take_it_too(fmus: Path, loops: list[bool]) -> None:
    """The same run, and the same refusal."""
    drives = {"controller.x.reference": [0.005] * 550 + [math.nan] * 51}
    failures = []
    for given in (nullcontext, no_loop):
        with given(), pytest.raises(RunFailed) as failure:
            simulated(fmus, 600, drives=drives)
        failures.append(failure.value)
    assert loops == [True, False]
    assert str(failures[0]) == str(failures[1])
    require_facts(failures[0], "x.reference", "nan m")
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
        with raises(RunInterrupted, "0.1 s") as failure:
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


ANOTHER_VERSION = source().replace(str(version()), str(version() + 1))
FORGED = source() + """
#include <stdio.h>
__attribute__((constructor)) static void forged(void) { FILE *file = fopen("forged.txt", "w"); fclose(file); }
"""


def built(text: str) -> bytes:
    platform, = host_platform().values()
    return library({"loop.c": text}, "loop", platform)


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Cache of a user, empty."""
    monkeypatch.setenv("MAGLEV_CACHE", str(tmp_path / "cache"))
    assert own_loop() is None
    return tmp_path / "cache"


@pytest.mark.parametrize("content", [lambda: built(ANOTHER_VERSION), lambda: built("int nothing;\n"),
                                     lambda: built(source().replace("maglev_step_over", "step_over_else")),
                                     lambda: b"no library"])
def test_ignores_a_loop_of_another_version(native_fmus: Path, own: Path, loops: list[bool],
                                           content: Callable[[], bytes]) -> None:
    loop = keep_loop(content())
    assert own_loop() == loop
    with no_loop():
        plain = simulated(native_fmus, 600)
    require_equal(simulated(native_fmus, 600), plain)
    assert loops == [False, False]


@pytest.mark.parametrize("place", [".", "fmus", "fmus/native", "results", "native"])
def test_a_library_is_never_taken_for_its_place(native_fmus: Path, own: Path, tmp_path: Path,
                                                monkeypatch: pytest.MonkeyPatch, place: str) -> None:
    """Not from the current folder, nor next to, above or below the FMUs: it is not even loaded. The user's own is."""
    folder = tmp_path / "fmus"
    for path in (folder / "native", tmp_path / "results", tmp_path / "native"):
        path.mkdir(parents=True, exist_ok=True)
    for name in ("Regulator2DOF.fmu", "Plant2DOF.fmu"):
        shutil.copy(native_fmus / name, folder / "native")
    (tmp_path / place / LIBRARY).write_bytes(built(FORGED))
    monkeypatch.chdir(tmp_path)
    run = maglev.run("2dof-step-4-nonlinear", fmus="fmus", kind="native")
    assert not (tmp_path / "forged.txt").exists()
    loop = own_loop()
    assert run.result.provenance is not None and loop is not None
    assert run.result.provenance.libraries == {LIBRARY: loop.sha256}


def test_it_is_known_by_its_content(native_fmus: Path, own: Path, tmp_path: Path,
                                    monkeypatch: pytest.MonkeyPatch) -> None:
    """Another content under its name, one that others can write, and one that changes after a run was made ready."""
    monkeypatch.chdir(tmp_path)
    loop = build_loop()
    assert loop == own_loop() == build_loop()
    experiment = prepare(load_plan("2dof-step-4-nonlinear"), native_fmus, {}, {})
    assert experiment.provenance().libraries == {LIBRARY: loop.sha256}
    for path in (loop.path, loop.path.parent):
        mode = path.stat().st_mode
        path.chmod(mode | 0o020)
        assert own_loop() is None
        path.chmod(mode)
    loop.path.write_bytes(built(FORGED))
    assert own_loop() is None
    step_function.cache_clear()
    with raises(FmuError, loop.path):
        experiment.run()
    assert not (tmp_path / "forged.txt").exists()
    assert build_loop() == loop == own_loop()


@pytest.mark.thorough
def test_without_room_for_it_runs_are_stepped_in_python(native_fmus: Path, own: Path, loops: list[bool]) -> None:
    own.write_text("no folder")
    with warns("cache", "folder"):
        maglev.build("Plant2DOF", fmus=own.parent / "fmus", kind="native", target="host")
    assert own_loop() is None
    simulated(native_fmus, 10)
    assert loops == [False]


def test_the_version_is_of_the_text() -> None:
    loop = own_loop()
    assert loop is not None
    assert step_function(loop) is not None
    assert SOURCE.read_text(encoding="utf-8") in source()
