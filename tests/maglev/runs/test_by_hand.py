"""Every number of one small run, by its definition in exact fractions: what symmetric signals hide shows here."""

import itertools
import math
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from maglev.runs.measuring import run_metrics
from maglev.runs.metrics import Metrics
from maglev.scenario.run_plan import Axis, Event, MetricSettings, Motor

TIME = [0.5 + 0.125 * k for k in range(40)]                       # exact in binary, and not from 0
TARGETS = {"y": [2.0] * 10 + [5.0] * 30, "x": [-1.0] * 30 + [-4.0] * 10}
LATE = [1.0, -0.5, 0.25, 0.75, -0.125, 0.375, 0.0625, -0.25, 0.5, 0.1875]
ERRORS = {"y": [0.0] * 10 + [-3.0, 0.75] + LATE[2:] * 2 + [0.25, 0.0625] + LATE[:9] + [0.625],
          "x": [0.125] * 30 + [3.0, *LATE[1:]]}
PHASES = {"a": [((7 * k) % 11 - 5) / 4 for k in range(40)], "b": [((3 * k) % 13 - 6) / 8 for k in range(40)]}
STEADY = {"y": 2, "x": 1}                                         # a tenth of 20 and of 10 samples
WINDOWS = {"y": (10, 30), "x": (30, 40)}
EVENT = slice(20, 32)                                             # from 3.0 s to 4.5 s, without the last


def fraction(values: list[float]) -> list[Fraction]:
    return [Fraction(value) for value in values]


def mean(values: list[Fraction]) -> float:
    return float(sum(values) / len(values))


def trapezoids(values: list[Fraction]) -> float:
    return float(sum(left + right for left, right in itertools.pairwise(values)) / 16)


@pytest.fixture
def metrics() -> Metrics:
    plan: Any = SimpleNamespace(
        axes={name: Axis(position=f"{name}.p", reference=f"{name}.r") for name in TARGETS},
        motors={"m": Motor(currents=["m.a", "m.b"], commands=["m.a", "m.c"])}, stop_flag=None, trip_flag=None,
        events=[Event(name="pull", time=3.0)], event_ends=[4.5], disturbances=[],
        metrics=MetricSettings.model_validate({"bands": [0.5], "tracking_from": 2.0, "fail_error": 0.1875}))
    columns = {f"{name}.r": np.array(targets) for name, targets in TARGETS.items()}
    columns |= {f"{name}.p": np.array(TARGETS[name]) + np.array(ERRORS[name]) for name in TARGETS}
    columns |= {f"m.{name}": np.array(values) for name, values in PHASES.items()}
    columns["m.c"] = np.array([value * value for value in PHASES["b"]])
    return run_metrics(plan, np.array(TIME), columns, {"m": 1.5})


def test_steps(metrics: Metrics) -> None:
    for step, axis in zip(metrics.steps, ("y", "x"), strict=True):
        start, end = WINDOWS[axis]
        assert (step.axis, step.time) == (axis, TIME[start])
        assert (step.start, step.target) == (TARGETS[axis][start - 1], TARGETS[axis][start])
        beyond = max(error if axis == "y" else -error for error in fraction(ERRORS[axis][start:end]))
        assert step.overshoot == float(beyond / 3)
        late = fraction(ERRORS[axis][end - STEADY[axis]:end])
        assert step.steady_state_error == mean([abs(error) for error in late])
        last = max(k for k in range(start, end) if abs(ERRORS[axis][k]) > 0.5)
        assert step.settling_time == {0.5: TIME[last] - TIME[start]}


def test_errors_of_the_whole_run(metrics: Metrics) -> None:
    for axis, errors in ERRORS.items():
        exact = fraction(errors)
        assert metrics.rms_errors[axis] == math.sqrt(mean([error * error for error in exact]))
        assert metrics.end_errors[axis] == abs(errors[-1])
    assert not metrics.failed and metrics.ended_off == {"y": 0.625}


def test_who_loses_which_setpoint(metrics: Metrics) -> None:
    limit = 0.1875
    assert abs(ERRORS["x"][-1]) == limit                          # which is no failure
    assert abs(ERRORS["y"][28]) > limit > abs(ERRORS["y"][29])    # lost before the step's last sample, not at it
    assert metrics.lost == (TIME[30],)                            # the step of x finds both in place; y is lost in it


def test_tracking(metrics: Metrics) -> None:
    for tracking in metrics.tracking:
        exact = [abs(error) for error in fraction(ERRORS[tracking.axis])]
        assert tracking.mean_tracking_error == mean(exact[12:])   # from 2.0 s on, with that sample
        assert tracking.peak_tracking_error == float(max(exact[12:]))
        beyond = [k for k, error in enumerate(exact) if error > max(exact[12:]) * Fraction(11, 10)]
        assert tracking.tracking_transient == (TIME[beyond[-1]] - TIME[0] if beyond else 0.0)


def test_motors(metrics: Metrics) -> None:
    (motor,) = metrics.motors
    a, b = (fraction(values) for values in PHASES.values())
    assert motor.peak_current == float(max(map(abs, a + b)))
    assert motor.mean_current == max(mean([abs(value) for value in phase]) for phase in (a, b))
    assert motor.peak_command == float(max(max(map(abs, a)), max(value * value for value in b)))
    assert motor.mean_command == max(mean([abs(value) for value in a]), mean([value * value for value in b]))


def test_an_event(metrics: Metrics) -> None:
    (event,) = metrics.events
    assert (event.name, event.time, event.end) == ("pull", 3.0, TIME[31])
    for deviation in event.deviations:
        exact = [abs(error) for error in fraction(ERRORS[deviation.of][EVENT])]
        assert deviation.peak_deviation == float(max(exact))
        assert deviation.integral_absolute_error == trapezoids(exact)
    (effort,) = event.efforts
    a, b = (fraction(values[EVENT]) for values in PHASES.values())
    squares = [left * left + right * right for left, right in zip(a, b, strict=True)]
    assert effort.rms_current == math.sqrt(mean(squares) / 2)
    assert effort.ohmic_loss == trapezoids([Fraction(3, 2) * square for square in squares])

    def noise(command: list[Fraction]) -> float:
        changes = [right - left for left, right in itertools.pairwise(command)]
        return math.sqrt(mean([change * change for change in changes]) / 2)

    assert effort.command_noise == max(noise(a), noise([value * value for value in b]))
