"""FMUs as WebAssembly: the same C, and where the mathematical library is the same, the same bits as a program."""

import platform
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from command_line import maglev
from native_builds import HERE, prefixing_headers, two_fmus_flown, unpacked_sources
from webassembly import CO_SIMULATION, WebAssemblyFmu, flown

from maglev.cosim.fmu import Fmu
from maglev.errors import FmuError
from maglev.experiment.preparation import Experiment
from maglev.schema.loading import load_plan

STEP, STEPS = 2e-4, 1000
# Without the encoder, whose steps make micrometres of a last digit: every law, and both rigs.
SMOOTH = ("2dof-smooth-linear", "2dof-smooth-pid", "3dof-smooth-nonlinear", "3dof-smooth-scheduled")


def test_a_module_asks_for_nothing_and_has_the_functions_of_fmi(wasm_fmus: Path) -> None:
    fmu = WebAssemblyFmu(wasm_fmus, "Plant3DOF")
    assert fmu.imports == []
    for name in ("fmi2Instantiate", "fmi2DoStep", "fmi2SetReal", "fmi2GetBoolean", "fmi2SerializeFMUstate", "malloc"):
        assert name in fmu.exports
    assert fmu.description.modelExchange is None, "derivatives would be a fifth of the page"
    assert (wasm_fmus / "Plant3DOF.wasm").read_bytes().find(b"maglev_scratch_") == -1


def test_the_same_sources_give_the_same_bytes(wasm_fmus: Path, tmp_path: Path) -> None:
    done = maglev("build", "--native", "--target", "wasm", "PID2DOF", "--fmus", tmp_path)
    assert done.exit_code == 0, done.output
    assert sorted(path.name for path in (tmp_path / "wasm").iterdir()) == ["PID2DOF.wasm", "PID2DOF.xml"]
    for path in (tmp_path / "wasm").iterdir():
        assert path.read_bytes() == (wasm_fmus / path.name).read_bytes()


def test_a_module_is_an_fmu_of_its_description_alone(wasm_fmus: Path) -> None:
    fmu = WebAssemblyFmu(wasm_fmus, "PID2DOF")
    instance = fmu.call("fmi2Instantiate", fmu.text(b"another"), CO_SIMULATION, fmu.text(b"{other}"), 0,
                        fmu.call("maglevCallbacks"), 0, 1)
    assert instance == 0
    assert "GUID = {other}, expected {" in fmu.message()


def test_it_refuses_in_the_words_of_the_native_fmu(wasm_fmus: Path, load_native: Callable[[str], Fmu]) -> None:
    native = load_native("Plant3DOF")
    with pytest.raises(FmuError) as refusal:
        native.initialise({"y.position_start": 0.05}, 0.0, 1.0)
    with pytest.raises(AssertionError) as here:
        WebAssemblyFmu(wasm_fmus, "Plant3DOF", {"y.position_start": 0.05})
    said = str(here.value).splitlines()[0]
    assert said.startswith("y.position_start = 0.05 m, expected a place between the stops")
    assert said in str(refusal.value)


@pytest.mark.parametrize("name", SMOOTH)
def test_a_run_is_that_of_the_native_fmus_but_for_the_mathematical_library(
        wasm_fmus: Path, native_fmus: Path, name: str) -> None:
    """Measured over 2 s: at most 1.8e-17 m and 2.7e-13 A."""
    plan = load_plan(name).model_copy(update={"stop_time": 1.2})
    files = {part: native_fmus / f"{fmu.model}.fmu" for part, fmu in plan.fmus.items()}
    experiment = Experiment(plan, files, plan.step)
    there = experiment.run(None).columns
    here = flown(wasm_fmus, plan, experiment.drives(experiment.check()), plan.stop_time)
    for column, values in here.items():
        bound = 1e-11 if ".i_" in column else 1e-12 if column.endswith("velocity") else 1e-15
        assert np.abs(values - there[column]).max() <= bound, column
    assert max(np.ptp(values) for column, values in here.items() if column.endswith("position")) > 1e-3


@pytest.mark.thorough
def test_with_the_same_mathematical_library_the_bits_are_the_same(
        wasm_fmus: Path, native_fmus: Path, tmp_path: Path) -> None:
    """A program of this machine with the C library that the modules have: what libm rounds is all that differs."""
    (tmp_path / "headers").mkdir()
    compiler = [sys.executable, "-m", "ziglang", "cc", "-target", f"{platform.machine()}-linux-musl", "-std=c99", "-O2",
                "-ffp-contract=off", "-fno-sanitize=all", "-I", str(prefixing_headers(tmp_path / "headers"))]
    objects = []
    for name in ("Plant3DOF", "Regulator3DOF"):
        sources = unpacked_sources(native_fmus / f"{name}.fmu", tmp_path / name)
        subprocess.run([*compiler, "-c", *sorted(path.name for path in sources.glob("*.c"))], cwd=sources, check=True)
        objects += sorted(map(str, sources.glob("*.o")))
    program = tmp_path / "two_fmus"
    subprocess.run([*compiler, str(HERE / "two_fmus.c"), *objects, "-o", str(program)], check=True)
    # The true positions are fed back, for the encoder would hide the last digits.
    measured = [(f"{axis}.position", f"{axis}.measured") for axis in "yxz"]
    there = two_fmus_flown(program, native_fmus, measured, STEP, STEPS)
    plan = load_plan("3dof-setpoints")
    wires = [(source.replace("encoder", "position"), target) for source, target in plan.connections]
    plan = plan.model_copy(update={"connections": wires, "fmus": {
        part: fmu.model_copy(update={"start": {}}) for part, fmu in plan.fmus.items()}})
    columns = flown(wasm_fmus, plan, {}, STEPS * STEP)
    here = np.stack([columns[f"plant.{position}"][:-1] for position, _ in measured], axis=1)
    assert np.array_equal(there, here)
    assert np.ptp(here, axis=0).min() > 1e-5
