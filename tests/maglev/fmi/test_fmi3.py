"""FMI 3.0: descriptions as of FMI 2.0, files that its schemas and tools take, platforms, what an importer may do."""

import ctypes
import re
import zipfile
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from command_line import error_line, maglev
from facts import raises
from fmpy.fmi1 import FMICallException
from fmpy.model_description import ModelDescription, ModelVariable, read_build_description
from fmpy_validation import names_parsed_once, validate_fmu
from lxml import etree
from native_binaries import windows_library
from native_builds import compiled, require_native_tools, unpacked_sources

from maglev.cosim.fmu import Fmu, read_description
from maglev.cosim.master import FmuSetup, Master
from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.fmi.compiler import PLATFORMS, library
from maglev.fmi.definition import read
from maglev.fmi.model_description import build_description, model_description, model_description_3, terminals_and_icons
from maglev.fmi.native_build import SHELLS
from maglev.language.errors import ExportError
from maglev.user.source import FmuFile, PythonClass

SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"
ARM64_WINDOWS = 0xAA64   # of PE
STEP = 2e-4              # s, sample time of the regulator

MEASURED = [(f"plant.{axis}.encoder", f"controller.{axis}.measured") for axis in "yxz"]
COMMANDED = [(f"controller.{motor}.i_{phase}_cmd", f"plant.{motor}.i_{phase}_cmd")
             for motor in ("alpha", "beta") for phase in "abc"]


def described(folder: Path, text: bytes) -> ModelDescription:
    """A model description that fmpy has held to the schema of its version."""
    path = folder / "modelDescription.xml"
    path.write_bytes(text)
    with names_parsed_once():
        return fmpy.read_model_description(str(path), validate_variable_names=True, validate_model_structure=True)


def told(variable: ModelVariable) -> tuple[object, ...]:
    """What both versions say of a variable."""
    return (variable.name, variable.valueReference, variable.type.replace("Float64", "Real"), variable.causality,
            variable.variability, variable.initial, variable.start, variable.unit, variable.displayUnit, variable.min,
            variable.max, variable.nominal, variable.description)


@pytest.mark.few(8)
@pytest.mark.parametrize("name", DEFINITIONS)
@pytest.mark.usefixtures("slow")
def test_description_is_that_of_fmi_2_with_the_time(tmp_path: Path, name: str) -> None:
    block = definition(name)
    older = described(tmp_path, model_description(block, "{k}", "1", 0, ["a.c"]))
    newer = described(tmp_path, model_description_3(block, "{k}", "1", 0))
    assert [told(v) for v in newer.modelVariables[:-1]] == [told(v) for v in older.modelVariables]
    time = newer.modelVariables[-1]
    assert (time.name, time.causality, time.valueReference) == ("time", "independent", len(older.modelVariables))
    for kind in ("outputs", "initialUnknowns", *(["derivatives"] if block.continuous else [])):
        one, other = ([(u.variable.name, [v.name for v in u.dependencies or ()], u.dependenciesKind or [])
                       for u in getattr(each, kind)] for each in (older, newer))
        assert one == other and one
    if block.continuous:
        assert {u.variable.name: {v.name for v in u.dependencies} for u in newer.eventIndicators} == {
            name: {*knowns} for name, knowns in block.continuous.indicators.items()}
        for each in (older, newer):
            assert {state.derivative: state.variable for state in block.continuous.states} == {
                v.name: v.derivative.name for v in each.modelVariables if v.derivative is not None}
    assert (older.coSimulation.canHandleVariableCommunicationStepSize
            is newer.coSimulation.canHandleVariableCommunicationStepSize)
    samples = newer.coSimulation.fixedInternalStepSize
    assert samples == (repr(read(block.new_block(), block.sampling)) if block.sampling else None)


class Gain:
    """A user's class, without samples."""

    inputs = {"u": "m", "time": ""}
    outputs = {"y": "m", "clock": ""}

    y = u = time = clock = 0.0

    def step(self, t: float, dt: float) -> None:
        """Leave all as it is."""


@pytest.mark.parametrize("unit", ["", "m"])
def test_units_of_a_class_of_the_user(tmp_path: Path, unit: str) -> None:
    """None at all, of which FMI has no list; or any but that of the time."""
    written = type("Gain", (Gain,), {"inputs": {"u": unit}, "outputs": {"y": unit}})
    block = PythonClass(written).load().definition
    of_fmi_2 = described(tmp_path, model_description(block, "{k}", "1", 0))
    of_fmi_3 = described(tmp_path, model_description_3(block, "{k}", "1", 0))
    assert [unit.name for unit in of_fmi_2.unitDefinitions] == [unit] * bool(unit)
    assert [unit.name for unit in of_fmi_3.unitDefinitions] == [unit, "s"][not unit:]


@pytest.mark.parametrize(("name", "clocked"), [("time", False), ("clock", True)])
def test_a_name_that_fmi_3_has(name: str, clocked: bool) -> None:
    table = {"sample_time": 0.1, "step": lambda self, t: None, "inputs": {"u": ""} if clocked else Gain.inputs}
    block = PythonClass(type("Gain", (Gain,), table)).load().definition
    with raises(ExportError, "Gain", "FMI 3.0", name):
        model_description_3(replace(block, clocked=clocked), "{k}", "1", 0)


@pytest.mark.parametrize("name", DEFINITIONS)
def test_terminals_are_of_inputs_and_outputs(name: str) -> None:
    block = definition(name)
    root = etree.fromstring(terminals_and_icons(block))
    etree.XMLSchema(file=str(SCHEMAS / "fmi3TerminalsAndIcons.xsd")).assertValid(root)
    members = [element.get("variableName") for element in root.iter("TerminalMemberVariable")]
    exchanged = [v.name for v in block.variables if v.causality in ("input", "output") and "." in v.name]
    assert sorted(members) == sorted(exchanged) and members
    of = {terminal.get("name"): terminal for terminal in root.iter("Terminal")}
    for terminal in of.values():
        names = [element.get("memberName") for element in terminal]
        assert len(set(names)) == len(names)


def test_build_description_is_valid() -> None:
    root = etree.fromstring(build_description("M", ["a.c", "b.c"]).encode())
    etree.XMLSchema(file=str(SCHEMAS / "fmi3BuildDescription.xsd")).assertValid(root)


def test_files_inside(fmi3_fmus: Path, tmp_path: Path) -> None:
    path = fmi3_fmus / "Plant3DOF.fmu"
    assert validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as archive:
        files = set(archive.namelist())
        assert archive.read("terminalsAndIcons/icon.png").startswith(b"\x89PNG")
        icon = etree.fromstring(archive.read("terminalsAndIcons/icon.svg"))
        assert icon.tag == "{http://www.w3.org/2000/svg}svg" and len(icon) > 4, "expected a drawing"
    listed = read_build_description(path)[0].sourceFileSets[0].sourceFiles
    assert {f"sources/{file}" for file in listed} == {file for file in files if file.endswith(".c")}
    assert {file.partition("/")[0] for file in files} == {"modelDescription.xml", "binaries", "documentation",
                                                          "sources", "terminalsAndIcons", "extra"}
    # As the build description has it: a shared library of the sources, under a strict compiler.
    sources = unpacked_sources(path, tmp_path)
    made = compiled(sources, tmp_path / "plant.so", "-shared", "-fPIC", "-DFMI3_OVERRIDE_FUNCTION_PREFIX")
    header = (Path(fmpy.__file__).parent / "c-code" / "fmi3Functions.h").read_text()
    functions = re.findall(r"^FMI3_Export +fmi3\w+TYPE +(fmi3\w+);", header, re.MULTILINE)
    library_of_sources = ctypes.CDLL(str(made))
    assert len(functions) == 75 and [name for name in functions if not hasattr(library_of_sources, name)] == []


def test_platforms() -> None:
    """FMI 3.0, section 2.5.1.5.1; that FMI 2.0's compile, test_native_binaries says, and the targets are the same."""
    assert set(SHELLS[3].platforms) == {f"{processor}-{system}" for processor in ("x86_64", "aarch64")
                                        for system in ("linux", "windows", "darwin")}
    of_fmi_2 = {target for each in SHELLS[2].platforms.values() for target in each.targets}
    assert {target for each in SHELLS[3].platforms.values() for target in each.targets} - of_fmi_2 \
        == set(PLATFORMS["aarch64-windows"].targets)


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
def test_windows_on_arm() -> None:
    """Its C library is compiled for this alone."""
    require_native_tools()
    made = library({"one.c": "__declspec(dllexport) double one(void) { return 1.0; }"}, "one",
                   PLATFORMS["aarch64-windows"])
    assert windows_library(made).processor == ARM64_WINDOWS


def simulated(plant: Path, controller: Path) -> dict[str, np.ndarray]:
    """Columns of 0.1 s with a step of a reference."""
    with Master([FmuSetup("controller", controller / "Regulator3DOF.fmu"), FmuSetup("plant", plant / "Plant3DOF.fmu")],
                [*MEASURED, *COMMANDED], STEP) as master:
        drives = {"controller.y.reference": np.where(np.arange(501) < 50, 0.025, 0.0252)}
        return dict(master.run(0.1, drives).columns)


def test_versions_run_mixed_with_the_same_bits(native_fmus: Path, fmi3_fmus: Path) -> None:
    expected = simulated(native_fmus, native_fmus)
    assert np.ptp(expected["plant.y.position"]) > 1e-5
    for plant, controller in ((fmi3_fmus, fmi3_fmus), (native_fmus, fmi3_fmus), (fmi3_fmus, native_fmus)):
        columns = simulated(plant, controller)
        assert columns.keys() == expected.keys()
        for name, column in columns.items():
            assert column.dtype == expected[name].dtype, name
            assert column.tobytes() == expected[name].tobytes(), name


def started(folder: Path, name: str) -> Fmu:
    """An instance after its initialization."""
    path = folder / f"{name}.fmu"
    fmu = Fmu(name, FmuFile(path), read_description(name, path))
    fmu.initialise({}, 0.0, 1.0)
    return fmu


@pytest.mark.parametrize(("call", "reason"), [
    (lambda i: i.doStep(0.0, -1.0), "communication step = -1.0 s, expected a positive, finite step"),
    (lambda i: i.enterEventMode(), "fmi3EnterEventMode of an instance for co-simulation, expected one for model"),
    (lambda i: i.exitInitializationMode(), "fmi3ExitInitializationMode in step mode, expected in the"),
    (lambda i: i.getFloat64([10**6]), "value reference = 1000000, expected 0 to"),
    (lambda i: i.getFloat64([0], nValues=2), "fmi3GetFloat64 of 1 variables with 2 values, expected 1"),
    (lambda i: i.setFloat32([0], [1.0]), "fmi3SetFloat32 of 1 variables, expected Float64 or Boolean variables"),
    (lambda i: i.setFloat64([next(iter(i.time))], [1.0]), "time is independent, expected an input or a parameter")])
def test_what_is_refused(fmi3_fmus: Path, call: object, reason: str) -> None:
    with started(fmi3_fmus, "Plant3DOF") as fmu:
        fmu.instance.time = [fmu.variable("time").valueReference]
        with pytest.raises(FMICallException):
            call(fmu.instance)   # type: ignore[operator]
        assert reason in fmu.said()


def test_event_mode_is_refused(fmi3_fmus: Path) -> None:
    with started(fmi3_fmus, "Plant3DOF") as fmu, pytest.raises(Exception, match="Failed to instantiate"):
        said: list[bytes] = []
        fmu.instance.instantiate(eventModeUsed=True, logMessage=lambda *message: said.append(message[-1]))
    assert b"this FMU has no event mode" in said[0]


def test_a_run_equals_the_baseline(fmi3_fmus: Path, tmp_path: Path) -> None:
    (tmp_path / "fmi3").symlink_to(fmi3_fmus)
    done = maglev("check", "3dof-setpoints", "--kind", "native", "--fmi", "3", "--fmus", tmp_path)
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize(("arguments", "reason"), [
    (("build", "--fmi", "3", "Plant2DOF"), "fmi = 3: expected 2, or 3 with kind = native"),
    (("run", "2dof-setpoints", "--kind", "python", "--fmi", "3"),
     "fmi = 3: expected 2, or 3 with kind = native"),
    (("build", "--kind", "native", "--fmi", "3", "--target", "wasm", "Plant2DOF"),
     "fmi = 3: expected 2 with target = wasm")])
def test_where_there_is_no_fmi_3(arguments: tuple[str, ...], reason: str, tmp_path: Path) -> None:
    assert reason in error_line(maglev(*arguments, "--fmus", tmp_path))
