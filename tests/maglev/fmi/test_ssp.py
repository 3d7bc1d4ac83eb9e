"""The system structure files: valid, complete, and with the start values that the FMUs have anyway."""

import zipfile
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element, fromstring

import fmpy
import fmpy.ssp.ssd
import pytest
from command_line import maglev
from facts import raises
from lxml import etree

from maglev.descriptions.own_fmus import SYSTEMS, definition
from maglev.fmi.parameter_set import SSC, SSV, Value, parameter_set, xml_file
from maglev.fmi.ssp import SSD, add_units, write_ssp
from maglev.language.errors import ExportError
from maglev.scenario.catalogue import build_systems
from maglev.scenario.loading import load_plan

SCHEMA = Path(fmpy.__file__).parent / "ssp" / "schema" / "SystemStructureDescription.xsd"
FILES = [f"{system}{ports}.ssp" for system in SYSTEMS for ports in ("", "NoPorts")]


@pytest.fixture(scope="module")
def systems(fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the systems of FMUs in Python."""
    folder = tmp_path_factory.mktemp("systems")
    build_systems(SYSTEMS, fmus, folder)
    return folder


def structure(path: Path) -> Element:
    """System in an SSP file."""
    with zipfile.ZipFile(path) as archive:
        system = fromstring(archive.read("SystemStructure.ssd")).find(f"{{{SSD}}}System")
    assert system is not None
    return system


@pytest.mark.parametrize("file", FILES)
def test_schema(systems: Path, file: str) -> None:
    with zipfile.ZipFile(systems / file) as archive:
        document = etree.fromstring(archive.read("SystemStructure.ssd"))
    etree.XMLSchema(etree.parse(str(SCHEMA))).assertValid(document)
    assert len(fmpy.ssp.ssd.read_ssd(str(systems / file)).system.elements) == 2


@pytest.mark.parametrize("file", FILES)
def test_connections_are_those_of_the_scenario(systems: Path, file: str) -> None:
    system = structure(systems / file)
    ends = [[connection.get(key) for key in ("startElement", "startConnector", "endElement", "endConnector")]
            for connection in system.iter(f"{{{SSD}}}Connection")]
    inner = [(f"{a}.{b}", f"{c}.{d}") for a, b, c, d in ends if a is not None and c is not None]
    plan = load_plan(SYSTEMS[file.removesuffix(".ssp").removesuffix("NoPorts")])
    assert inner == [tuple(each) for each in plan.connections]
    ports = {connector.get("name") for connector in system.findall(f"{{{SSD}}}Connectors/{{{SSD}}}Connector")}
    assert ports == {b if a is None else d for a, b, c, d in ends if a is None or c is None}
    assert bool(ports) == ("NoPorts" not in file)
    assert not ports or {f"{axis}.{port}" for axis in plan.axes for port in ("reference", "position")} <= ports


@pytest.mark.parametrize("file", FILES)
def test_components_say_what_their_fmus_say(systems: Path, fmus: Path, file: str) -> None:
    """Units and start values in the file are those in the model descriptions."""
    for component in structure(systems / file).iter(f"{{{SSD}}}Component"):
        source = component.get("source", "")
        description = fmpy.read_model_description(str(fmus / source.removeprefix("resources/")))
        with zipfile.ZipFile(systems / file) as archive:
            assert archive.read(source) == (fmus / source.removeprefix("resources/")).read_bytes()
        connectors = {c.get("name"): c for c in component.iter(f"{{{SSD}}}Connector")}
        parameters = {p.get("name"): p[0] for p in component.iter(f"{{{SSV}}}Parameter")}
        assert set(connectors) == {v.name for v in description.modelVariables}
        for v in description.modelVariables:
            typed = connectors[v.name][0]
            assert connectors[v.name].get("kind") == v.causality
            assert typed.tag == f"{{{SSC}}}{v.type}" and typed.get("unit") == v.unit
            if v.causality == "output":
                assert v.name not in parameters
            else:
                assert parameters[v.name].get("value") == v.start and parameters[v.name].get("unit") == v.unit


@pytest.mark.parametrize("system", SYSTEMS)
def test_start_values_are_those_of_the_scenario_and_of_the_fmus(system: str) -> None:
    """A tool that leaves out the start values of the file runs the same: the references start where the stage is."""
    plan = load_plan(SYSTEMS[system])
    blocks = {name: definition(str(fmu.model)) for name, fmu in plan.fmus.items()}
    starts = {f"{name}.{v.name}": fmu.start_value(v) for name, fmu in blocks.items() for v in fmu.variables}
    for name, fmu in plan.fmus.items():
        for variable, start in fmu.start.items():
            assert starts[f"{name}.{variable}"] == start.value, variable
    for axis in plan.axes:
        at = starts[f"plant.{axis}.position_start"]
        assert starts[f"controller.{axis}.reference"] == starts[f"controller.{axis}.measured"] == at
        assert next(s for s in plan.signals if s.to == f"controller.{axis}.reference").value(0.0) == at


@pytest.mark.parametrize("file", FILES)
def test_it_can_be_looked_at(systems: Path, file: str) -> None:
    """Components lie side by side within the system, and each of their inputs and outputs has a place of its own."""
    system = structure(systems / file)
    def box(element: Element, kind: str) -> list[float]:
        found = element.find(f"{{{SSD}}}{kind}")
        assert found is not None
        return [float(found.attrib[key]) for key in ("x1", "y1", "x2", "y2")]

    x1, y1, x2, y2 = box(system, "SystemGeometry")
    right = x1
    components = list(system.iter(f"{{{SSD}}}Component"))
    for component in components:
        left, bottom, end, top = box(component, "ElementGeometry")
        assert right < left < end < x2 and y1 < bottom < top < y2
        right = end
    for owner in [*components, *([system] if "NoPorts" not in file else [])]:
        places = []
        for connector in owner.findall(f"{{{SSD}}}Connectors/{{{SSD}}}Connector"):
            place = connector.find(f"{{{SSD}}}ConnectorGeometry")
            assert (place is None) == (connector.get("kind") == "parameter")
            if place is not None:
                places.append((place.attrib["x"], float(place.attrib["y"])))
                assert place.attrib["x"] == {"input": "0.0", "output": "1.0"}[connector.attrib["kind"]]
        assert all(0.0 < y < 1.0 for _, y in places)
        assert len(places) == len(set(places)) > 0


def test_ssp_2_of_fmi_3(fmi3_fmus: Path, systems: Path, tmp_path: Path) -> None:
    """The system of FMI 2.0 with the types of FMI 3.0, and the same parameters in files of their own."""
    path, = build_systems(["Stage3DOF"], fmi3_fmus, tmp_path, 3)
    read = fmpy.ssp.ssd.read_ssd(str(path), validate=False)
    assert (read.version, [each.name for each in read.system.elements]) == ("2.0", ["controller", "plant"])
    older = structure(systems / "Stage3DOF.ssp")
    types = {connector[0].tag for connector in structure(path).iter(f"{{{SSD}}}Connector")}
    assert types == {f"{{{SSC}}}Float64", f"{{{SSC}}}Boolean"}
    assert ([each.attrib for each in structure(path).iter(f"{{{SSD}}}Connection")]
            == [each.attrib for each in older.iter(f"{{{SSD}}}Connection")])
    with zipfile.ZipFile(path) as archive:
        assert fmpy.read_model_description(archive.open("resources/Plant3DOF.fmu")).fmiVersion == "3.0"
        for component, inside in zip(structure(path).iter(f"{{{SSD}}}Component"), older.iter(f"{{{SSV}}}ParameterSet"),
                                     strict=True):
            binding = next(component.iter(f"{{{SSD}}}ParameterBinding"))
            outside = fromstring(archive.read(binding.attrib["source"]))
            values = [[(each.get("name"), each[0].attrib) for each in of.iter(f"{{{SSV}}}Parameter")]
                      for of in (outside, inside)]
            assert values[0] == values[1] != []
            # What a file refers to has to be in it.
            etree.XMLSchema(etree.parse(str(SCHEMA.with_name("SystemStructureParameterValues.xsd")))).assertValid(
                etree.fromstring(archive.read(binding.attrib["source"])))
            used = {each.get("unit") for each in outside.iter(f"{{{SSV}}}Real")} - {None}
            assert used == {unit.get("name") for unit in outside.iter(f"{{{SSC}}}Unit")} != set()


def test_two_open_ports_of_one_name(fmus: Path, tmp_path: Path) -> None:
    plant = (definition("Plant2DOF"), fmus / "Plant2DOF.fmu")
    twin = (replace(plant[0], name="Twin"), plant[1])
    with raises(ExportError, "plant", "twin", "motor.i_a_cmd"):
        write_ssp(tmp_path / "Twins.ssp", {"plant": plant, "twin": twin}, [], 1.0)


@pytest.mark.parametrize("values", [[], [Value("plant.y.locked", "Boolean", True, "")]])
def test_parameters_without_a_unit(tmp_path: Path, values: list[Value]) -> None:
    """Of a run that sets nothing, or nothing but Booleans: a list of units that is empty is not valid."""
    table = parameter_set("short", values)
    add_units(table, SSV, {value.unit for value in values if value.unit})
    (tmp_path / "short.ssv").write_bytes(xml_file(table))
    read = fmpy.ssp.ssd.read_ssv(str(tmp_path / "short.ssv"))
    assert [each.name for each in read.parameters] == [value.name for value in values]


@pytest.mark.usefixtures("slow")
def test_build_command(tmp_path: Path) -> None:
    """A system is built with its FMUs, and the same bytes again."""
    def build(folder: Path) -> dict[str, bytes]:
        assert maglev("build", "Stage2DOF", "--fmus", folder).exit_code == 0
        return {path.name: path.read_bytes() for path in folder.iterdir()}

    first = build(tmp_path / "a")
    assert set(first) == {"Plant2DOF.fmu", "Regulator2DOF.fmu", "Stage2DOF.ssp", "Stage2DOFNoPorts.ssp"}
    assert first == build(tmp_path / "b")
