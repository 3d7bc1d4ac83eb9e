"""FMUs of FMI 3.0 with numbers of every type, arrays, units with an offset; references to no variable."""

import zipfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from facts import raises
from small_fmus import built_fmu

from maglev.cosim.fmu import read_description
from maglev.cosim.master import FmuSetup, Master, Recording
from maglev.cosim.port_map import PortMap
from maglev.files.errors import FmuError, ScenarioError
from maglev.runs.plan_check import PortCheck
from maglev.runs.preparation import beyond_ranges

SOURCE = Path(__file__).parents[2] / "support" / "typed_fmu.c"
STEP, END = 0.1, 0.3   # s
TYPES = ("Float64", "Float32", *(f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)))

HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Typed" instantiationToken="typed">
<CoSimulation modelIdentifier="small" canHandleVariableCommunicationStepSize="true"/>
<UnitDefinitions><Unit name="celsius"><BaseUnit K="1" offset="273.15"/></Unit></UnitDefinitions>
<ModelVariables>
<Float64 name="time" valueReference="99" causality="independent" variability="continuous"/>
<Float64 name="temperature" valueReference="50" causality="input" start="20" unit="celsius" min="-40" max="80"/>
<Float64 name="thermometer" valueReference="51" causality="output" unit="celsius"/>
<Float64 name="gap" valueReference="100" causality="input" start="0 0 0"><Dimension start="3"/></Float64>
<Float64 name="turned" valueReference="101" causality="output"><Dimension start="3"/></Float64>
<Float32 name="single" valueReference="102" causality="input" start="0 0 0"><Dimension start="3"/></Float32>
<Float32 name="turned_single" valueReference="103" causality="output"><Dimension start="1"/><Dimension start="3"/>
</Float32>
"""


@pytest.fixture(scope="module")
def typed(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    rows, structure = [], ["51", "101", "103"]
    for number, kind in enumerate(TYPES):
        rows.append(f'<{kind} name="in_{kind}" valueReference="{2 * number}" causality="input" start="0"/>\n'
                    f'<{kind} name="out_{kind}" valueReference="{2 * number + 1}" causality="output"/>\n')
        structure.append(str(2 * number + 1))
    text = (HEAD + "".join(rows) + "</ModelVariables>\n<ModelStructure>"
            + "".join(f'<Output valueReference="{each}"/>' for each in structure)
            + "</ModelStructure>\n</fmiModelDescription>")
    return built_fmu(tmp_path_factory.mktemp("typed"), SOURCE, text)


def ran(setups: list[FmuSetup], wires: list[tuple[str, str]], drives: dict[str, Any]) -> Recording:
    with Master(setups, wires, STEP) as master:
        return master.run(END, drives)


def test_numbers_of_every_type_arrive(typed: Path) -> None:
    """The least and the largest of whole numbers, a Float32 to its precision, through start values and signals."""
    ends: dict[str, tuple[float, float]] = {}
    for kind in TYPES[2:]:
        bits = int(kind.partition("Int")[2])
        ends[kind] = (0, 2**bits - 1) if kind[0] == "U" else (-2**(bits - 1), 2**(bits - 1) - 1)
    for end in (0, 1):
        recording = ran([FmuSetup("a", typed, {f"in_{kind}": ends[kind][end] for kind in ends})], [],
                        {"a.in_Float32": [0.1, 0.2, 0.3, 0.4], "a.in_Float64": [1.0, 2.0, 3.0, 4.0]})
        for kind, values in ends.items():
            assert recording.columns[f"a.out_{kind}"].tolist() == [values[end]] * 4, kind
    assert recording.columns["a.out_Float32"][1:].tolist() == [float(np.float32(value)) for value in (0.1, 0.2, 0.3)]
    assert recording.columns["a.out_Float64"][1:].tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(("kind", "value", "bounds"), [
    ("Int8", 128, [-128, 127]), ("UInt16", -1, [0, 65535]), ("UInt64", 0.5, ["whole"])])
def test_refuses_a_number_that_a_type_does_not_hold(typed: Path, kind: str, value: float, bounds: list[object]) -> None:
    with raises(FmuError, f"a.in_{kind}", value, kind, *bounds):
        ran([FmuSetup("a", typed, {f"in_{kind}": value})], [], {})


def test_elements_of_arrays_are_ports(typed: Path) -> None:
    """By start values, signals and connections, from Float64 to Float32 too; the others keep what they have."""
    setups = [FmuSetup("a", typed, {"gap[1]": 1.0, "gap[3]": 3.0}), FmuSetup("b", typed, {"single[2]": 0.5})]
    wires = [("a.turned[1]", "b.gap[2]"), ("a.turned[2]", "b.single[1]"), ("a.turned[3]", "b.in_Float32")]
    drive = [0.25, 0.5, 0.75, 1.0]
    recording = ran(setups, wires, {"a.gap[2]": drive})
    given = {name: recording.columns[name].tolist() for name in recording.columns}
    assert given["a.turned[1]"] == [3.0] * 4 and given["a.turned[3]"] == [1.0] * 4
    assert given["a.turned[2]"][1:] == drive[:3]
    assert given["b.turned[2]"][1:] == [3.0] * 3 and given["b.turned[1]"] == [0.0] * 4
    assert given["b.turned_single[1,3]"][1:] == drive[:3] and given["b.turned_single[1,2]"] == [0.5] * 4
    assert given["b.out_Float32"][1:] == [1.0] * 3


def test_a_unit_with_an_offset_is_converted(typed: Path) -> None:
    """300 K are 26.85 of a unit that begins at 273.15 K; its range is in kelvin as well."""
    with Master([FmuSetup("a", typed, {"temperature": 300.0}, PortMap())], [], STEP) as master:
        recording = master.run(END, {})
        assert recording.columns["a.thermometer"] == pytest.approx([300.0] * 4, abs=1e-12)
        variable = master.fmus["a"].variable("temperature")
        assert variable.unit == "K"
        assert (float(variable.min), float(variable.start)) == pytest.approx((233.15, 293.15), abs=1e-12)
        assert master.fmus["a"].scales["temperature"].to_own(300.0) == pytest.approx(26.85)
    description = SimpleNamespace(modelVariables=[variable])
    cold = Recording(STEP * np.arange(3.0), {"b.weather": np.array([300.0, 230.0, 220.0])})
    assert beyond_ranges(cold, {"a": description}, [("b.weather", "a.temperature")]) == [
        (1, "b.weather = 230 K is beyond 233.15…353.15 K, the range of a.temperature")]


@pytest.mark.parametrize(("old", "new", "said"), [
    ('<Output valueReference="51"', '<Output valueReference="77"', "<Output valueReference='77'>"),
    ('<Output valueReference="51"', '<Output valueReference="51" dependencies="50 78"',
     "<Output dependencies='50 78'>")])
def test_a_reference_to_no_variable_is_named(typed: Path, tmp_path: Path, old: str, new: str, said: str) -> None:
    with zipfile.ZipFile(typed) as archive, zipfile.ZipFile(tmp_path / "theirs.fmu", "w") as written:
        written.writestr("modelDescription.xml", archive.read("modelDescription.xml").decode().replace(old, new))
    with raises(FmuError, "theirs.fmu", said):
        read_description("theirs", tmp_path / "theirs.fmu")


def test_start_values_that_an_fmu_takes_as_they_are_can_be_set() -> None:
    """Of a local or an output with initial = "exact"; not of one that is calculated."""
    variables = {name: SimpleNamespace(name=name, causality=causality, variability="continuous", initial=initial)
                 for name, causality, initial in (("x", "local", "exact"), ("y", "output", "calculated"))}
    plan: Any = SimpleNamespace(source="run.toml")
    check = PortCheck(plan, {"plant": variables}, {})
    assert check.settable("fmus.plant.start.x", 1.0, "plant", "x").name == "x"
    with raises(ScenarioError, "run.toml", "fmus.plant.start.y", "'y'", "output", "parameter", "input"):
        check.settable("fmus.plant.start.y", 1.0, "plant", "y")
