"""Instances of native FMUs: phases, messages, states, threads, and builds without the tools."""

import ctypes
import subprocess
import sys
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from command_line import error_line, maglev
from facts import raises, require_facts
from fmu_access import another, bits, outputs, put, read, refusal, step

from maglev.cosim.fmu import Fmu
from maglev.fmi import compiler
from maglev.language.errors import ExportError
from maglev.user.source import FmuFile

Load = Callable[[str], Fmu]


def started(load: Load, name: str) -> Fmu:
    fmu = load(name)
    fmu.initialise({}, 0.0, 10.0)
    return fmu


def test_calls_outside_their_phase(load_either: Load) -> None:
    """FMI 2.0.4, figure 11 and the table below it."""
    fmu = load_either("Plant3DOF")
    instance = fmu.instance
    first = "before fmi2EnterInitializationMode"
    said = refusal(fmu, lambda: read(fmu, "y.position"))
    assert f"fmi2GetReal {first}, expected in the initialization or after the initialization or after fmi2Terminate" \
        in said
    assert first in refusal(fmu, instance.exitInitializationMode)
    assert first in refusal(fmu, instance.terminate)
    instance.enterInitializationMode()
    assert "in the initialization" in refusal(fmu, instance.setupExperiment)
    assert "in the initialization" in refusal(fmu, instance.enterInitializationMode)
    instance.exitInitializationMode()
    assert "after the initialization" in refusal(fmu, instance.exitInitializationMode)
    instance.doStep(0.0, 2e-4)
    instance.terminate()
    assert outputs(fmu)
    assert "after fmi2Terminate" in refusal(fmu, lambda: instance.doStep(2e-4, 2e-4))
    assert "after fmi2Terminate" in refusal(fmu, lambda: put(fmu, {"z.force": 1.0}))
    instance.reset()
    fmu.initialise({}, 0.0, 1.0)
    instance.doStep(0.0, 2e-4)


def test_after_a_refused_step(load_native: Load) -> None:
    """An error ends the run; a state from before it, or a reset, starts another one."""
    fmu = started(load_native, "Plant3DOF")
    state = fmu.instance.getFMUState()
    refusal(fmu, lambda: fmu.instance.doStep(0.0, -1.0))
    assert "after an error" in refusal(fmu, lambda: fmu.instance.doStep(0.0, 2e-4))
    assert outputs(fmu), "for debugging"
    fmu.instance.setFMUState(state)
    fmu.instance.doStep(0.0, 2e-4)
    fmu.instance.freeFMUState(state)


def test_step_beyond_the_stop_time(load_either: Load) -> None:
    fmu = load_either("Plant3DOF")
    fmu.initialise({}, 0.0, 1e-3)
    step(fmu, 0, 5, 2e-4)
    said = refusal(fmu, lambda: fmu.instance.doStep(1e-3, 2e-4))
    assert said == f"communication step to {1e-3 + 2e-4} s, expected at most the stop time, 0.001 s"


def test_step_to_the_stop_time_with_a_rounded_clock(load_either: Load) -> None:
    fmu = load_either("Plant3DOF")
    fmu.initialise({}, 0.0, 0.3)
    for k in range(3):
        fmu.instance.doStep(k * 0.1, 0.1 + 1e-17)


def test_serialized_state_that_is_not_its_own(load_native: Load) -> None:
    plant, other = started(load_native, "Plant2DOF"), started(load_native, "Plant3DOF")
    data = plant.instance.serializeFMUstate(plant.instance.getFMUState())
    for wrong in (b"", b"\x00garbage", data[:-1], data[:-1] + bytes([data[-1] ^ 1])):
        assert f"serialized state of {len(wrong)} bytes, expected {len(data)} bytes that this FMU has written" \
            == refusal(plant, partial(plant.instance.deSerializeFMUstate, wrong))
    assert "that this FMU has written" in refusal(other, lambda: other.instance.deSerializeFMUstate(data))


def set_logging(fmu: Fmu, on: bool, categories: list[str]) -> None:
    texts = (ctypes.c_char_p * len(categories))(*(category.encode() for category in categories))
    assert fmu.instance.dll["fmi2SetDebugLogging"](fmu.handle(), int(on),
                                                         ctypes.c_size_t(len(categories)), texts) == 0


@pytest.mark.parametrize(("on", "categories"), [
    (True, []), (True, ["logStatusWarning"]), (False, []), (False, ["logStatusError"]), (False, ["logAll"])])
def test_errors_are_logged_whether_logging_is_on_or_off(load_native: Load, on: bool, categories: list[str]) -> None:
    """FMI 2.0.5, section 2.1.3: for fmi2Error the logger was called."""
    fmu = started(load_native, "Plant3DOF")
    set_logging(fmu, on, categories)
    assert refusal(fmu, lambda: fmu.instance.doStep(0.0, 0.0)).startswith("communication step = 0.0 s")


STATUS_KINDS = {"fmi2DoStepStatus": 0, "fmi2PendingStatus": 1, "fmi2LastSuccessfulTime": 2, "fmi2Terminated": 3}
FMI2_DISCARD = 2


@pytest.mark.parametrize("kind", STATUS_KINDS)
@pytest.mark.parametrize("call", ["fmi2GetStatus", "fmi2GetRealStatus", "fmi2GetIntegerStatus", "fmi2GetBooleanStatus",
                                  "fmi2GetStringStatus"])
@pytest.mark.parametrize(("on", "categories", "speaks"), [
    (True, [], True), (True, ["logAll"], True), (True, ["logStatusDiscard"], True), (True, ["logStatusError"], False),
    (False, [], False), (False, ["logStatusDiscard"], False), (False, ["logStatusFatal"], True)])
def test_status_that_cannot_be_told(load_native: Load, call: str, kind: str, on: bool, categories: list[str],
                                    speaks: bool) -> None:
    """FMI 2.0.5, section 4.2.3: fmi2Discard; section 2.1.3: said if debug logging is on."""
    fmu = started(load_native, "Plant3DOF")
    fmu.instance.doStep(0.0, 2e-4)
    set_logging(fmu, on, categories)
    fmu.said()
    place = ctypes.c_double(-1.0)
    status = fmu.instance.dll[call](fmu.handle(), STATUS_KINDS[kind], ctypes.byref(place))
    if (call, kind) == ("fmi2GetRealStatus", "fmi2LastSuccessfulTime"):
        assert (status, place.value) == (0, 2e-4)
    elif (call, kind) == ("fmi2GetBooleanStatus", "fmi2Terminated"):
        assert (status, ctypes.c_int.from_buffer(place).value) == (0, 0)
    else:
        assert status == FMI2_DISCARD
        said = fmu.said()
        assert bool(said) is speaks
        assert not speaks or f"{call} of {kind}: there is no such status" in said


def test_fmpy_shows_why_a_start_value_is_refused(native_fmus: Path) -> None:
    """On its command line, where logging is off by default."""
    done = subprocess.run([sys.executable, "-m", "fmpy", "simulate", native_fmus / "Plant2DOF.fmu", "--start-values",
                           "v.mass", "-1"], capture_output=True, text=True)
    assert done.returncode != 0
    assert "[ERROR] v.mass = -1.0 kg, expected a number from 0.001" in done.stdout


@pytest.mark.parametrize(("name", "size"), [("Plant3DOF", 2e-4), ("ScheduledRegulator3DOF", 2e-4)])
def test_instances_in_threads(load_native: Load, name: str, size: float) -> None:
    """Two instances of one library, stepped at the same time, do what each does alone; ctypes lets them run at once."""
    inputs = [v.name for v in load_native(name).description.modelVariables
              if v.causality == "input" and v.unit in ("m/s", "A")]

    def run(fmu: Fmu, sign: float, rows: list[dict[str, float]]) -> None:
        for k in range(400):
            put(fmu, dict.fromkeys(inputs, sign * (k // 50 % 5 - 2) * 0.1))
            for part in range(5):
                fmu.instance.doStep((5 * k + part) * size, size)
            rows.append(outputs(fmu))

    results: list[list[list[dict[str, float]]]] = []
    for parallel in (False, True):
        rows: list[list[dict[str, float]]] = [[], []]
        one = load_native(name)
        both = one, another(one)
        assert both[0].instance.dll._handle == both[1].instance.dll._handle
        for fmu in both:
            fmu.initialise({}, 0.0, 10.0)
        threads = [threading.Thread(target=run, args=(fmu, sign, kept))
                   for fmu, sign, kept in zip(both, (1.0, -1.0), rows, strict=True)]
        for thread in threads:
            thread.start()
            if not parallel:
                thread.join()
        for thread in threads:
            thread.join()
        both[1].instance.freeInstance()
        results.append(rows)
    assert [len(rows) for rows in results[1]] == [400, 400]
    assert [bits(rows) for rows in results[0]] == [bits(rows) for rows in results[1]]
    assert bits(results[0][0]) != bits(results[0][1])


def test_build_without_a_tool(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    missing = "ziglang"

    def find_spec(name: str) -> object | None:
        return None if name == missing else object()

    monkeypatch.setattr("maglev.files.errors.find_spec", find_spec)
    said = error_line(maglev("build", "--kind", "native", "--target", "host", "PID2DOF", "--fmus", tmp_path))
    require_facts(said, missing, "'maglev-fmus[native]'")
    assert list(tmp_path.rglob("*.fmu*")) == []


@pytest.mark.parametrize("arguments", [("--kind", "native", "--target", "linux"), ("--target", "host"),
                                       ("--target", "wasm")])
def test_wrong_target(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    said = error_line(maglev("build", *arguments, "PID2DOF", "--fmus", tmp_path))
    require_facts(said, "target", arguments[-1], "all, host or wasm")


@pytest.mark.usefixtures("slow")
def test_compiler_that_refuses() -> None:
    pytest.importorskip("ziglang")
    with pytest.raises(ExportError):
        compiler.library({"broken.c": "int f("}, "broken", compiler.PLATFORMS["x86_64-linux"])


def test_compiler_without_a_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """None, or one that cannot be written to: what zig keeps goes elsewhere."""
    from maglev.fmi.compiler import kept_at_home
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    for home, kept in ((str(tmp_path), True), (str(tmp_path / "not" / "there"), True), ("", False)):
        monkeypatch.setenv("HOME", home)
        assert kept_at_home() is kept
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    asked = []
    monkeypatch.setattr("os.access", lambda place, mode: asked.append(place))
    assert not kept_at_home() and asked == [tmp_path]


def test_machine_that_is_not_known(monkeypatch: pytest.MonkeyPatch) -> None:
    from maglev.fmi.native_build import host_platform
    monkeypatch.setattr("platform.system", lambda: "Plan9")
    with raises(ExportError, "system", "'Plan9'", "Linux, Windows or Darwin"):
        host_platform()


def test_modules_of_a_native_run_need_no_python_of_the_project(native_fmus: Path) -> None:
    """Nothing is imported by the FMU."""
    before = set(sys.modules)
    path = native_fmus / "PID2DOF.fmu"
    from maglev.cosim.fmu import read_description
    with Fmu("PID2DOF", FmuFile(path), read_description("PID2DOF", path)) as fmu:
        fmu.initialise({}, 0.0, 1.0)
        step(fmu, 0, 3, 5e-4)
    assert not any(name.startswith("pid2dof_") for name in set(sys.modules) - before)
