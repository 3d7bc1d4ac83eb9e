"""Procedure 1 on exact parabolas: their thrust comes back, whatever happens behind the stroke."""

from collections.abc import Callable

import numpy as np
import pytest
from motor import MOTOR
from report_runs import with_columns

from maglev.runs.execution import RunResult
from maglev.runs.procedure_outcome import Outcome
from maglev.runs.procedures import evaluate_all
from maglev.scenario.loading import load_plans
from pmlsm.gap_functions import gap_functions

Simulated = Callable[..., RunResult]

GAPS = {"2dof": [10.0, 12.5, 15.0, 17.5, 20.0, 22.5, 25.0, 27.5],
        "3dof": [15.0, 17.5, 20.0, 22.5, 25.0, 27.5, 30.0, 32.5, 35.0]}   # mm


def outcome_of(results: list[RunResult]) -> Outcome:
    (found,) = evaluate_all(results)
    return found


def values(outcome: Outcome, name: str, **place: object) -> dict[float, float]:
    """Values of a name by air gap, mm; of an axis, a constant or at an ε."""
    return {round(1e3 * (found.gap or 0.0), 6): found.value for found in outcome.values
            if found.name == name and all(getattr(found, key) == value for key, value in place.items())}


def thrust_at(gap: float, constant: float) -> float:
    return constant * gap_functions(MOTOR, 1e-3 * gap)[0]


def with_estimate(result: RunResult, estimator: str, constant: str, share: float) -> RunResult:
    """The same with another estimate."""
    name = f"{estimator}.{constant}"
    return with_columns(result, {**result.columns, name: share * result.columns[name]})


def behind_the_stroke(result: RunResult, axis: str, end: float) -> RunResult:
    """The same with a mover that bounces from a stop behind its stroke, with other currents and estimates."""
    columns = {name: np.array(column) for name, column in result.columns.items()}
    position = columns[f"plant.{axis}.encoder"]
    beyond = np.flatnonzero(position >= end)[1:]
    assert len(beyond) > 20
    position[beyond] = end + 5e-3 * np.sin(np.arange(len(beyond)) / 3.0)
    for name, column in columns.items():
        if name.startswith("estimator") or name.endswith(".i_q"):
            column[beyond] *= 3.0
    return with_columns(result, columns)


def test_thrust_of_the_2dof_stage(drive: Simulated) -> None:
    """A constant of its own at each air gap; the estimators are off by known shares."""
    constants = dict(zip(GAPS["2dof"], np.linspace(12.0, 16.0, 8).tolist(), strict=True))
    runs = []
    for run in load_plans("2dof-parabolas"):
        gap = 1e3 * float(run.fmus["plant"].start["v.position_start"].value)
        result = drive(run.name, {"h": thrust_at(gap, constants[gap])})
        for estimator, share in (("estimator_1ms", 0.99), ("estimator_10ms", 1.02), ("estimator_50ms", 1.1)):
            result = with_estimate(result, estimator, "C1", share)
        runs.append(result)
    outcome = outcome_of(runs)
    assert outcome.runs == tuple(sorted(run.plan.name for run in runs))
    assert values(outcome, "thrust", axis="h") == pytest.approx(
        {gap: thrust_at(gap, constant) for gap, constant in constants.items()}, rel=1e-9)
    for epsilon, share in ((0.001, 0.01), (0.01, 0.02), (0.05, 0.1)):
        assert values(outcome, "estimator_deviation", epsilon=epsilon) == pytest.approx(
            dict.fromkeys(GAPS["2dof"], share), rel=1e-6)
    (average,) = (found.value for found in outcome.values if found.name == "average_constant")
    assert average == pytest.approx(14.0, rel=1e-9)
    assert values(outcome, "simultaneous_deviation") == {}
    assert [chart.number for chart in outcome.charts] == ["4.8", "4.9"]
    (table,) = outcome.tables
    assert [row[0] for row in table.rows] == [f"{gap:g}" for gap in GAPS["2dof"]]
    assert table.rows[0][1] == f"{thrust_at(10.0, 12.0):.4g}"
    measured = outcome.charts[1].panels[0].curves[0]
    assert list(measured.x) == pytest.approx(GAPS["2dof"])
    assert list(measured.y) == pytest.approx([thrust_at(gap, constants[gap]) for gap in GAPS["2dof"]])


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
def test_thrust_of_the_3dof_stage_alone_and_with_both_axes(drive: Simulated) -> None:
    """Two motors drive each axis; with both, the estimates here differ by 3 %."""
    runs = []
    for run in load_plans("3dof-parabolas"):
        gap = 1e3 * float(run.fmus["plant"].start["y.position_start"].value)
        kind = run.name.removeprefix("3dof-parabolas-").partition("-")[0]
        thrusts = {"x": thrust_at(gap, 0.65), "z": thrust_at(gap, 0.9)}
        result = drive(run.name, thrusts if kind == "both" else {kind: thrusts[kind]}, rows=4000)
        if kind == "both":
            result = with_estimate(result, "estimator_10ms", "C2", 0.97)
        runs.append(result)
    outcome = outcome_of(runs)
    for axis, constant, truth in (("x", "C1", 0.65), ("z", "C2", 0.9)):
        expected = {gap: thrust_at(gap, truth) for gap in GAPS["3dof"]}
        assert values(outcome, "thrust", axis=axis) == pytest.approx(expected, rel=1e-9)
        (average,) = (found for found in outcome.values if found.name == "average_constant" and found.axis == axis)
        assert (average.constant, average.value) == (constant, pytest.approx(truth, rel=1e-9))
    assert values(outcome, "simultaneous_deviation", axis="x") == pytest.approx(dict.fromkeys(GAPS["3dof"], 0.0),
                                                                                abs=1e-12)
    assert values(outcome, "simultaneous_deviation", axis="z") == pytest.approx(dict.fromkeys(GAPS["3dof"], 0.03))
    assert [chart.number for chart in outcome.charts] == ["5.7", "5.8", "5.9", "5.10"]
    assert [panel.y_title for panel in outcome.charts[3].panels] == ["L of x (m/(s²·A))", "L of z (m/(s²·A))"]


@pytest.mark.parametrize(("name", "axis", "end"), [("2dof-parabolas-20mm", "h", 0.05),
                                                   ("3dof-parabolas-x-20mm", "x", 0.06)])
def test_what_is_behind_the_stroke_does_not_count(drive: Simulated, name: str, axis: str, end: float) -> None:
    clean = drive(name, {axis: 0.2}, rows=4000) if axis == "x" else drive(name, {axis: 6.0}, rows=1000)
    spoiled = behind_the_stroke(clean, axis, end)
    first, second = outcome_of([clean]), outcome_of([spoiled])
    assert values(first, "thrust") == pytest.approx({20.0: 0.2 if axis == "x" else 6.0}, rel=1e-9)
    assert first.values == second.values
    # The figure shows the stroke.
    assert max(second.charts[0].panels[0].curves[0].y) == pytest.approx(1e3 * end, rel=0.01)


def test_the_axis_that_is_there_first_ends_the_stroke_of_both(drive: Simulated) -> None:
    clean = drive("3dof-parabolas-both-20mm", {"x": 0.2, "z": 0.3}, rows=4000)
    end = int(np.flatnonzero(clean.columns["plant.z.encoder"] >= 0.06)[0]) + 1
    assert clean.columns["plant.x.encoder"][end] < 0.05
    later = np.arange(4000) >= end
    spoiled = with_columns(clean, {name: np.where(later, 3.0 * values, values) if name.startswith("estimator")
                                   else values for name, values in clean.columns.items()})
    alone = drive("3dof-parabolas-x-20mm", {"x": 0.2}, rows=4000)
    found = outcome_of([alone, spoiled])
    assert values(found, "simultaneous_deviation", axis="x") == pytest.approx({20.0: 0.0}, abs=1e-12)


def test_a_stroke_that_is_cut_short_is_fitted_as_far_as_it_goes(drive: Simulated) -> None:
    found = outcome_of([drive("2dof-parabolas-20mm", {"h": 6.0}, rows=100)])
    assert values(found, "thrust") == pytest.approx({20.0: 6.0}, rel=1e-9)


def test_both_axes_without_one_alone_have_nothing_to_compare_with(drive: Simulated) -> None:
    found = outcome_of([drive("3dof-parabolas-both-20mm", {"x": 0.2, "z": 0.3})])
    assert found.values == ()
    other_gap = outcome_of([drive("3dof-parabolas-both-20mm", {"x": 0.2, "z": 0.3}),
                            drive("3dof-parabolas-x-25mm", {"x": 0.2})])
    assert values(other_gap, "simultaneous_deviation") == {}
    assert list(values(other_gap, "thrust", axis="x")) == [25.0]
