"""FMUs with clocks in a co-simulation: the same bits as without, and clocks of others."""

import subprocess
import zipfile
from ctypes import POINTER, c_double, c_int, c_size_t, c_uint32, c_void_p, cast
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, parse, tostring

import fmpy
import numpy as np
import pytest
from command_line import error_line, maglev
from example_builds import EXAMPLES, require_compiler, script
from fmpy.model_description import ModelDescription, ModelVariable
from native_builds import FMI_HEADERS
from small_fmus import absent_functions, built_fmu

from maglev.cosim.clocks import Ticking
from maglev.cosim.master import FmuSetup, Master
from maglev.cosim.port_map import read_port_maps
from maglev.runs.replacement import Replacement, fit
from maglev.scenario.loading import load_plan
from maglev.user.source import FmuFile

SAMPLE = 2e-4   # s
WIRES = [*((f"plant.{axis}.encoder", f"controller.{axis}.measured") for axis in "yxz"),
         *((f"controller.{motor}.i_{phase}_cmd", f"plant.{motor}.i_{phase}_cmd")
           for motor in ("alpha", "beta") for phase in "abc")]


@pytest.mark.parametrize(("step", "order"), [(SAMPLE, "sequential"), (SAMPLE / 4, "jacobi")])
def test_a_clocked_controller_gives_the_same_bits(native_fmus: Path, clocked_fmus: Path, step: float,
                                                  order: Any) -> None:
    """Next to a plant of FMI 2.0; twice, as one that is reset begins again."""
    steps = round(0.04 / step)
    drives = {"controller.y.reference": np.where(np.arange(steps + 1) * step < 0.01, 0.025, 0.0252)}

    def trajectory(controller: Path) -> list[dict[str, bytes]]:
        setups = [FmuSetup("controller", controller / "Regulator3DOF.fmu"),
                  FmuSetup("plant", native_fmus / "Plant3DOF.fmu")]
        with Master(setups, WIRES, step, order) as master:
            master.wire(0.04, drives)
            return [{name: column.tobytes() for name, column in master.run_again({}).columns.items()} for _ in range(2)]

    expected = trajectory(native_fmus)
    assert expected[0] == expected[1] and len(set(expected[0].values())) > 20
    assert trajectory(clocked_fmus) == expected


def test_nothing_is_said_of_a_clock_that_nothing_feeds(clocked_fmus: Path) -> None:
    """The master ticks it."""
    controller = Replacement(FmuFile(clocked_fmus / "Regulator3DOF.fmu"))
    note, = fit(load_plan("3dof-setpoints"), {"controller": controller})[1]
    assert note.startswith("nothing feeds controller.y.reference_rate,") and "clock" not in note


def test_fmpy_runs_one_with_the_clock_ticked_by_hand(clocked_fmus: Path) -> None:
    """The example of an importer: the bits of our master. fmpy's own simulation refuses clocks, as the page says."""
    example = script(EXAMPLES / "clocked_fmpy.py")
    with Master([FmuSetup(role, clocked_fmus / f"{name}3DOF.fmu") for role, name in (
            ("controller", "Regulator"), ("plant", "Plant"))], WIRES, SAMPLE) as master:
        steps = round(0.04 / SAMPLE)
        recording = master.run(0.04, {"controller.y.reference": np.where(
            np.arange(steps + 1) * SAMPLE < example.STEP_AT, example.GAP, example.STEP_TO)})
    expected = np.column_stack([recording.columns[f"plant.{axis}.position"] for axis in example.AXES])
    assert np.array_equal(example.trajectory(clocked_fmus, 0.04), expected)
    for refused in ({}, {"use_event_mode": True, "early_return_allowed": True}):
        with pytest.raises(Exception, match=r"Failed to instantiate FMU|fmi3GetFloat64 failed"):
            fmpy.simulate_fmu(clocked_fmus / "Regulator3DOF.fmu", stop_time=0.01, **refused)


PD = EXAMPLES / "pd_controller_c"


def built_with_a_clock(folder: Path) -> Path:
    """An FMU of `clocked_pd.c`; its model description is that of the example as FMI 3.0, and a clock."""
    root = Element("fmiModelDescription", fmiVersion="3.0", modelName="ClockedPD", instantiationToken="clocked pd")
    SubElement(root, "CoSimulation", modelIdentifier="clocked_pd", hasEventMode="true",
               canHandleVariableCommunicationStepSize="true")
    variables, structure = SubElement(root, "ModelVariables"), SubElement(root, "ModelStructure")
    for variable in parse(PD / "modelDescription.xml").iter("ScalarVariable"):
        start = variable.find("Real").attrib   # type: ignore[union-attr]
        of_clock = {} if variable.get("causality") == "parameter" else {"variability": "discrete", "clocks": "10"}
        SubElement(variables, "Float64", variable.attrib | start | of_clock)
        if variable.get("causality") == "output":
            SubElement(structure, "Output", valueReference=variable.attrib["valueReference"])
    SubElement(variables, "Float64", name="time", valueReference="9", causality="independent",
               variability="continuous")
    SubElement(variables, "Clock", name="tick", valueReference="10", causality="input", variability="discrete",
               intervalVariability="constant", intervalDecimal="0.5e-3")
    library = folder / f"clocked_pd{fmpy.sharedLibraryExtension}"
    source = Path(__file__).with_name("clocked_pd.c")
    (folder / "absent.c").write_text(absent_functions(source.read_text()))
    subprocess.run([*require_compiler(), "-O2", "-shared", "-fPIC", *FMI_HEADERS, "-I", PD, source,
                    folder / "absent.c", "-o", library, "-lm"], check=True)
    with zipfile.ZipFile(folder / "clocked_pd.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", tostring(root, encoding="utf-8", xml_declaration=True))
        archive.write(library, f"binaries/{fmpy.platform_tuple}/{library.name}")
    return folder / "clocked_pd.fmu"


def test_a_clocked_controller_of_another_tool(native_fmus: Path, tmp_path: Path) -> None:
    """It computes what the same law does in steps: with a tick at each step, and with one at every fourth."""
    own = 0.5e-3   # s, interval of its clock
    stepped, clocked = script(PD / "build.py").build(tmp_path), built_with_a_clock(tmp_path)
    ports = read_port_maps(PD / "ports.toml")["controller"]

    def trajectory(controller: Path, step: float) -> dict[str, Any]:
        time = np.arange(round(0.1 / step) + 1) * step
        setups = [FmuSetup("controller", controller, {}, replace(ports, step=own) if controller is stepped else ports),
                  FmuSetup("plant", native_fmus / "Plant2DOF.fmu", {"v.position_start": 0.0201})]
        wires = [*((f"plant.{axis}.encoder", f"controller.{axis}.measured") for axis in "vh"),
                 *((f"controller.motor.i_{phase}_cmd", f"plant.motor.i_{phase}_cmd") for phase in "abc")]
        drives = {"controller.v.reference": np.where(time < 0.02, 0.02, 0.0205)}
        with Master(setups, wires, step) as master:
            return dict(master.run(0.1, drives).columns)

    for step in (own, own / 4):
        expected, found = trajectory(stepped, step), trajectory(clocked, step)
        assert np.ptp(expected["plant.v.position"]) > 3e-4
        assert {name: column.tobytes() for name, column in expected.items()} == {
            name: column.tobytes() for name, column in found.items()}


def test_a_build_names_the_needs_of_clocks(tmp_path: Path) -> None:
    said = error_line(maglev("build", "--kind", "native", "--clocked", "Regulator3DOF", "--fmus", tmp_path))
    assert said.endswith("clocked: needs kind = native and fmi = 3")


CLOCKS = """<fmiModelDescription><ModelVariables>
<Clock name="fast" valueReference="1" intervalVariability="constant" intervalDecimal="0.3" shiftDecimal="0.1"/>
<Clock name="slow" valueReference="2" intervalVariability="tunable"/></ModelVariables></fmiModelDescription>"""


class Sums:
    """An FMU of somebody else's: `y3` sums its input `u` at a constant clock, `y4` counts a tunable one."""

    component = 1

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []
        self.values = {3: 0.0, 4: 0.0, 5: 0.0}
        self.period, self.told = 0.5, 0.0
        self.time = 0.0
        self.now: set[int] = set()

    def setClock(self, references: list[int], _active: list[bool]) -> None:
        self.calls.append((round(self.time, 9), *references))
        self.now = set(references)

    def enterEventMode(self) -> None:
        self.now = set()

    def updateDiscreteStates(self) -> tuple[bool, bool, bool, bool, bool, float]:
        if self.time > 1.0:
            self.period = 0.2
        return False, False, False, False, False, 0.0

    def enterStepMode(self) -> None:
        pass

    def getShiftDecimal(self, _references: object, shifts: Any) -> None:
        shifts[0] = 0.0

    def getIntervalDecimal(self, _references: object, intervals: Any, qualifiers: Any) -> None:
        intervals[0], qualifiers[0] = self.period, 2 if self.period != self.told else 1
        self.told = self.period

    def access(self, _handle: object, references: Any, count: c_size_t, place: c_void_p, put: bool) -> int:
        values = cast(place, POINTER(c_double))
        for i, reference in enumerate(references):
            if put:
                self.values[reference] = values[i]
            else:
                if reference == 3 and 1 in getattr(self, "now", ()):
                    self.values[3] += self.values[5]
                if reference == 4 and 2 in getattr(self, "now", ()):
                    self.values[4] += 1.0
                values[i] = self.values[reference]
        return 0

    def step(self, _handle: object, time: c_double, size: c_double, _no_set_before: c_int) -> int:
        self.time = time.value + size.value
        return 0


def test_clocks_of_other_fmus_tick_in_their_own_time(tmp_path: Path) -> None:
    (tmp_path / "modelDescription.xml").write_text(CLOCKS)
    fast, slow = (ModelVariable(name, reference, "Clock") for name, reference in (("fast", 1), ("slow", 2)))
    variables = [fast, slow, ModelVariable("y3", 3, "Real", causality="output", clocks=[fast]),
                 ModelVariable("y4", 4, "Real", causality="output", clocks=[slow]),
                 ModelVariable("u", 5, "Real", causality="input", clocks=[fast])]
    fmu = Sums()

    class Kind:
        value = c_double

    ticking = Ticking(fmu, tmp_path, ModelDescription(modelVariables=variables), {"Real": Kind},
                      {"Real": partial(fmu.access, put=False)}, {"Real": partial(fmu.access, put=True)}, fmu.step,
                      pytest.fail)
    ticking.look()
    ticking.begin(0.0)
    found = []
    for k in range(4):   # steps of 0.4 s, with u = k
        references, row = (c_uint32 * 1)(5), (c_double * 1)(float(k))
        ticking.setters["Real"](c_void_p(), references, c_size_t(1), cast(row, c_void_p))
        assert ticking(None, c_double(0.4 * k), c_double(0.4), None) == 0
        row = (c_double * 2)()
        ticking.getters["Real"](c_void_p(), (c_uint32 * 2)(3, 4), c_size_t(2), cast(row, c_void_p))
        found.append(tuple(row))
    # The tunable clock changes to 0.2 s at the first event after 1 s, from which it counts.
    assert fmu.calls == [(0.0, 2), (0.1, 1), (0.4, 1), (0.5, 2), (0.7, 1), (1.0, 1, 2), (1.3, 1), (1.5, 2)]
    assert found == [(0.0, 1.0), (2.0, 2.0), (4.0, 3.0), (7.0, 4.0)]


TRIGGERED = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Triggered" instantiationToken="triggered">
<CoSimulation modelIdentifier="small" canHandleVariableCommunicationStepSize="true" hasEventMode="true"/>
<ModelVariables>
<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
<Clock name="fired" valueReference="1" causality="output" intervalVariability="triggered"/>
<Float64 name="x" valueReference="2" causality="input" start="0"/>
<Float64 name="count" valueReference="3" causality="output" variability="discrete" clocks="1"/>
<Clock name="take" valueReference="4" causality="input" intervalVariability="triggered"/>
<Float64 name="given" valueReference="5" causality="input" variability="discrete" start="0" clocks="4"/>
<Float64 name="total" valueReference="6" causality="output" variability="discrete" clocks="4"/>
</ModelVariables>
<ModelStructure><Output valueReference="1"/><Output valueReference="3"/><Output valueReference="6"/></ModelStructure>
</fmiModelDescription>
"""


@pytest.mark.parametrize(("order", "late"), [("sequential", 0), ("jacobi", 1)])
def test_triggered_clocks_are_ports(tmp_path: Path, order: Any, late: int) -> None:
    """What rises in the steps from 0.2 s and 0.6 s fires a step later, and once each; of a signal, at its instants."""
    path = built_fmu(tmp_path, Path(__file__).parents[2] / "support" / "triggered_fmu.c", TRIGGERED)
    setups = [FmuSetup(name, path) for name in "abc"]
    wires = [("a.fired", "b.take"), ("a.count", "b.given")]
    drives: dict[str, list[float]] = {
        "a.x": [0, 0, 2, 2, 0, 0, 2, 2, 2, 2, 2], "c.take": [True, *[False] * 6, True, True, False, False],
        "c.given": [0.5, *[1.0] * 10]}
    with Master(setups, wires, 0.1, order) as master:
        columns = master.run(1.0, drives).columns
        again = master.run(1.0, drives).columns
    assert columns["a.fired"].tolist() == [0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0]
    assert columns["a.count"].tolist() == [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2]
    assert columns["b.total"].tolist() == [0] * (4 + late) + [1] * 4 + [3] * (3 - late)
    assert columns["c.total"].tolist() == [0, *[0.5] * 7, 1.5, 2.5, 2.5]
    assert {name: again[name].tobytes() for name in columns} == {name: columns[name].tobytes() for name in columns}
