"""What a closed loop is as an FMU: the variables of its parts, one experiment, refusals about its own variables."""

import math
from collections.abc import Callable

import pytest
from fmu_access import put, refusal, step
from hypothesis import given
from hypothesis import strategies as st

from maglev.closed_loop.closed_loop import samples_in
from maglev.cosim.fmu import Fmu
from maglev.descriptions.own_fmus import DEFINITIONS, definition

LOOPS = [name for name in DEFINITIONS if name.startswith("ClosedLoop")]
AXES = {"2DOF": ("v", "h"), "3DOF": ("y", "x", "z"), "5DOF": ("y", "x", "z", "roll", "pitch")}

Load = Callable[[str], Fmu]


@pytest.mark.parametrize("name", LOOPS)
def test_variables_are_those_of_the_parts(name: str) -> None:
    """All but the connected inputs, with the same start values and limits."""
    loop = definition(name)
    axes = AXES[name[-4:]]
    found = {v.place: v for v in loop.variables}
    assert len(found) == len({v.name for v in loop.variables}) == len(loop.variables)
    for part, model in zip(("controller", "plant"), loop.description.split()[3:6:2], strict=True):
        of_part = definition(model.strip(","))
        for v in of_part.variables:
            own = found.pop(f"{part}.{v.place}", None)
            if own is None:
                assert v.causality == "input" and v.name.endswith(("measured", "_cmd"))
                continue
            assert own.name == (v.name if v.causality == "input" else f"{part}.{v.name}")
            for what in ("causality", "unit", "minimum", "maximum", "nominal", "source", "boolean"):
                assert getattr(own, what) == getattr(v, what), (v.name, what)
            assert loop.start_value(own) == of_part.start_value(v), v.name
    assert not found
    inputs = {v.name: v.variability for v in loop.variables if v.causality == "input"}
    pushed = {f"{axis}.{'torque' if axis in ('roll', 'pitch') else 'force'}": "continuous" for axis in axes}
    pushed |= {f"{axis}.floor_acceleration": "continuous" for axis in axes if axis not in ("roll", "pitch")}
    assert inputs == pushed | {f"{axis}.{port}": "discrete" for axis in axes
                               for port in ("reference", "reference_rate")}


@pytest.mark.parametrize("name", LOOPS)
def test_outputs_depend_on_inputs_of_the_loop(name: str) -> None:
    loop = definition(name)
    names = {causality: {v.name for v in loop.variables if v.causality == causality}
             for causality in ("input", "parameter")}
    for v in loop.variables:
        assert set(v.depends_on) <= names["input"] and set(v.starts_from) <= names["parameter"]
        if v.causality == "output":
            assert bool(v.depends_on) is v.name.startswith("controller."), v.name
    gap = AXES[name[-4:]][0]
    by_name = {v.name: v for v in loop.variables}
    assert by_name[f"controller.{gap}.error"].depends_on == (f"{gap}.reference",)
    assert by_name[f"plant.{gap}.position"].starts_from == (f"plant.{gap}.position_start",)


@given(st.integers(1, 10**6), st.floats(1e-6, 1e-3), st.floats(-0.49, 0.49))
def test_only_whole_samples_are_counted(count: int, sample_time: float, part: float) -> None:
    assert samples_in(count * sample_time, sample_time) == count
    if abs(part) > 1e-5:
        assert samples_in((count + part) * sample_time, sample_time) == 0


def test_steps_that_are_too_short_or_too_long_have_no_samples() -> None:
    assert samples_in(1e-9, 2e-4) == samples_in(1000.2, 2e-4) == samples_in(1e300, 1e-6) == 0
    assert samples_in(1000.0, 2e-4) == 5_000_000


@pytest.fixture
def load(load_either: Load) -> Load:
    """Both kinds of FMUs refuse in the same words."""
    return load_either


@pytest.mark.parametrize("size", [1e-4, 3e-4, 2.01e-4, 0.0200001, 1001.0])
def test_step_that_is_no_multiple_of_the_sample_time(load: Load, size: float) -> None:
    loop = load("ClosedLoop3DOF")
    loop.initialise({}, 0.0, 1e4)
    text = refusal(loop, lambda: loop.instance.doStep(0.0, size))
    assert f"communication step = {size} s, expected a whole multiple of controller.sample_time = 0.0002 s" in text


def test_steps_of_changing_numbers_of_samples(load: Load) -> None:
    """Of a sample time of one's own."""
    loop = load("ClosedLoop2DOF")
    loop.initialise({"controller.sample_time": 2.5e-4}, 0.0, 1.0)
    time = 0.0
    for count in (1, 7, 2, 40):
        loop.instance.doStep(time, count * 2.5e-4)
        time += count * 2.5e-4
    assert "controller.sample_time = 0.00025 s" in refusal(loop, lambda: loop.instance.doStep(time, 4e-4))


@pytest.mark.parametrize(("name", "start", "expected"), [
    ("ClosedLoop3DOF", {"plant.y.mass": -1.0}, "plant.y.mass = -1.0 kg, expected a number from 0.001 to"),
    ("ClosedLoop2DOF", {"v.reference": math.nan}, "v.reference = nan m, expected a number from"),
    ("ClosedLoop3DOF", {"plant.z.position_start": -0.07},
     "plant.z.position_start = -0.07 m, expected a place between the stops plant.z.stop.lower = -0.062 m and "
     "plant.z.stop.upper = 0.062 m"),
    ("ClosedLoopLinear2DOF", {"controller.setpoint": 0.009, "controller.C4": 1e5},
     "controller.setpoint = 0.009 m, expected an air gap at which"),
    ("ClosedLoopScheduled3DOF", {"controller.C5": 1e5}, "controller.C3 = 327.5 m/(s2.T2), controller.C4 = 8.48"),
    ("ClosedLoopInterpolated5DOF", {"controller.C5": 1e5}, "controller.C5 = 100000.0 m/(s2.A2), expected constants "
     "with which the model has equilibria at the table's gaps of 18 to 32 mm"),
    ("ClosedLoopPID2DOF", {"controller.v.prefilter": 1e4},
     "controller.v.prefilter = 10000.0 rad/s, controller.h.prefilter = 0.0 rad/s, expected at most 0.8 / sample_time, "
     "with controller.sample_time = 0.0005 s")])
def test_start_values_that_are_refused(load: Load, name: str, start: dict[str, float], expected: str) -> None:
    loop = load(name)
    if "expected a number from" in expected:   # when it is set
        assert expected in refusal(loop, lambda: put(loop, start))
        return
    put(loop, start)
    loop.instance.setupExperiment(startTime=0.0)
    loop.instance.enterInitializationMode()
    assert expected in refusal(loop, loop.instance.exitInitializationMode)


def test_commands_that_are_no_sensible_currents(load: Load) -> None:
    """Without a limit anywhere; the plant alone refuses them as well."""
    loop = load("ClosedLoop3DOF")
    loop.initialise({"controller.current_limit": 0.0, "controller.x.k1": -1e15}, 0.0, 10.0)
    loop.instance.doStep(0.0, 2e-4)
    put(loop, {"x.reference": 1.0})
    text = refusal(loop, lambda: loop.instance.doStep(2e-4, 2e-4))
    assert text.startswith("controller.alpha.i_a_cmd = ") and text.endswith(" A, expected all within 1000 A")


def test_mover_that_runs_away(load: Load) -> None:
    loop = load("ClosedLoopPID2DOF")
    loop.initialise({"plant.h.stop.stiffness": 0.0, "plant.h.stop.damping": 0.0, "h.force": 1e5}, 0.0, 10.0)
    text = refusal(loop, lambda: step(loop, 0, 10, 1.0))
    assert "the mover has run away in the step from 0.0 s: plant.v.position = " in text
