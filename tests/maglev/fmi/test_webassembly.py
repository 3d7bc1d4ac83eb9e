"""FMUs as WebAssembly: the same C, and the same bits."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from command_line import maglev
from webassembly import CO_SIMULATION, WebAssemblyFmu, simulated

from maglev.cosim.fmu import Fmu
from maglev.files.errors import FmuError
from maglev.runs.preparation import Experiment
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import read_start_value
from maglev.user.source import FmuFile

# Every law, with encoders and without, sinusoids and steps.
RUNS = ("2dof-smooth-linear", "2dof-smooth-pid", "2dof-tracking-nonlinear", "3dof-smooth-scheduled",
        "3dof-setpoints-improved")


def test_a_module_asks_for_nothing_and_has_the_functions_of_fmi(wasm_fmus: Path) -> None:
    fmu = WebAssemblyFmu(wasm_fmus, "Plant3DOF")
    assert fmu.imports == []
    for name in ("fmi2Instantiate", "fmi2DoStep", "fmi2SetReal", "fmi2GetBoolean", "fmi2SerializeFMUstate", "malloc"):
        assert name in fmu.exports
    assert fmu.description.modelExchange is None, "derivatives would be a fifth of the page"
    assert (wasm_fmus / "Plant3DOF.wasm").read_bytes().find(b"maglev_scratch_") == -1


def test_the_same_sources_give_the_same_bytes(wasm_fmus: Path, tmp_path: Path) -> None:
    done = maglev("build", "--kind", "native", "--target", "wasm", "PID2DOF", "--fmus", tmp_path)
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


@pytest.mark.few(2)
@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize("rough", [False, True])
def test_a_run_has_the_bits_of_the_native_fmus(wasm_fmus: Path, native_fmus: Path, name: str, rough: bool) -> None:
    """Also on rough guides, whose tracks are the same."""
    plan = load_plan(name).model_copy(update={"stop_time": 1.2})
    if rough:
        plan.fmus["plant"].start.update({f"{axis}.{name}": read_start_value(0.1) for axis in plan.axes
                                         for name in ("roughness.rms", "friction.variation")})
    experiment = Experiment(plan, {part: FmuFile(native_fmus / f"{fmu.model}.fmu") for part, fmu in plan.fmus.items()},
                            plan.step)
    there = experiment.run(None).columns
    here = simulated(wasm_fmus, plan, experiment.drives(experiment.check()), plan.stop_time)
    for column, values in here.items():
        assert np.array_equal(values, there[column]), column
    assert max(np.ptp(values) for column, values in here.items() if column.endswith("position")) > 1e-3
