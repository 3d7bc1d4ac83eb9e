"""Closed loops as one FMU: bit for bit the runs of our master, valid, reproducible, documented."""

import os
import runpy
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.util import read_csv
from fmpy.validation import validate_fmu
from native_builds import built_once

from fmi_export.container import Container, build_container
from fmi_export.errors import ExportError
from maglev.catalogue import CONTAINERS, build, build_containers, container
from maglev.cosim.fmu import Fmu, read_description
from maglev.errors import BuildError, FmuError
from maglev.experiment.preparation import prepare
from maglev.experiment.results import write_csv
from maglev.schema.layers import PACKAGED
from maglev.schema.loading import load_plan

INPUTS = PACKAGED / "inputs"
INPUT_FILE = {"ClosedLoop2DOF": INPUTS / "2dof-setpoints.csv", "ClosedLoop3DOF": INPUTS / "3dof-setpoints.csv"}
BUILD = ("import sys; from pathlib import Path; from maglev.catalogue import CONTAINERS, build_containers; "
         "build_containers(CONTAINERS, Path(sys.argv[1]), Path(sys.argv[2]))")


@pytest.fixture(scope="session")
def containers(native_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with every container."""
    if find_spec("fmu_manipulation_toolbox") is None:
        pytest.skip("fmu-manipulation-toolbox is not installed (extra `native`)")
    return built_once(tmp_path_factory, "containers", lambda folder: build_containers(CONTAINERS, native_fmus, folder))


@pytest.mark.parametrize("name", CONTAINERS)
def test_fmpy_validates(containers: Path, name: str) -> None:
    assert validate_fmu(str(containers / f"{name}.fmu")) == []


@pytest.mark.parametrize(("name", "run", "settings", "every"), [
    ("ClosedLoop2DOF", "2dof-setpoints", [], 1),
    ("ClosedLoop3DOF", "3dof-setpoints-improved", [], 1),
    # A longer communication step, over which the container does several steps.
    ("ClosedLoop3DOF", "3dof-setpoints-improved", [], 5),
    # Parameters, and a start elsewhere than where the controller's inputs start.
    ("ClosedLoop3DOF", "3dof-setpoints", ["plant.y.position_start=23.456mm", "plant.x.friction.coulomb=1N"], 1),
    ("ClosedLoop2DOF", "2dof-setpoints-low-overshoot", ["plant.v.position_start=18.1mm"], 1),
])
def test_the_committed_inputs_give_the_run_of_our_master_bit_for_bit(
        containers: Path, native_fmus: Path, name: str, run: str, settings: Sequence[str], every: int) -> None:
    plan = load_plan(run).model_copy(update={"stop_time": 3.0})
    experiment = prepare(plan, native_fmus, {}, settings)
    expected = experiment.run()
    # The defaults of a container are those of the scenario that it is made of.
    start = {} if run == CONTAINERS[name] else {
        f"{part}.{variable}": value.value for part, fmu in experiment.plan.fmus.items()
        for variable, value in fmu.start.items()}
    result = fmpy.simulate_fmu(str(containers / f"{name}.fmu"), input=read_csv(INPUT_FILE[name]), start_values=start,
                               output_interval=every * plan.step, stop_time=3.0)
    references = {axis.reference for axis in plan.axes.values()}
    assert set(result.dtype.names) == {"time", *expected.columns} - references
    for column in set(result.dtype.names) - {"time"}:
        assert result[column].astype(np.float64).tobytes() == \
            expected.columns[column][::every].astype(np.float64).tobytes(), column
    for axis in plan.axes.values():
        assert np.ptp(result[axis.position]) > 1e-3, "the step at 1 s is in it"


@pytest.mark.parametrize("name", CONTAINERS)
def test_input_files_say_what_the_scenario_says(name: str, tmp_path: Path) -> None:
    script = runpy.run_path(str(Path(__file__).parents[2] / "tools" / "write_inputs.py"))
    assert script["FILES"] == {path.name: each for each, path in INPUT_FILE.items()}
    recording = script["inputs"](name)
    write_csv(tmp_path / "inputs.csv", recording)
    assert (tmp_path / "inputs.csv").read_bytes() == INPUT_FILE[name].read_bytes()
    plan = load_plan(CONTAINERS[name])
    for t in np.arange(0.0, plan.stop_time, 0.1):
        row = np.searchsorted(recording.time, t + 1e-9, side="right") - 1
        for signal in plan.signals:
            assert recording.columns[signal.to.partition(".")[2]][row] == signal.value(t)


@pytest.mark.parametrize("name", CONTAINERS)
def test_description_is_complete(containers: Path, name: str) -> None:
    description = fmpy.read_model_description(str(containers / f"{name}.fmu"))
    plan = load_plan(CONTAINERS[name])
    assert float(description.defaultExperiment.stopTime) == plan.stop_time == 26.0
    assert float(description.defaultExperiment.stepSize) == plan.step
    assert not description.coSimulation.canHandleVariableCommunicationStepSize
    units = {unit.name for unit in description.unitDefinitions}
    for v in description.modelVariables:
        assert v.description, v.name
        if v.type == "Real":
            assert v.unit in units or v.name == "plant.attraction_modulation", v.name
            if v.causality != "output":
                assert float(v.min) <= float(v.start) <= float(v.max), v.name
    of = {kind: {v.name for v in description.modelVariables if v.causality == kind}
          for kind in ("input", "output", "parameter")}
    axes = list(plan.axes)
    assert of["input"] == {f"{axis}.{port}" for axis in axes for port in ("reference", "reference_rate", "force")}
    assert of["output"] >= {f"plant.{axis}.position" for axis in axes} | {"plant.at_stop", "controller.tripped"}
    assert of["parameter"] >= {f"plant.{axis}.mass" for axis in axes} | {f"controller.{axis}.k1" for axis in axes}
    assert {u.variable.name for u in description.initialUnknowns} == of["output"]
    assert {v.name for v in description.modelVariables if v.variability == "discrete" and v.causality == "input"} == {
        f"{axis}.{port}" for axis in axes for port in ("reference", "reference_rate")}


@pytest.mark.parametrize("name", CONTAINERS)
def test_files_inside(containers: Path, name: str) -> None:
    with zipfile.ZipFile(containers / f"{name}.fmu") as archive:
        files = archive.namelist()
        page = archive.read("documentation/index.html").decode()
        licence = archive.read("documentation/licenses/fmu-manipulation-toolbox.txt").decode()
    assert files == sorted(files)
    assert "Renault" in licence and "Redistribution" in licence
    assert "documentation/licenses/license.txt" in files and "documentation/licenses/fmi.txt" in files
    for i, (component, model) in enumerate(container(name).components.items()):
        assert f"resources/{i:02x}/documentation/index.html" in files
        assert f"<code>{component}</code>" in page and model in page
    assert list(container(name).components) == ["controller", "plant"], "the controller samples before the plant moves"


def test_builds_are_reproducible(containers: Path, native_fmus: Path, tmp_path: Path) -> None:
    """Other folder, other working directory, other user, time zone and hash seed: the same bytes."""
    env = {**os.environ, "TZ": "Asia/Tokyo", "PYTHONHASHSEED": "7", "LOGNAME": "somebody"}
    env.pop("SOURCE_DATE_EPOCH", None)
    done = subprocess.run([sys.executable, "-c", BUILD, str(native_fmus), str(tmp_path / "elsewhere")], check=True,
                          cwd=tmp_path, env=env, capture_output=True, text=True)
    assert done.stdout == done.stderr == "", "the toolbox's warning of the loop is no news"
    for name in CONTAINERS:
        path = f"{name}.fmu"
        assert (containers / path).read_bytes() == (tmp_path / "elsewhere" / path).read_bytes(), name
    assert sorted(path.name for path in native_fmus.iterdir() if name in path.name) == [], "nothing is left behind"


def test_refusals_of_a_component_are_logged(containers: Path) -> None:
    """With logging on, which `Component` has: without it the toolbox swallows what its components say."""
    path = containers / "ClosedLoop3DOF.fmu"
    loop = Fmu("loop", path, read_description("loop", path))
    try:
        with pytest.raises(FmuError, match=r"y\.mass = -1\.0 kg, expected a number from 0\.001"):
            loop.initialise({"plant.y.mass": -1.0}, 0.0, 1.0)
    finally:
        loop.close()


def test_inputs_of_the_same_name_are_refused(containers: Path, native_fmus: Path, tmp_path: Path) -> None:
    twice = Container("Twice", "", {"one": "Plant2DOF", "two": "Plant2DOF"}, (), 0.0005, 1.0)
    with pytest.raises(ExportError, match=r"Twice: one and two both have an input motor\.i_a_cmd .* different names"):
        build_container(twice, native_fmus, "", "", tmp_path)


def test_another_processor_is_refused(containers: Path, native_fmus: Path, tmp_path: Path) -> None:
    for model in ("Regulator2DOF", "Plant2DOF"):
        with (zipfile.ZipFile(native_fmus / f"{model}.fmu") as source,
              zipfile.ZipFile(tmp_path / f"{model}.fmu", "w") as target):
            for name in source.namelist():
                if not name.startswith("binaries/"):
                    target.writestr(name, source.read(name))
            target.writestr(f"binaries/linux64/{model}.so", b"\x7fELF" + bytes(14) + b"\xb7\x00")   # AArch64
    with pytest.raises(ExportError, match="ClosedLoop2DOF: the toolbox has no container for the processor"):
        build_containers(["ClosedLoop2DOF"], tmp_path, tmp_path)
    assert not (tmp_path / "ClosedLoop2DOF.fmu").exists()


def test_without_the_toolbox(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fmi_export.container.find_spec", lambda name: None)
    with pytest.raises(ExportError, match="needs fmu-manipulation-toolbox, expected it to be installed: pip install"):
        build_containers(["ClosedLoop2DOF"], tmp_path, tmp_path)


def test_a_container_is_no_python_fmu(tmp_path: Path) -> None:
    with pytest.raises(BuildError, match="ClosedLoop2DOF is made of native FMUs, expected --native with it"):
        build(["ClosedLoop2DOF"], tmp_path)


def test_a_container_of_fmus_in_python_is_the_same(containers: Path, fmus: Path, tmp_path: Path) -> None:
    """It steps the other kind of FMU in the importer's Python."""
    build_containers(["ClosedLoop3DOF"], fmus, tmp_path)
    results = [fmpy.simulate_fmu(str(folder / "ClosedLoop3DOF.fmu"), input=read_csv(str(INPUT_FILE["ClosedLoop3DOF"])),
                                 output_interval=2e-4, stop_time=5.0) for folder in (containers, tmp_path)]
    assert len(results[0]) == 25001
    for name in results[0].dtype.names:
        assert np.array_equal(results[0][name], results[1][name]), name
    assert fmpy.read_model_description(str(tmp_path / "ClosedLoop3DOF.fmu")).coSimulation.needsExecutionTool
