"""Measures as rows, and rows of several runs side by side."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_runs import packaged, recorded

from maglev.pages.comparison_table import Row, comparison_verdict, measure_rows, summary
from maglev.pages.figures import run_colours
from maglev.runs.measures import Measure, measures_data, measures_of
from maglev.runs.measuring import run_metrics
from maglev.scenario.run_plan import RunPlan


@pytest.fixture(scope="module")
def plan() -> RunPlan:
    return packaged("2dof-smooth-nonlinear")


def columns_of(plan: RunPlan, time: np.ndarray, errors: dict[str, np.ndarray]) -> dict[str, Any]:
    """Columns of a run whose axes miss a reference at rest by these errors."""
    columns = {}
    for name, axis in plan.axes.items():
        columns[axis.reference] = np.full(len(time), 0.02)
        columns[axis.position] = 0.02 + errors[name]
    for motor in plan.motors.values():
        columns |= {name: np.sin(time) for name in [*motor.currents, *motor.commands]}
    for flag in (plan.stop_flag, plan.trip_flag):
        if flag is not None:
            columns[flag] = np.zeros(len(time))
    return columns


def test_rms_error_of_a_sinusoid(plan: RunPlan) -> None:
    """Over whole periods the root of the mean square of A sin is A / sqrt(2)."""
    time = np.linspace(0.0, 4.0, 40000, endpoint=False)
    error = {"v": 3e-3 * np.sin(2.0 * np.pi * time), "h": np.full(len(time), -2e-3)}
    metrics = run_metrics(plan, time, columns_of(plan, time, error))
    found = {(each.quantity, each.of): each for each in measures_of(plan, metrics)}
    assert found["rms error", "v"].value == pytest.approx(3e-3 / math.sqrt(2.0), rel=1e-9)
    assert found["rms error", "h"].value == pytest.approx(2e-3, rel=1e-9)
    assert (found["rms error", "v"].unit, found["rms error", "v"].time) == ("m", None)


def test_a_motor_without_recorded_currents_has_no_best_peak(plan: RunPlan) -> None:
    time = np.linspace(0.0, 1.0, 100)
    metrics = run_metrics(plan, time, columns_of(plan, time, {"v": 0.0 * time, "h": 0.0 * time}))
    motors = {name: motor.model_copy(update={"currents": []}) for name, motor in plan.motors.items()}
    without = plan.model_copy(update={"motors": motors})
    assert "peak current" in {each.quantity for each in measures_of(plan, metrics)}
    assert "peak current" not in {each.quantity for each in measures_of(without, metrics)}


def settled(*times: float) -> list[Measure]:
    """Settling times of an axis after steps at 0, 1, … s."""
    return [Measure("settling time to 10 µm", "y", float(k), value, "s") for k, value in enumerate(times)]


def test_every_step_is_a_row_and_the_worst_of_all_is_the_summary() -> None:
    rows = measure_rows({"a": settled(1.0, 3.0), "b": settled(2.0, math.inf)})
    assert [(row.name, dict(row.values), row.best) for row in rows] == [
        ("settling time to 10 µm at 0 s", {"a": 1.0, "b": 2.0}, ("a",)),
        ("settling time to 10 µm at 1 s", {"a": 3.0, "b": math.inf}, ("a",))]
    (worst,) = summary(rows)
    assert worst.name == "settling time to 10 µm, worst of 2"
    assert (worst.text("a"), worst.text("b")) == ("3 s", "not settled")


def test_a_missing_value_is_a_dash_and_not_the_best() -> None:
    (row,) = measure_rows({"a": settled(1.0), "b": []})
    assert (row.text("b"), row.best) == ("–", ())


def test_an_infinite_time_is_null_in_json() -> None:
    assert [each["value"] for each in measures_data(settled(1.0, math.inf))] == [1.0, None]


def test_a_tie_has_no_winner_and_two_that_are_alike_share_a_win() -> None:
    (tie,) = measure_rows({"a": settled(1.0), "b": settled(1.000089)})
    assert (tie.best, tie.lead) == ((), 1.0)
    (three,) = measure_rows({"a": settled(1.04), "b": settled(1.0), "c": settled(1.3)})
    assert (three.best, three.lead) == (("a", "b"), 1.3)


@pytest.mark.parametrize("flaw", ["failed", "ended off"])
def test_a_run_that_failed_or_ended_off_wins_nothing(flaw: str) -> None:
    crash = Measure(flaw, "", None, 1.0, "")
    held = Measure(flaw, "", None, 0.0, "")
    rows = measure_rows({"crash": [*settled(0.5), crash], "a": [*settled(1.0), held], "b": [*settled(2.0), held]})
    assert [row.best for row in rows] == [("a",)]
    assert [row.best for row in summary(rows)] == [("a",)]
    (alone,) = measure_rows({"crash": [*settled(0.5), crash], "a": [*settled(1.0), held]})
    assert alone.best == ()   # no contest


def measured(v: float, h: float, current: float) -> list[Measure]:
    """Rms errors (m) and a peak current (A) of a run."""
    return [Measure("rms error", "v", None, v, "m"), Measure("rms error", "h", None, h, "m"),
            Measure("peak current", "motor", None, current, "A")]


@pytest.mark.parametrize(("b", "words"), [
    (measured(2e-5, 4e-5, 2.0), "a is better in 2 of 2 rows about axes (most in rms error of v, 10 µm against 20 µm); "
     "of 1 row about motors b is better in 1."),
    (measured(1e-5, 2.42e-5, 3.0), "a is better in 1 of 2 rows about axes (most in rms error of h, 20 µm "
     "against 24.2 µm)."),
    (measured(1.02e-5, 2e-5, 6.0), "a and b are equal in 2 of 2 rows about axes; of 1 row about motors a is better "
     "in 1."),
    (measured(2e-5, 1e-5, 3.0), "No run leads: of 2 rows about axes a is better in 1 (most in rms error "
     "of v, 10 µm against 20 µm); b in 1 (most in rms error of h, 10 µm against 20 µm).")])
def test_the_verdict_says_who_is_better_and_where(plan: RunPlan, b: list[Measure], words: str) -> None:
    rows = summary(measure_rows({"a": measured(1e-5, 2e-5, 3.0), "b": b}))
    assert comparison_verdict({"a": recorded(plan), "b": recorded(plan)}, rows) == words
    pairs = [(max(pair), min(pair)) for pair in zip((1e-5, 2e-5, 3.0), [each.value for each in b], strict=True)]
    assert [row.lead for row in rows] == [pytest.approx(most / least if most > 1.05 * least else 1.0)
                                          for most, least in pairs]


def axis_measures(rms: float, settling: float, overshoot: float) -> list[Measure]:
    """What the axes of a run with one step each give."""
    return [measure for axis in "vh" for measure in (
        Measure("rms error", axis, None, rms, "m"), Measure("settling time to 0.1 mm", axis, 1.0, settling, "s"),
        Measure("overshoot", axis, 1.0, overshoot, "1"))]


def test_runs_of_one_rms_error_are_not_alike_where_settling_and_overshoot_differ(plan: RunPlan) -> None:
    """What the sentence says, the table below it shows."""
    measures = {"a": axis_measures(1e-5, 0.105, 0.014), "b": axis_measures(1.02e-5, 0.377, 0.37)}
    rows = summary(measure_rows(measures))
    assert sum(row.best == ("a",) for row in rows) == 4
    assert comparison_verdict({label: recorded(plan) for label in measures}, rows) == (
        "a is better in 4 of 6 rows about axes (most in overshoot of v, 1.4 % against 37 %).")


def test_never_settling_weighs_more_than_a_zero(plan: RunPlan) -> None:
    measures = {"a": axis_measures(1e-5, 0.1, 0.0), "b": axis_measures(1e-5, math.inf, 0.001)}
    said = comparison_verdict({label: recorded(plan) for label in measures}, summary(measure_rows(measures)))
    assert "most in settling time to 0.1 mm of v, 0.1 s against not settled" in said


def test_of_more_than_two_the_verdict_counts_where_all_were_measured(plan: RunPlan) -> None:
    measures = {"a": measured(1e-5, 2e-5, 3.0)[:2], "b": measured(2e-5, 4e-5, 1.0), "c": measured(3e-5, 1e-5, 2.0)}
    said = comparison_verdict({label: recorded(plan) for label in measures}, summary(measure_rows(measures)))
    assert said == ("No run leads: of 2 rows about axes a is best in 1 (most in rms error of v, 10 µm "
                    "against 20 µm); c in 1 (most in rms error of h, 10 µm against 20 µm).")


def test_the_verdict_is_for_who_held_alone(plan: RunPlan) -> None:
    lost, said = recorded(plan, failed=True, stop_contact=0.25), "b failed: touched an end stop at 0.250 s."
    assert comparison_verdict({"a": recorded(plan), "b": lost}, []) == f"Only a completed; {said}"
    assert comparison_verdict({"b": lost}, []) == f"No run completed; {said}"
    assert comparison_verdict({"a": recorded(plan)}, []) == "a completed."


def test_a_controller_has_its_colour_and_others_a_free_one() -> None:
    runs = {label: recorded(packaged(f"2dof-step-4-{law}")) for label, law in
            (("x", "linear"), ("y", "nonlinear"), ("z", "nonlinear"))}
    assert run_colours(runs) == {"x": 2, "y": 0, "z": 1}


@given(st.dictionaries(st.sampled_from("abcde"), st.floats(0.0, math.inf), min_size=1),
       st.frozensets(st.sampled_from("abcde")))
def test_the_best_are_those_that_no_other_that_held_beats(values: dict[str, float], failed: frozenset[str]) -> None:
    found = Row("rms error", "y", None, "m", values, dict.fromkeys(failed, "failed")).best
    held = {label: value for label, value in values.items() if label not in failed}
    assert set(found) <= set(held)
    assert all(values[label] < other for label in found for name, other in held.items() if name not in found)
    assert found or max(held.values(), default=0.0) <= 1.05 * min(held.values(), default=0.0)
