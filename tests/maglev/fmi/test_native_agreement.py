"""Both kinds of FMUs do the same, bit for bit, and refuse with the same words, whatever is set."""

from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from fmpy.fmi1 import FMICallException
from fmpy.model_description import ScalarVariable
from fmu_access import bits, outputs, put, read, variables
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from maglev.cosim.fmu import Fmu
from maglev.descriptions.own_fmus import DEFINITIONS

Load = Callable[[str], Fmu]
Values = dict[str, float | bool]

PLANT_STEPS = st.floats(1e-5, 2e-3)
PARTS_OF_A_SAMPLE = st.sampled_from([1, 2, 4, 5])
SAMPLES = st.sampled_from([1, 2, 3, 10])   # in a step of a closed loop


def near(v: ScalarVariable) -> st.SearchStrategy[float | bool]:
    """Mostly sensible values of a variable, sometimes its limits, and rarely what no variable takes."""
    if v.type == "Boolean":
        return st.booleans()
    start, low, high = float(v.start), float(v.min), float(v.max)
    size = abs(start) or (1e-3 if v.unit == "m" else float(v.nominal))
    sensible = st.floats(-1.0, 2.0).map(lambda share: min(max(start + share * 0.5 * size, low), high))
    return st.one_of(sensible, sensible, sensible, sensible, st.floats(low, high),
                     st.sampled_from([low, high, start, 0.0, float("nan"), float("inf"), -1e300]))


def pick(vs: list[ScalarVariable], most: int) -> st.SearchStrategy[Values]:
    """Values of a few of the variables."""
    return st.lists(st.sampled_from(vs), max_size=most, unique_by=lambda v: v.name).flatmap(
        lambda chosen: st.fixed_dictionaries({v.name: near(v) for v in chosen}))


def attempt(component: Fmu, call: Callable[[], Any]) -> str:
    """What an FMU says when it refuses; empty if it does not."""
    component.said()
    try:
        call()
    except FMICallException:
        return component.said()
    return ""


def stepping(time: float, size: float) -> Callable[[Fmu], Any]:
    """What makes an FMU do one step."""
    return lambda component: component.instance.doStep(time, size)


class Pair:
    """An FMU of both kinds, which everything is done to."""

    def __init__(self, python: Fmu, native: Fmu):
        self.both = (python, native)

    def do(self, call: Callable[[Fmu], Any]) -> bool:
        """Whether both do it; if not, both refuse in the same words."""
        said = [attempt(component, partial(call, component)) for component in self.both]
        assert said[0] == said[1]
        return not said[0]

    def same_outputs(self) -> None:
        """Every output has the same bits."""
        python, native = (bits([outputs(component)]) for component in self.both)
        assert python == native


@pytest.mark.few(10)
@pytest.mark.parametrize("name", DEFINITIONS)
@settings(max_examples=4, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(data=st.data())
def test_random_runs(load: Load, load_native: Load, name: str, data: st.DataObject) -> None:
    pair = Pair(load(name), load_native(name))
    try:
        run(pair, data, name)
    finally:
        for component in pair.both:
            component.close()


def step_size(data: st.DataObject, name: str, sample: float) -> float:
    """A communication step that an FMU with a sample time (s) takes."""
    if name.startswith("Plant"):
        return data.draw(PLANT_STEPS, label="h")
    if name.startswith("ClosedLoop"):
        return sample * data.draw(SAMPLES, label="samples")
    return sample / data.draw(PARTS_OF_A_SAMPLE, label="parts")


def run(pair: Pair, data: st.DataObject, name: str) -> None:
    """Start, and take steps of random size with random inputs, until something is refused or it is enough."""
    component = pair.both[0]
    inputs, parameters = variables(component, "input"), variables(component, "parameter")
    if name.startswith("ClosedLoop"):   # long samples are long in Python
        parameters = [v for v in parameters if v.name != "controller.sample_time"]
    tunable = [v for v in parameters if v.variability == "tunable"]
    start = data.draw(pick(parameters, 6), label="parameters")
    pair.do(lambda each: put(each, start))
    pair.do(lambda each: each.instance.setupExperiment(startTime=0.0))
    pair.do(lambda each: each.instance.enterInitializationMode())
    pair.same_outputs()
    if not pair.do(lambda each: each.instance.exitInitializationMode()):
        return
    pair.same_outputs()
    sample_time = "controller.sample_time" if name.startswith("ClosedLoop") else "sample_time"
    sample = 0.0 if name.startswith("Plant") else read(component, sample_time)
    time, count = 0.0, 0
    for _ in range(data.draw(st.integers(1, 12), label="segments")):
        size = step_size(data, name, sample)
        values: Values = data.draw(pick(inputs, len(inputs)), label="inputs")
        values |= data.draw(pick(tunable, 1), label="change")
        pair.do(partial(put, values=values))
        for _ in range(data.draw(st.integers(1, 10), label="steps")):
            if not pair.do(stepping(time, size)):
                return
            pair.same_outputs()
            time, count = time + size, count + 1


@pytest.mark.few(10)
@pytest.mark.parametrize("name", DEFINITIONS)
def test_long_run(load: Load, load_native: Load, name: str) -> None:
    """Far from rest: stops, trips, saturation, and regions of a schedule are all passed through."""
    pair = Pair(load(name), load_native(name))
    inputs = [v for v in variables(pair.both[0], "input") if v.type == "Real"]
    # They have no limit by default, and the PID asks for little.
    limited = {"PID3DOF": "", "PID5DOF": "", "Commutation2DOF": "", "Commutation3DOF": "", "Commutation5DOF": "",
               "ClosedLoopPID3DOF": "controller.", "ClosedLoopPID5DOF": "controller."}
    limit = {f"{limited[name]}current_limit": 0.5} if name in limited else {}
    for component in pair.both:
        component.initialise(limit, 0.0, 10.0)
    size = 5e-4 if "2DOF" in name else 2e-4
    seen: dict[str, set[float]] = {}
    for k in range(300):
        values: Values = {v.name: float(v.start) + (2.0 if v.unit == "A" else 100.0 if v.unit == "N"
                                                          else 1e-3 * (k // 100)) * (((k // 20) * (i + 2)) % 7 - 3)
                          for i, v in enumerate(inputs)}
        assert pair.do(partial(put, values=values))
        assert pair.do(stepping(k * size, size))
        pair.same_outputs()
        for output, value in outputs(pair.both[0]).items():
            seen.setdefault(output, set()).add(value)
    assert sum(len(values) > 1 for values in seen.values()) > len(seen) / 2, "most outputs have moved"
    if name.startswith("Plant"):
        assert seen["at_stop"] == {False, True}
    elif name.startswith("ClosedLoop"):
        assert True in seen["controller.saturated"]   # which keeps most of them away from the stops
    elif not name.startswith(("Estimator", "Measurement")):
        assert True in seen["saturated"]
