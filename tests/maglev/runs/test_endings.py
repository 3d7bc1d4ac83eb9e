"""How runs ended, in words: which of a stop and a trip, when, on which axis, or how far off."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from maglev.runs.endings import cause, ending, endings, severity
from maglev.runs.metrics import ManyMetrics, Metrics, axes_at_stops, axes_furthest_off
from maglev.scenario.loading import load_plan

QUIET = Metrics((), (), (), {"y": 0.0, "x": 0.0, "z": 0.0}, None, None, False)
STOPPED = replace(QUIET, stop_contact=0.25, stop_axis="x", failed=True)
ENDINGS = [
    (QUIET, "completed", ""), (STOPPED, "failed: touched an end stop on x at 0.250 s", "an end stop on x"),
    (replace(STOPPED, tripped=0.125, trip_axis="z"),
     "failed: the controller tripped on z at 0.125 s, touched an end stop on x at 0.250 s", "a trip on z"),
    (replace(STOPPED, ended_off={"x": 4e-3}), "failed: touched an end stop on x at 0.250 s", "an end stop on x"),
    (replace(QUIET, ended_off={"z": 1.04e-3}), "ended off target: 1.04 mm on z", "an end off target on z"),
    (replace(QUIET, ended_off={"y": 2e-3, "z": 1.5e-3}), "ended off target: 2 mm on y, 1.5 mm on z",
     "an end off target on y")]


@pytest.mark.parametrize(("metrics", "said", "why"), ENDINGS)
def test_an_ending_has_cause_time_and_axis(metrics: Metrics, said: str, why: str) -> None:
    plan = load_plan("3dof-setpoints")
    assert ending(plan, metrics) == said
    assert cause(said) == why


def test_endings_of_many_runs_equal_those_of_each() -> None:
    plan = load_plan("3dof-setpoints")
    runs = [metrics for metrics, _, _ in ENDINGS]
    never = [inf if time is None else time for run in runs for time in (run.stop_contact, run.tripped)]
    many = ManyMetrics(
        (), (), (), {axis: np.array([run.ended_off.get(axis, 0.0) for run in runs]) for axis in plan.axes}, {}, (),
        {}, np.array(never[::2]), np.array(never[1::2]), np.array([run.failed for run in runs]),
        np.array([bool(run.ended_off) for run in runs]), np.array([run.stop_axis for run in runs]),
        np.array([run.trip_axis for run in runs]))
    assert endings(plan, many) == [said for _, said, _ in ENDINGS]


def test_the_worst_endings_go_first() -> None:
    said = ["did not complete: at t = 1 s: off on the bus", "failed: touched an end stop at 1.000 s",
            "failed: the controller tripped at 1.000 s", "ended off target: 2 mm on y", "completed"]
    assert [*map(severity, said)] == [*range(5)]
    assert cause(said[0]) == "an abort"


def test_the_axis_at_a_stop_is_the_one_that_is_there() -> None:
    """Whatever the errors are: y at the lower stop of the scenario, then x at the upper one of the description."""
    plan = load_plan("3dof-setpoints")
    assert plan.stage is not None
    stops = {axis.name: axis.stop for axis in plan.stage.axes}
    assert stops["x"] is not None and stops["y"] is not None
    at = {"y": 0.5 * (stops["y"].lower + stops["y"].upper), "x": 0.0, "z": 0.0}
    for axis, place in (("y", stops["y"].lower - 1e-6), ("x", stops["x"].upper + 1e-6)):
        positions = np.array([[{**at, axis: place}[name] for name in plan.axes]])
        assert axes_at_stops(plan, positions, np.array([[0.0, 0.0, 9e-3]])).tolist() == [axis]
    tracking = load_plan("3dof-tracking-pid")   # its scenario moves the stops of y
    lower = float(tracking.fmus["plant"].start["y.stop.lower"].value)
    positions = np.array([[{**at, "y": lower - 1e-6}[name] for name in tracking.axes]])
    assert axes_at_stops(tracking, positions, np.zeros((1, 3))).tolist() == ["y"]


def test_where_stops_are_at_motors_the_axis_is_the_one_furthest_off() -> None:
    plan = load_plan("5dof-setpoints")
    axes = list(plan.axes)
    errors = np.array([[4e-4 if name == "x" else 3e-3 if name == "roll" else 0.0 for name in axes]])
    inside = np.array([[plan.stage.vertical.start if plan.stage is not None and name == "y" else 0.0 for name in axes]])
    assert axes_at_stops(plan, inside, errors).tolist() == ["roll"]   # 3 of 5 mrad against 0.4 of 1 mm
    assert axes_furthest_off(plan, errors).tolist() == ["roll"]
