"""What tools expect of the files: valid descriptions, runs with nothing set, reproducible bytes, documentation."""

import hashlib
import os
import subprocess
import sys
import zipfile
from importlib.resources import files
from pathlib import Path

import fmpy
import pytest
from facts import raises
from fmpy_validation import validate_fmu

from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.files.errors import BuildError
from maglev.fmi.binaries import CORRECTIONS, corrected
from maglev.fmi.documentation import breakable
from maglev.language.errors import ExportError
from maglev.scenario.catalogue import build

BUILD = ("import sys; from pathlib import Path; from maglev.scenario.catalogue import build; "
         "from maglev.descriptions.own_fmus import DEFINITIONS; build(DEFINITIONS, Path(sys.argv[1]))")

# Without a unit.
RATIOS = ("attraction_modulation", "gamma", "seed", "guide_seed", "convergence.tolerance", "adaptation.range",
          "geometry.recoil_permeability")
OF_AXES = (".mode.damping", ".mode.mass_share", ".mode.encoder_share", ".friction.variation")


@pytest.mark.few(8)
@pytest.mark.parametrize("name", DEFINITIONS)
def test_fmpy_validates(fmus: Path, name: str) -> None:
    assert validate_fmu(str(fmus / f"{name}.fmu")) == []


# That of the closed loops is long: tests/closed_loop_fmu runs the native ones.
@pytest.mark.few(9)
@pytest.mark.parametrize("name", [name for name in DEFINITIONS if not name.startswith("ClosedLoop")])
def test_default_experiment_runs_with_nothing_set(fmus: Path, name: str) -> None:
    result = fmpy.simulate_fmu(str(fmus / f"{name}.fmu"))
    experiment = definition(name).experiment
    assert experiment.stop_time / 500 == experiment.step, "many tools take that for their step"
    assert result["time"][-1] == pytest.approx(experiment.stop_time)
    # fmpy doubles the interval of a default experiment beyond 1000 steps, which a controller would refuse.
    assert len(result) - 1 == round(experiment.stop_time / experiment.step) <= 1000


@pytest.mark.parametrize("name", DEFINITIONS)
def test_description_is_complete(fmus: Path, name: str) -> None:
    description = fmpy.read_model_description(str(fmus / f"{name}.fmu"))
    units = {u.name for u in description.unitDefinitions}
    assert description.variableNamingConvention == "structured"
    assert description.generationDateAndTime.endswith("Z")
    for v in description.modelVariables:
        assert v.description, v.name
        if v.type == "Real":
            assert v.nominal is not None, v.name
            own = v.name.removeprefix("plant.").removeprefix("controller.")
            assert v.unit in units or own in RATIOS or own.endswith((".lost", *OF_AXES)), v.name
            if v.causality != "output":
                assert float(v.min) <= float(v.start) <= float(v.max), v.name
    controller = not name.startswith("Plant")
    assert description.coSimulation.canHandleVariableCommunicationStepSize is not controller
    assert description.coSimulation.canGetAndSetFMUstate and description.coSimulation.canSerializeFMUstate
    fixed = {v.name.removeprefix("controller.") for v in description.modelVariables if v.variability == "fixed"}
    if controller:
        observer = set() if name.startswith(("Commutation", "Measurement")) else {"observer.time1", "observer.time2"}
        assert fixed >= {"sample_time"} | observer
        assert fixed & {v.name for v in description.modelVariables if v.name.endswith((".kp", ".k1", ".ec1"))} == set()
        computed = [u for u in description.outputs if u.variable.name.endswith(("_cmd", "_converged", "measured"))]
        assert computed and all(u.dependencies for u in computed)
    else:
        assert all(u.dependencies == [] for u in description.outputs), "a state separates outputs from inputs"


def test_commands_depend_on_the_right_inputs(fmus: Path) -> None:
    description = fmpy.read_model_description(str(fmus / "Regulator3DOF.fmu"))
    of = {u.variable.name: {v.name for v in u.dependencies} for u in description.outputs}
    assert of["beta.i_q_cmd"] == {"z.reference", "z.reference_rate", "z.measured", "y.measured"}
    assert "x.measured" in of["beta.i_d_cmd"], "the direct current makes up for both quadrature currents"
    assert of["y.error"] == {"y.reference", "y.measured"}


@pytest.mark.parametrize("name", DEFINITIONS)
def test_files_inside(fmus: Path, name: str) -> None:
    with zipfile.ZipFile(fmus / f"{name}.fmu") as archive:
        files = archive.namelist()
        page = archive.read("documentation/index.html").decode()
        licence = archive.read("documentation/licenses/license.txt").decode()
        png = archive.read("model.png")
    assert files == sorted(files)
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    assert licence.startswith("MIT License")
    assert "Copyright" in zipfile.ZipFile(fmus / f"{name}.fmu").read("documentation/licenses/pythonfmu.txt").decode()
    for v in definition(name).variables:
        assert f'<th scope="row">{breakable(v.name)}</th>' in page
        assert v.source or v.causality != "parameter", f"{v.name}: where is its value from?"
    assert any(source in page for source in ("(4.12)", "(5.7)", "(4.3)", "(5.2)", "sections 4.1.2",
                                             "section 4.6.1", "sections 4.6.1", "Figs. 4.6, 5.6"))
    assert {f"binaries/linux64/{name}.so", f"binaries/win64/{name}.dll"} <= set(files)


@pytest.mark.parametrize("name", DEFINITIONS)
def test_no_file_that_a_tool_refuses(either_kind: Path, name: str) -> None:
    """FMI Library, which FMUChecker and PyFMI rest on, refuses terminalsAndIcons.xml, whose schema is FMI 3.0's."""
    with zipfile.ZipFile(either_kind / f"{name}.fmu") as archive:
        places = {file.split("/")[0] for file in archive.namelist()}
    assert {"modelDescription.xml", "model.png", "documentation", "binaries"} < places
    assert places <= {"modelDescription.xml", "model.png", "documentation", "binaries", "sources", "resources", "extra"}


def test_version_is_the_packages(fmus: Path) -> None:
    from importlib.metadata import version
    assert fmpy.read_model_description(str(fmus / "Plant2DOF.fmu")).version == version("maglev-fmus")


@pytest.mark.thorough
def test_builds_are_reproducible(fmus: Path, tmp_path: Path) -> None:
    """Other folder, other working directory, other time zone and hash seed: the same bytes."""
    env = {**os.environ, "TZ": "Asia/Tokyo", "PYTHONHASHSEED": "7"}
    env.pop("SOURCE_DATE_EPOCH", None)
    out = tmp_path / "elsewhere"
    subprocess.run([sys.executable, "-c", BUILD, str(out)], check=True, cwd=tmp_path, env=env)
    for name in DEFINITIONS:
        digests = [hashlib.sha256((folder / f"{name}.fmu").read_bytes()).hexdigest() for folder in (fmus, out)]
        assert digests[0] == digests[1], name


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("epoch", ["0", "soon"])
def test_source_date_epoch_that_is_odd(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, epoch: str) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    if epoch.isdigit():
        build(["Plant2DOF"], tmp_path)
        assert fmpy.read_model_description(str(tmp_path / "Plant2DOF.fmu")).generationDateAndTime.startswith("1970")
    else:
        with raises(BuildError, "SOURCE_DATE_EPOCH", "'soon'"):
            build(["Plant2DOF"], tmp_path)
        assert list(tmp_path.iterdir()) == []


def test_linux_binary_differs_from_pythonfmus_where_it_is_corrected(fmus: Path) -> None:
    original = files("pythonfmu").joinpath("resources", "binaries", "linux64", "libpythonfmu-export.so").read_bytes()
    with zipfile.ZipFile(fmus / "Plant2DOF.fmu") as archive:
        ours = archive.read("binaries/linux64/Plant2DOF.so")
    assert len(ours) == len(original)
    places = {original.index(code) + place + i for code, place, instead in CORRECTIONS for i in range(len(instead))}
    assert {i for i, (a, b) in enumerate(zip(ours, original, strict=True)) if a != b} <= places
    assert len(places) == sum(len(instead) for *_, instead in CORRECTIONS), "none undoes another"
    with raises(ExportError, "Linux"):
        corrected(ours)


@pytest.mark.usefixtures("slow")
def test_source_date_epoch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    build(["Plant2DOF"], tmp_path)
    description = fmpy.read_model_description(str(tmp_path / "Plant2DOF.fmu"))
    assert description.generationDateAndTime == "2001-09-09T01:46:40Z"
    with zipfile.ZipFile(tmp_path / "Plant2DOF.fmu") as archive:
        assert {i.date_time[0] for i in archive.infolist()} == {2001}
