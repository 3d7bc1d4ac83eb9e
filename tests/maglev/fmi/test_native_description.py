"""Native FMUs as files: the descriptions of the pythonfmu FMUs except for what differs, and complete contents."""

import hashlib
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import pytest
from fmpy_validation import validate_fmu

from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.fmi.definition import ContinuousModel
from maglev.fmi.documentation import breakable

BUILD = ("import sys; from pathlib import Path; from maglev.scenario.catalogue import HOST, build; "
         "build(['PID2DOF'], Path(sys.argv[1]), HOST)")

# What may differ between the two kinds.
TOOL = {"guid", "generationTool"}
FMI_HEADERS = {"fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"}
CAPABILITIES = {"needsExecutionTool": ("true", "false"), "canNotUseMemoryManagementFunctions": ("true", "false")}


def description_of(fmu: Path) -> ElementTree.Element:
    """Root of an FMU's model description."""
    with zipfile.ZipFile(fmu) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


def leave_model_exchange(root: ElementTree.Element, variables: int, model: ContinuousModel | None) -> None:
    """Take out of a description what it has for model exchange: dependencies, and what is beyond so many variables."""
    exchange = root.find("ModelExchange")
    assert (exchange is None) is (model is None)
    if exchange is None or model is None:
        return
    root.remove(exchange)
    assert root.attrib.pop("numberOfEventIndicators") == str(len(model.indicators))
    experiment = root.find("DefaultExperiment")
    assert experiment is not None and float(experiment.attrib.pop("tolerance")) == 1e-8
    table = root.find("ModelVariables")
    structure = root.find("ModelStructure")
    assert table is not None and structure is not None
    added = table.findall("ScalarVariable")[variables:]
    assert [element.get("name") for element in added] == [v.name for v in model.variables]
    for element in added:
        table.remove(element)
    for real in table.iter("Real"):
        real.attrib.pop("derivative", None)
        real.attrib.pop("reinit", None)
    used = {real.get("unit") for real in table.iter("Real")}
    units = root.find("UnitDefinitions")
    assert units is not None
    for unit in [each for each in units if each.get("name") not in used]:
        units.remove(unit)
    derivatives = structure.find("Derivatives")
    assert derivatives is not None and len(derivatives) == len(model.states)
    structure.remove(derivatives)
    for unknown in structure.iterfind("Outputs/Unknown"):
        unknown.attrib.update(dependencies="")
    initial = structure.find("InitialUnknowns")
    assert initial is not None
    for unknown in [each for each in initial if int(each.attrib["index"]) > variables]:
        initial.remove(unknown)


@pytest.mark.parametrize("name", DEFINITIONS)
def test_description_is_that_of_the_python_fmu(fmus: Path, native_fmus: Path, name: str) -> None:
    """Names, value references, units, causalities, starts, dependencies: everything."""
    python, native = (description_of(folder / f"{name}.fmu") for folder in (fmus, native_fmus))
    for attribute in TOOL:
        assert python.attrib.pop(attribute) != native.attrib.pop(attribute)
    for attribute, (of_python, of_native) in CAPABILITIES.items():
        simulations = [root.find("CoSimulation") for root in (python, native)]
        assert [s.attrib.pop(attribute) for s in simulations if s is not None] == [of_python, of_native]
    simulation = native.find("CoSimulation")
    assert simulation is not None
    files = simulation.find("SourceFiles")
    assert files is not None
    simulation.remove(files)
    categories = native.find("LogCategories")
    assert categories is not None and python.find("LogCategories") is None, "pythonfmu gives messages no category"
    native.remove(categories)
    leave_model_exchange(native, len(python.findall("ModelVariables/ScalarVariable")), definition(name).continuous)
    texts = [ElementTree.canonicalize(ElementTree.tostring(root), strip_text=True) for root in (python, native)]
    assert texts[0] == texts[1]


@pytest.mark.few(14)
@pytest.mark.parametrize("name", DEFINITIONS)
def test_fmpy_validates(native_fmus: Path, name: str) -> None:
    assert validate_fmu(str(native_fmus / f"{name}.fmu")) == []


@pytest.mark.few(14)
@pytest.mark.parametrize("name", DEFINITIONS)
def test_default_experiment_runs_with_nothing_set(native_fmus: Path, name: str) -> None:
    result = fmpy.simulate_fmu(str(native_fmus / f"{name}.fmu"))
    experiment = definition(name).experiment
    assert result["time"][-1] == pytest.approx(experiment.stop_time)
    assert len(result) - 1 == round(experiment.stop_time / experiment.step) <= 1000


@pytest.mark.few(14)
@pytest.mark.parametrize("name", DEFINITIONS)
def test_tool_that_steps_a_500th_of_the_stop_time(native_fmus: Path, name: str) -> None:
    path, stop_time = str(native_fmus / f"{name}.fmu"), definition(name).experiment.stop_time
    result = fmpy.simulate_fmu(path, step_size=stop_time / 500, output_interval=stop_time / 500)
    assert len(result) == 501 and result["time"][-1] == pytest.approx(stop_time)


@pytest.mark.parametrize("name", DEFINITIONS)
def test_files_inside(native_fmus: Path, name: str) -> None:
    with zipfile.ZipFile(native_fmus / f"{name}.fmu") as archive:
        files = archive.namelist()
        texts = {file: archive.read(file).decode() for file in files if file.endswith((".c", ".h", ".txt", ".xml"))}
        png, page = archive.read("model.png"), archive.read("documentation/index.html").decode()
    assert files == sorted(files)
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    assert all(f'<th scope="row">{breakable(v.name)}</th>' in page for v in definition(name).variables)
    assert texts["documentation/licenses/license.txt"].startswith("MIT License")
    assert all(word in texts["documentation/licenses/fmi.txt"] for word in ("Modelica Association", "2-Clause BSD"))
    assert not any(file.startswith("resources/") for file in files), "nothing of Python is in it"
    # The sources are complete: all that is listed is there, all that is there is listed, all that is included is there,
    # except for the headers that FMI leaves to the importer (2.3).
    sources = {Path(file).name for file in files if file.startswith("sources/")}
    root = ElementTree.fromstring(texts["modelDescription.xml"])
    listed = [element.attrib["name"] for element in root.iterfind("CoSimulation/SourceFiles/File")]
    assert listed == sorted(source for source in sources if source.endswith(".c"))
    for file, text in texts.items():
        if file.startswith("sources/"):
            assert set(re.findall(r'^#include "(.*)"', text, re.MULTILINE)) <= sources | FMI_HEADERS, file
    assert not sources & FMI_HEADERS
    assert f"#define FMI2_FUNCTION_PREFIX {name}_\n" in texts["sources/prefix.h"]
    assert f'"{root.attrib["guid"]}"' in texts["sources/model.c"]


def test_guids_tell_the_fmus_apart(fmus: Path, native_fmus: Path) -> None:
    guids = [description_of(folder / f"{name}.fmu").attrib["guid"]
             for folder in (fmus, native_fmus) for name in DEFINITIONS]
    assert len(set(guids)) == 2 * len(DEFINITIONS)


def test_builds_are_reproducible(native_fmus: Path, tmp_path: Path) -> None:
    """Other folder, other working directory, other time zone, hash seed and temporary folder: the same bytes."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    environment = {**os.environ, "TZ": "Asia/Tokyo", "PYTHONHASHSEED": "7", "TMPDIR": str(temporary)}
    environment.pop("SOURCE_DATE_EPOCH", None)
    out = tmp_path / "elsewhere"
    subprocess.run([sys.executable, "-c", BUILD, str(out)], check=True, cwd=tmp_path, env=environment)
    digests = [hashlib.sha256((folder / "PID2DOF.fmu").read_bytes()).hexdigest() for folder in (native_fmus, out)]
    assert digests[0] == digests[1]
    assert list(temporary.iterdir()) == [], "nothing is left behind"
