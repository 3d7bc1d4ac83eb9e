"""Bad input: the logged message names the variable, its value and what was expected."""

import ctypes
import math
from collections.abc import Callable
from functools import partial
from itertools import accumulate
from pathlib import Path

import pytest
from dividing_block import DIVIDER
from event_mode import Instance, unpacked
from fmu_access import outputs, put, read, refusal, step

from maglev.cosim.fmu import Fmu, read_description
from maglev.fmi.build import Maker, build_fmu
from maglev.user.source import FmuFile

Load = Callable[[str], Fmu]


@pytest.fixture
def load(load_either: Load) -> Load:
    """Both kinds of FMUs refuse in the same words."""
    return load_either


def started(load: Load, name: str) -> Fmu:
    component = load(name)
    component.initialise({}, 0.0, 10.0)
    return component


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e9])
@pytest.mark.parametrize(("name", "variable", "size"), [
    ("Plant2DOF", "motor.i_a_cmd", 5e-4), ("Plant3DOF", "z.force", 2e-4),
    ("Regulator2DOF", "v.measured", 5e-4), ("Regulator3DOF", "x.reference_rate", 2e-4)])
def test_input_that_is_no_sensible_number(load: Load, name: str, variable: str, size: float, value: float) -> None:
    """It is refused when it is set; the next step goes on with the value before."""
    component = started(load, name)
    before = read(component, variable)
    text = refusal(component, lambda: put(component, {variable: value}))
    assert f"{variable} = {value}" in text and "expected a number from" in text
    assert read(component, variable) == before
    component.instance.doStep(0.0, size)


def test_powers_of_two_are_written_as_by_python(load: Load) -> None:
    """With the fewest digits that are read as the number, which are not always those nearest to it."""
    for value in (2.0**89, 2.0**122, 2.0**863, 2.0**60, 2.0**1023, -2.0**132):
        component = started(load, "Plant3DOF")
        text = refusal(component, partial(put, component, {"z.force": value}))
        assert f"z.force = {value} N" in text


@pytest.mark.parametrize("begun", [False, True], ids=["start value", "in a run"])
@pytest.mark.parametrize(("name", "events", "good", "bad"), [
    ("Plant3DOF", False, "x.force", "z.force"), ("Plant3DOF", False, "y.force", "y.mass"),
    ("Regulator3DOF", False, "y.reference", "x.measured"), ("Regulator3DOF", True, "z.measured", "z.reference_rate")])
def test_fmi_3_refuses_a_value_when_it_is_set(fmi3_fmus: Path, tmp_path: Path, name: str, events: bool, good: str,
                                              bad: str, begun: bool) -> None:
    """As by FMI 2.0, in the same words; of a call with several values none is taken."""
    one = Instance(unpacked(fmi3_fmus / f"{name}.fmu", tmp_path), events=events)
    if begun:   # with event mode, in an event
        one.begin()
    references = [one.references[good], one.references[bad]]
    before = one.fmu.getFloat64(references)
    for value in (math.nan, 1e9):
        said = one.refusal(partial(one.fmu.setFloat64, references, [0.125, value]))
        assert f"{bad} = {value}" in said and "expected a number from" in said
    assert one.fmu.getFloat64(references) == before and before[0] != 0.125


@pytest.mark.parametrize("size", [0.0, -1e-4, math.nan, math.inf])
@pytest.mark.parametrize("name", ["Plant3DOF", "Regulator3DOF"])
def test_step_that_is_not_positive(load: Load, name: str, size: float) -> None:
    component = started(load, name)
    text = refusal(component, lambda: component.instance.doStep(0.0, size))
    assert f"communication step = {size} s, expected a positive, finite step" in text


@pytest.mark.parametrize("size", [1e-3, 1.5e-4, 3e-4, 2.01e-4])
def test_step_that_does_not_divide_the_sample_time(load: Load, size: float) -> None:
    component = started(load, "Regulator3DOF")
    text = refusal(component, lambda: component.instance.doStep(0.0, size))
    assert f"communication step = {size} s" in text
    assert "sample_time = 0.0002 s" in text


def test_step_over_a_sample(load: Load) -> None:
    component = started(load, "Regulator3DOF")
    component.instance.doStep(0.0, 1e-4)
    text = refusal(component, lambda: component.instance.doStep(1e-4, 2e-4))
    assert "communication step = 0.0002 s" in text
    assert "does not step over a sample" in text


@pytest.mark.parametrize("size", [2e-4, 1e-4, 5e-5, 2e-4 * (1 + 1e-12)])
def test_step_that_divides_the_sample_time(load: Load, size: float) -> None:
    step(started(load, "Regulator3DOF"), 0, 5, size)


@pytest.mark.parametrize(("start", "size", "missed"), [
    (0.0, 2e-4, 0.5), (0.0, 2e-4, 3e-7), (0.0, 0.5, 1e-4), (0.0, 0.5, -1.1e-5), (0.0, 2e-4, math.nan),
    (1.7e9, 2e-4, 4e-4)])
def test_time_that_jumps(load: Load, start: float, size: float, missed: float) -> None:
    """However long the next step, and however large the time."""
    component = load("Plant3DOF")
    component.initialise({}, start, math.inf)
    component.instance.doStep(start, 2e-4)
    text = refusal(component, lambda: component.instance.doStep(start + 2e-4 + missed, size))
    assert f"communication point = {start + 2e-4 + missed} s, expected " in text
    assert missed != missed or f"expected {start + 2e-4} s, where the step before ended" in text


@pytest.mark.parametrize("start", [0.0, 1.7e9])
@pytest.mark.parametrize("name", ["Plant3DOF", "Regulator3DOF"])
def test_clocks_of_importers(load: Load, name: str, start: float) -> None:
    """Times that are multiplied, added up, of whole nanoseconds, or in single precision since the start."""
    size = 2e-4
    count = 25
    multiplied = [start + k * size for k in range(count)]
    added = list(accumulate([size] * (count - 1), initial=start))
    whole = [round(1e9 * each) * 1e-9 for each in multiplied]
    single = [start + ctypes.c_float(k * size).value for k in range(count)]
    for times in (multiplied, added, whole, single):
        component = load(name)
        component.initialise({}, start, start + 1.0)
        for time in times:
            component.instance.doStep(time, size)


@pytest.mark.parametrize(("name", "share"), [
    ("Plant3DOF", 1.0), ("Regulator3DOF", 1.0), ("Regulator3DOF", 0.1), ("Measurement3DOF", 1.0),
    ("ClosedLoop3DOF", 1.0), ("ClosedLoop3DOF", 40.0)])
def test_steps_that_are_differences_of_late_times(load: Load, name: str, share: float) -> None:
    """From 1.7e9 s on they are 0.24 µs too short or too long, and are the samples that they would be from 0 s on."""
    size = share * 2e-4
    late, early = load(name), load(name)
    late.initialise({}, 1.7e9, math.inf)
    early.initialise({}, 0.0, math.inf)
    for k in range(60):
        if "Plant" not in name:   # in which time moves on by what it is told
            assert outputs(late) == outputs(early)
        now, then = 1.7e9 + k * size, 1.7e9 + (k + 1) * size
        late.instance.doStep(now, then - now)
        early.instance.doStep(k * size, size)


def test_a_step_that_is_no_share_of_a_sample_is_refused_at_any_time(load: Load) -> None:
    """What late times resolve is no leave to miss a sample by more."""
    component = load("Regulator3DOF")
    component.initialise({}, 1.7e9, math.inf)
    text = refusal(component, lambda: component.instance.doStep(1.7e9, 2e-4 + 2e-6))
    assert "communication step = 0.000202 s" in text


@pytest.mark.parametrize("name", ["Plant3DOF", "Regulator3DOF", "Estimator3DOF", "Measurement3DOF", "ClosedLoop3DOF"])
def test_what_an_importer_that_adds_up_its_steps_has_left_at_the_end(load: Load, name: str) -> None:
    """As OMSimulator does: 5001 steps for 1 s, the last one of 8e-14 s. It is no sample."""
    component = load(name)
    component.initialise({}, 0.0, 1.0)
    time = 0.0
    while time < 1.0:
        size = min(time + 2e-4, 1.0) - time
        component.instance.doStep(time, size)
        time += size
    assert 0.0 < size < 1e-13


@pytest.mark.parametrize(("time", "allowed"), [(3.0, True), (-1e9, True), (math.nan, False), (math.inf, False)])
def test_first_step_where_no_start_time_is_said(load: Load, time: float, allowed: bool) -> None:
    """FMI 2.0.5 leaves fmi2SetupExperiment to the importer."""
    component = load("Plant3DOF")
    component.instance.enterInitializationMode()
    component.instance.exitInitializationMode()
    if allowed:
        component.instance.doStep(time, 2e-4)
    said = refusal(component, lambda: component.instance.doStep(time, 2e-4))
    assert f"communication point = {time} s, expected {time + 2e-4 if allowed else 'a finite time'}" in said


@pytest.mark.parametrize(("name", "start", "expected"), [
    ("Plant2DOF", {"v.mass": -1.0}, "v.mass = -1.0 kg, expected a number from 0.001 to"),
    ("Plant3DOF", {"x.mass": 0.0}, "x.mass = 0.0 kg, expected a number from 0.001 to"),
    ("Plant3DOF", {"beta.amplifier.peak": 0.0}, "beta.amplifier.peak = 0.0 A, expected a number from 0.001 to 1000.0 "
                                                "A; 1000 A never clamps"),
    ("Plant3DOF", {"y.friction.coulomb": math.inf}, "y.friction.coulomb = inf N"),
    ("Regulator2DOF", {"sample_time": 0.0}, "sample_time = 0.0 s"),
    ("Regulator3DOF", {"C4": 0.0}, "C4 = 0.0"),
    ("Regulator3DOF", {"omega0": -1.0}, "omega0 = -1.0 rad/s")])
def test_parameter_out_of_range(load: Load, name: str, start: dict[str, float], expected: str) -> None:
    component = load(name)
    assert expected in refusal(component, lambda: put(component, start))


@pytest.mark.parametrize(("name", "start", "expected"), [
    ("Plant2DOF", {"v.position_start": 0.03}, "v.position_start = 0.03 m, expected a place between the stops "
                                              "v.stop.lower = 0.008 m and v.stop.upper = 0.028 m"),
    ("Plant3DOF", {"z.position_start": -0.07}, "z.position_start = -0.07 m"),
    ("Plant3DOF", {"y.stop.lower": 0.026}, "y.stop.lower = 0.026 m")])
def test_parameter_that_does_not_fit_others(load: Load, name: str, start: dict[str, float], expected: str) -> None:
    """The end of the initialization says so: until then another may be set that it fits."""
    component = load(name)
    put(component, start)
    component.instance.setupExperiment(startTime=0.0)
    component.instance.enterInitializationMode()
    assert expected in refusal(component, component.instance.exitInitializationMode)


def test_tunable_parameter_out_of_range_in_a_run(load: Load) -> None:
    component = started(load, "Plant2DOF")
    assert "h.mass = -2.0 kg" in refusal(component, lambda: put(component, {"h.mass": -2.0}))


def test_fixed_parameter_in_a_run(load: Load) -> None:
    component = started(load, "Regulator3DOF")
    assert "sample_time is a fixed parameter" in refusal(component, lambda: put(component, {"sample_time": 1e-3}))


def test_output_cannot_be_set(load: Load) -> None:
    component = started(load, "Plant3DOF")
    assert "y.position is an output" in refusal(component, lambda: put(component, {"y.position": 0.02}))


def test_wrong_type_and_unknown_reference(load: Load) -> None:
    component = started(load, "Plant3DOF")
    reference = component.variable("at_stop").valueReference
    assert "at_stop is a Boolean" in refusal(component, lambda: component.instance.getReal([reference]))
    assert "value reference = 999" in refusal(component, lambda: component.instance.getReal([999]))


def test_step_before_the_initialization_has_ended(load: Load) -> None:
    component = load("Plant3DOF")
    assert "initialization" in refusal(component, lambda: component.instance.doStep(0.0, 2e-4))


def test_mover_that_runs_away(load: Load) -> None:
    component = load("Plant2DOF")
    component.initialise({"h.stop.stiffness": 0.0, "h.stop.damping": 0.0, "h.force": 1e5, "h.friction.coulomb": 0.0,
                          "h.friction.viscous": 0.0}, 0.0, 10.0)
    assert "the mover has run away" in refusal(component, lambda: step(component, 0, 100, 0.01))


def test_outputs_follow_parameters_during_the_initialization(load: Load) -> None:
    component = load("Plant3DOF")
    component.instance.setupExperiment(startTime=0.0)
    component.instance.enterInitializationMode()
    put(component, {"y.position_start": 0.021004})
    assert read(component, "y.position") == 0.021004
    assert read(component, "y.encoder") == pytest.approx(0.021, abs=1e-12)
    put(component, {"encoder.resolution": 0.0})
    assert read(component, "y.encoder") == 0.021004
    component.instance.exitInitializationMode()
    assert outputs(component)["y.encoder"] == 0.021004


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize(("number", "fails"), [(0.0, lambda: 1.0 / 0.0), (-1.0, lambda: math.sqrt(-1.0))])
def test_what_a_block_raises_in_a_step_is_refused(tmp_path: Path, number: float, fails: Callable[[], float]) -> None:
    """In one line with the time, and without an end of the process, also once the instance is freed."""
    with pytest.raises((ZeroDivisionError, ValueError)) as raised:   # each version of Python has other words
        fails()
    maker = Maker("1", "licence", ("dividing_block", "maglev", "pythonfmu"))
    path = build_fmu(DIVIDER, "from dividing_block import DIVIDER as DEFINITION", maker, tmp_path)
    for _ in range(2):
        component = Fmu("divider", FmuFile(path), read_description("divider", path))
        component.initialise({"number": 2.0}, 0.0, 1.0)
        component.instance.doStep(0.0, 0.1)
        assert read(component, "reciprocal") == 0.5
        put(component, {"number": number})
        text = refusal(component, lambda component=component: component.instance.doStep(0.1, 0.1))   # type: ignore[misc]
        assert f"step from 0.1 s: {raised.value}" in text
        component.close()
