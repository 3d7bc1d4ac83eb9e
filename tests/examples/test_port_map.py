"""Maps of ports: units that an FMU declares, conversions without rounding, rates, and FMUs of other kinds."""

import zipfile
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from facts import raises
from fmpy.model_description import ModelDescription, ScalarVariable

from maglev.cosim.fmu import read_description
from maglev.cosim.master import FmuSetup, Master, step_rate
from maglev.cosim.port_map import Port, PortMap, apply
from maglev.cosim.wiring import Rate
from maglev.files.errors import FmuError, ScenarioError


def described(*variables: tuple[str, str, str | None]) -> ModelDescription:
    """Description of variables: name, causality, unit."""
    return SimpleNamespace(unitDefinitions=[], modelVariables=[
        ScalarVariable(name, valueReference=i, type="Real", causality=causality, unit=unit, start="20")
        for i, (name, causality, unit) in enumerate(variables)])


def test_declared_units_are_converted() -> None:
    description = described(("gap", "input", "mm"), ("current", "output", "mA"), ("mass", "parameter", "kg"),
                            ("colour", "output", "furlong"), ("plain", "input", None))
    scales = apply(PortMap(units={"plain": "m"}), description)
    assert [(v.name, v.unit, v.start) for v in description.modelVariables] == [
        ("gap", "m", "0.02"), ("current", "A", "0.02"), ("mass", "kg", "20"), ("colour", "furlong", "20"),
        ("plain", "m", "20")]
    assert set(scales) == {"gap", "current"}
    assert scales["gap"].to_own(0.02) == 20.0
    assert scales["current"].to_si(20.0) == 0.02


def test_the_map_wins_over_no_unit_and_the_same_dimension() -> None:
    """The unit 1, which some tools write for every unit, is none."""
    description = described(("gap", "input", "m"), ("i", "output", None), ("f", "output", "1"))
    scales = apply(PortMap("m", {"v.measured": Port("gap", "µm"), "cmd": Port("i", "mA"), "force": Port("f", "kN")}),
                   description)
    assert [(v.name, v.unit) for v in description.modelVariables] == [("v.measured", "m"), ("cmd", "A"), ("force", "N")]
    assert scales["v.measured"].to_own(1e-6) == pytest.approx(1.0)
    with raises(ScenarioError, "gap", "A", "m"):
        apply(PortMap("m", {"v.measured": Port("gap", "A")}), described(("gap", "input", "m")))


def test_one_output_can_be_two_ports_and_names_can_be_swapped() -> None:
    description = described(("a", "output", "mm"), ("b", "output", None))
    apply(PortMap("m", {"b": Port("a"), "a": Port("b"), "c": Port("a")}), description)
    assert [(v.name, v.valueReference) for v in description.modelVariables] == [("b", 0), ("a", 1), ("c", 0)]


@pytest.mark.parametrize(("own", "expected"), [(1e-3, Rate(2, 1)), (0.1e-3, Rate(1, 5)), (0.5e-3, Rate())])
def test_rates(own: float, expected: Rate) -> None:
    assert step_rate("it", own, 0.5e-3, 1000) == expected


@pytest.mark.parametrize("own", [0.3e-3, 0.7e-3, 1.2e-3])
def test_rates_that_do_not_divide(own: float) -> None:
    with raises(FmuError, f"{own} s", "0.0005 s"):
        step_rate("it", own, 0.5e-3, 1000)


def loop(fmus: Path, step: float, **steps: float) -> dict[str, np.ndarray]:
    """Positions and commands of the 2-DOF loop; named FMUs with a step of their own, which the regulator allows."""
    participants = [FmuSetup(name, fmus / f"{model}.fmu", {"v.position_start": 0.02} if name == "plant" else {},
                                PortMap(step=steps[name]) if name in steps else None)
                    for name, model in (("controller", "PID2DOF"), ("plant", "Plant2DOF"))]
    connections = [*((f"plant.{axis}.encoder", f"controller.{axis}.measured") for axis in "vh"),
                   *((f"controller.motor.i_{phase}_cmd", f"plant.motor.i_{phase}_cmd") for phase in "abc")]
    reference = {"controller.v.reference": [0.021] * (round(0.1 / step) + 1)}
    with Master(participants, connections, step) as master:
        return dict(master.run(0.1, reference).columns)


def test_a_longer_step_of_the_controller_is_a_finer_step_of_the_loop(fmus: Path) -> None:
    """A controller held over two steps, and one that holds for two by itself, are the same."""
    own, held = loop(fmus, 0.25e-3), loop(fmus, 0.25e-3, controller=0.5e-3)
    for name in ("plant.v.position", "plant.h.position", "plant.v.encoder"):
        assert np.array_equal(own[name], held[name])
    commands = held["controller.motor.i_a_cmd"][1:]
    assert np.array_equal(commands[0::2], commands[1::2])
    assert np.ptp(commands) > 0.01


def test_parts_of_a_step_are_steps(fmus: Path) -> None:
    """Two parts of the plant's step are two steps under the same inputs."""
    whole, parts = loop(fmus, 0.25e-3, controller=0.5e-3), loop(fmus, 0.5e-3, plant=0.25e-3)
    assert np.array_equal(whole["plant.v.position"][::2], parts["plant.v.position"])


def test_a_longer_step_of_the_plant_is_made_at_its_end(fmus: Path) -> None:
    positions = loop(fmus, 0.5e-3, plant=1e-3)["plant.v.position"]
    assert len(set(positions[:2])) == 1
    assert all(positions[k] == positions[k + 1] for k in range(0, 200, 2))
    assert sum(a != b for a, b in pairwise(positions[::2])) > 90


@pytest.mark.parametrize(("text", "facts"), [
    ("""<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="t"><CoSimulation modelIdentifier="m"/>
     <ModelVariables><Float64 name="time" valueReference="0" causality="independent"/>
     <Clock name="sample" valueReference="1" causality="output" intervalVariability="changing"/>
     </ModelVariables><ModelStructure/></fmiModelDescription>""", ["clock sample", "changing"]),
    ("""<fmiModelDescription fmiVersion="1.0" modelName="M" guid="g" modelIdentifier="m" numberOfContinuousStates="0"
     numberOfEventIndicators="0"><ModelVariables/></fmiModelDescription>""",
     ["FMI 1.0", "FMI 2.0 or 3.0"]),
    ("""<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="t">
     <ScheduledExecution modelIdentifier="m"/>
     <ModelVariables><Float64 name="time" valueReference="0" causality="independent"/></ModelVariables>
     <ModelStructure/></fmiModelDescription>""", ["scheduled execution", "co-simulation"])])
def test_fmus_of_other_kinds_are_refused_with_the_reason(tmp_path: Path, text: str, facts: list[str]) -> None:
    path = tmp_path / "other.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", f'<?xml version="1.0" encoding="UTF-8"?>\n{text}')
    with raises(FmuError, path, *facts):
        read_description("controller", path)
