"""Verdicts on claims that compare two runs, or two axes of one."""

import math
from dataclasses import replace
from typing import Any

import pytest
from facts import raises

from maglev.files.errors import MeasurementError
from maglev.runs.metrics import Metrics, MotorCurrents, StepResponse, TrackingError
from maglev.runs.verdicts import ClaimResult, judge_run
from maglev.scenario.claims import RunClaim


def claim(**table: Any) -> RunClaim:
    return RunClaim.model_validate({"text": "a claim", "source": "p. 1", **table})


def run(settling: dict[str, tuple[float, ...]], tracking: float = 1e-3, **values: Any) -> Metrics:
    """A run with a settling time (s) for each step of each axis, one step a second."""
    steps = tuple(StepResponse(axis, float(k), 0.0, 0.01, {1e-4: time}, time / 10.0, 0.0)
                  for axis, times in settling.items() for k, time in enumerate(times))
    rest = {"motors": (MotorCurrents("alpha", 5.0, 1.0, 6.0, 2.0),), "end_errors": {}, "stop_contact": None,
            "tripped": None, "failed": False, **values}
    return Metrics(steps, (TrackingError("y", tracking, 2.0 * tracking, 1.0),), **rest)


SLOW = run({"y": (4.0, 2.0), "x": (3.0, 3.0)})
FAST = run({"y": (2.0, 3.0), "x": (1.0, 1.0)}, tracking=0.1e-3)
LESS = run({"y": (1.0,)}, motors=(MotorCurrents("alpha", 4.8, 0.95, 5.4, 2.3),))
SETTLING = {"metric": "settling_time", "band": "0.1 mm", "than": "fast"}


def judged(metrics: Metrics | None = SLOW, **table: Any) -> ClaimResult:
    (result,) = judge_run([claim(**table)], metrics, {"fast": FAST, "less": LESS, "dead": None})
    return result


@pytest.mark.parametrize(("table", "expected"), [
    # Of all steps the second of y decides, where the slow run is the faster.
    ({**SETTLING, "relation": ">"}, ("not reproduced", 2.0, 3.0)),
    ({**SETTLING, "relation": ">", "over": "any"}, ("reproduced", 3.0, 1.0)),
    ({**SETTLING, "relation": ">", "over": "mean"}, ("reproduced", 3.0, 1.75)),
    ({**SETTLING, "relation": "<", "over": "mean"}, ("not reproduced", 3.0, 1.75)),
    ({**SETTLING, "relation": ">", "axis": "x"}, ("reproduced", 3.0, 1.0)),
    ({**SETTLING, "relation": ">", "axis": "x", "factor": 3.0}, ("within 10 %", 3.0, 1.0)),
    ({**SETTLING, "relation": ">", "axis": "x", "factor": 3.2}, ("within 10 %", 3.0, 1.0)),
    ({**SETTLING, "relation": ">", "axis": "x", "factor": 3.5}, ("not reproduced", 3.0, 1.0)),
    ({"metric": "overshoot", "relation": ">", "axis": "y", "than_axis": "x", "over": "any"}, ("reproduced", 0.4, 0.3)),
    ({"metric": "mean_tracking_error", "relation": ">", "factor": 9.0, "than": "fast"}, ("reproduced", 1e-3, 0.1e-3)),
    ({"metric": "mean_tracking_error", "relation": "<", "axis": "y", "than": "fast", "than_axis": "y"},
     ("not reproduced", 1e-3, 0.1e-3)),
    ({"metric": "peak_current", "relation": "<", "than": "fast"}, ("no difference", 5.0, 5.0)),
    ({"metric": "peak_current", "relation": ">", "than": "less"}, ("no difference", 5.0, 4.8)),
    ({"metric": "peak_current", "relation": "<", "than": "less"}, ("no difference", 5.0, 4.8)),
    ({"metric": "mean_current", "relation": ">", "than": "less"}, ("reproduced", 1.0, 0.95)),
    ({"metric": "mean_current", "relation": "<", "than": "less"}, ("not reproduced", 1.0, 0.95)),
    # A tenth is significant, and less is not.
    ({"metric": "mean_current", "relation": ">", "factor": "significantly", "than": "less"},
     ("not reproduced", 1.0, 0.95)),
    ({"metric": "mean_current", "relation": "<", "factor": "not significantly", "than": "less"},
     ("reproduced", 1.0, 0.95)),
    ({"metric": "mean_current", "relation": ">", "factor": "not significantly", "than": "less"},
     ("reproduced", 1.0, 0.95)),
    ({"metric": "peak_command", "relation": ">", "factor": "significantly", "than": "less"}, ("reproduced", 6.0, 5.4)),
    ({"metric": "peak_command", "relation": "<", "factor": "not significantly", "than": "less"},
     ("not reproduced", 6.0, 5.4)),
    ({"metric": "mean_command", "relation": "<", "factor": "significantly", "than": "less"}, ("reproduced", 2.0, 2.3)),
    # Ratios of y are 2 and 2/3, those of x 3 and 3: the median is of 2 and 3.
    ({**SETTLING, "relation": ">", "over": "median"}, ("reproduced", 3.5, 1.5)),
    ({**SETTLING, "relation": ">", "over": "median", "axis": "y"}, ("reproduced", 3.0, 2.5)),
    ({"metric": "overshoot", "relation": "<", "than": "dead"}, ("not run", None, None)),
    ({"metric": "overshoot", "relation": "<", "than": "absent"}, ("not run", None, None))])
def test_comparisons(table: dict[str, Any], expected: tuple[Any, ...]) -> None:
    result = judged(**table)
    measured, against = expected[1:]
    assert result.verdict == expected[0]
    assert result.measured == (None if measured is None else pytest.approx(measured))
    assert result.against == (None if against is None else pytest.approx(against))


def test_a_run_that_did_not_complete_is_not_judged() -> None:
    result = judged(None, metric="failed", relation="is", target=True)
    assert (result.verdict, result.measured_text, result.note) == ("not run", "", "")


def test_never_settled_against_settled() -> None:
    never = run({"y": (math.inf, math.inf)})
    assert judged(never, **SETTLING, relation=">").verdict == "reproduced"
    assert judged(never, **SETTLING, relation="<").verdict == "not reproduced"
    (both,) = judge_run([claim(**{**SETTLING, "than": "never"}, relation=">")], never, {"never": never})
    assert both.verdict == "no difference", "equal is not more"
    assert both.measured_text == "not settled against not settled"


def test_trips_and_lost_setpoints() -> None:
    tripped = run({"y": (1.0,)}, tripped=5.4, failed=True, lost=(("y", 1.0), ("y", 6.0)))
    table = {"metric": "trip_time", "relation": "about", "target": "5.5 s", "digits": 2}
    assert judged(tripped, **table).verdict == "reproduced"
    assert judged(replace(tripped, tripped=5.1), **table).verdict == "within 10 %"
    assert judged(SLOW, **table).measured_text == "never"
    table = {"metric": "lost_setpoints", "relation": ">", "target": 1}
    assert judged(tripped, **table).verdict == "reproduced"
    assert judged(tripped, **table).measured_text == "2"
    assert judged(SLOW, **table).verdict == "not reproduced"


def test_nothing_at_the_same_place_is_refused() -> None:
    with raises(MeasurementError, "'a claim'", "fast", "overshoot"):
        judged(run({"z": (1.0,)}), metric="overshoot", relation="<", than="fast")
    with raises(MeasurementError, "'a claim'", "z", "fast", "overshoot"):
        judged(SLOW, metric="overshoot", relation="<", than="fast", than_axis="z")


def test_reason_is_shown_where_it_is_needed() -> None:
    table: dict[str, Any] = {"metric": "overshoot", "relation": "<", "than": "fast", "over": "mean", "reason": "why"}
    assert judged(**table).note == "why"
    assert judged(**{**table, "relation": ">"}).note == ""


def test_most_steps_outvote_a_long_one() -> None:
    """Four of five steps settle sooner, the fifth so much later that the mean is longer: the median decides."""
    slow, fast = run({"v": (0.8, 0.7, 0.85, 0.75, 2.0)}), run({"v": (0.95, 0.9, 0.95, 0.95, 0.5)})
    longer = claim(**{**SETTLING, "relation": ">", "over": "median"})
    (result,) = judge_run([longer], slow, {"fast": fast})
    assert (result.verdict, result.measured, result.against) == ("not reproduced", 0.8, 0.95)
    (result,) = judge_run([longer.model_copy(update={"over": "mean"})], slow, {"fast": fast})
    assert result.verdict == "reproduced"


def test_a_claim_of_a_users_own_needs_no_margin() -> None:
    table: dict[str, Any] = {"metric": "peak_current", "relation": ">", "than": "less"}
    assert judged(**table).verdict == "no difference"
    assert judged(**table, own=True).verdict == "met"


@pytest.mark.parametrize(("table", "kind"), [
    ({"metric": "mean_tracking_error", "relation": "about", "target": "1 mm"}, "number"),
    ({**SETTLING, "relation": ">"}, "ordering"),
    ({"metric": "overshoot", "relation": "<", "target": "30 %"}, "specification"),
    ({"metric": "failed", "relation": "is", "target": False}, "survival"),
    ({"metric": "lost_setpoints", "relation": ">", "target": 1, "kind": "survival"}, "survival"),
    ({"not_testable": "why", "kind": "ordering"}, "ordering")])
def test_a_claim_says_what_kind_it_is(table: dict[str, Any], kind: str) -> None:
    assert claim(**table).kind == kind


def test_sources_mark_thresholds_of_this_project() -> None:
    limit = {"metric": "overshoot", "relation": "<", "target": "30 %"}
    assert claim(**limit).cited == "p. 1"
    assert claim(**limit, assumed=True).cited == "p. 1; the limit is ours"
    assert claim(**SETTLING, relation=">", factor="significantly").cited == "p. 1; the factor is ours"
    assert claim(**SETTLING, relation=">", factor="significantly", own=True).cited == "p. 1"
