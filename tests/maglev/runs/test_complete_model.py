"""Procedure 4: the model next to the stage, on a run of the blocks and motions that differ from it by known shares."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from identification_data import Data, record
from motor import MOTOR
from report_runs import with_columns

from maglev.identification.estimators import run_estimator
from maglev.identification.identify import identify, observed
from maglev.identification.regressors import equilibrium_currents, regressors
from maglev.pages.charts import curve_data
from maglev.runs.execution import RunResult
from maglev.runs.procedure_outcome import Outcome
from maglev.runs.procedures import evaluate_all
from pmlsm.gap_functions import gap_functions

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

Simulated = Callable[..., RunResult]
Constants = dict[str, dict[str, float]]

DT = 1e-3   # s, as results of the 2-DOF stage are written


@pytest.fixture(scope="module")
def trial() -> Data:
    """A second and a half of the ideal 2-DOF stage, excited."""
    return record("2dof", 1.5, DT)


def columns_of(data: Data) -> dict[str, Any]:
    recording = data.recording
    found: dict[str, Any] = {"motor.i_d": recording.i_d[:, 0], "motor.i_q": recording.i_q[:, 0]}
    for k, axis in enumerate(recording.stage.axes):
        found |= {f"{axis}.encoder": recording.positions[:, k], f"{axis}.position": recording.positions[:, k],
                  f"{axis}.velocity": data.velocity[:, k]}
    return found


@pytest.fixture
def stage(simulated: Simulated, trial: Data) -> RunResult:
    """The run of the stage, with estimates of `CONSTANTS`."""
    return simulated("2dof-identification-rig", trial.recording.time, columns_of(trial))


def model_of(simulated: Simulated, data: Data, rows: int, shares: Mapping[str, float]) -> RunResult:
    """A model whose motion about the mean of the stage is larger by a share; a column without one is the stage's."""
    columns = {name: values[:rows] + shares.get(name, 0.0) * (values[:rows] - values[:rows].mean())
               for name, values in columns_of(data).items()}
    return simulated("2dof-identification-model", data.recording.time[:rows], columns)


def outcome_of(*results: RunResult) -> Outcome:
    (found,) = [each for each in evaluate_all(results) if each.settings.kind == "identification"]
    return found


def deviations(outcome: Outcome) -> dict[str, float]:
    return {f"{found.axis}.{found.name.partition('_')[0]}": found.value for found in outcome.values
            if found.name.endswith("_deviation")}


@pytest.mark.parametrize("rows", [1500, 600])
def test_a_model_that_runs_as_the_stage_deviates_by_nothing(simulated: Simulated, trial: Data, stage: RunResult,
                                                           rows: int) -> None:
    """Also where it ran for less time."""
    found = outcome_of(stage, model_of(simulated, trial, rows, {}))
    assert deviations(found) == dict.fromkeys(("v.position", "v.speed", "h.position", "h.speed"), 0.0)
    assert found.runs == ("2dof-identification-rig", "2dof-identification-model")


@pytest.mark.parametrize("rows", [1500, 600])
def test_a_model_that_moves_further_by_a_share_deviates_by_that(simulated: Simulated, trial: Data, stage: RunResult,
                                                                rows: int) -> None:
    model = model_of(simulated, trial, rows, {"v.position": 0.03, "h.position": -0.02, "h.velocity": 0.5})
    assert deviations(outcome_of(stage, model)) == pytest.approx(
        {"v.position": 0.03, "v.speed": 0.0, "h.position": 0.02, "h.speed": 0.5}, rel=1e-9, abs=1e-12)


def test_a_constant_offset_counts(simulated: Simulated, trial: Data, stage: RunResult) -> None:
    """Of a millimetre, next to the standard deviation of the stage's motion."""
    model = model_of(simulated, trial, 1500, {})
    position = np.array(model.columns["plant.v.position"])
    moved = with_columns(model, {**model.columns, "plant.v.position": position + 1e-3})
    assert deviations(outcome_of(stage, moved))["v.position"] == pytest.approx(1e-3 / position.std())


def test_constants_with_every_epsilon(stage: RunResult, constants: Constants) -> None:
    found = outcome_of(replace(stage, ends={**stage.ends, "estimator_1ms.C4": 0.25}))
    values = {(each.constant, each.epsilon): each.value for each in found.values}
    expected = {(name, epsilon): value for name, value in constants["2dof"].items() for epsilon in (0.001, 0.01, 0.05)}
    assert values == {**expected, ("C4", 0.001): 0.25}
    assert found.tables[0].title.startswith("Table 4.3: ")


def test_the_same_offline_is_on_the_recorded_rows(stage: RunResult, trial: Data) -> None:
    """The three estimators of chapter 3, from the guesses of the estimator FMU."""
    table = outcome_of(stage).tables[1]
    assert table.header[0] == "constant"
    assert set(table.header[1:4]) == {"reduced", "full", "fsdi"}
    recording = trial.recording
    rows = regressors(recording.stage, recording.positions, recording.i_d, recording.i_q,
                      observed(recording.positions, recording.dt))
    for method in ("reduced", "full", "fsdi"):
        final = run_estimator(method, rows, recording.time, recording.stage.guess, 0.01).final
        place = table.header.index(method)
        assert [row[place] for row in table.rows] == [f"{final[row[0]]:.5g}" for row in table.rows]
    assert [row[0] for row in table.rows] == ["C1", "C2", "C3", "C4"]


def test_figures_have_the_runs_of_other_procedures_beside_it(stage: RunResult, staircase: Simulated, drive: Simulated,
                                                             constants: Constants) -> None:
    parabolas = [drive(f"2dof-parabolas-{gap}mm", {"h": 14.0 * gap_functions(MOTOR, 1e-3 * gap)[0]})
                 for gap in (15, 20)]
    charts = {chart.number: chart for chart in outcome_of(stage, staircase("2dof"), *parabolas).charts}
    assert set(charts) == {"4.13", "4.14", None}
    at_once, by_parabola, held = charts["4.13"].panels[0].curves
    assert list(at_once.x) == pytest.approx(np.linspace(14.0, 25.0, 31).tolist())
    c1 = constants["2dof"]["C1"]
    assert list(at_once.y) == pytest.approx([c1 * gap_functions(MOTOR, 1e-3 * gap)[0] for gap in at_once.x])
    for curve in (by_parabola, held):
        assert list(curve.x) == pytest.approx([15.0, 20.0])
        assert list(curve.y) == pytest.approx([14.0 * gap_functions(MOTOR, 1e-3 * gap)[0] for gap in (15, 20)])
    measured, predicted = charts["4.14"].panels[0].curves
    assert measured.y == pytest.approx(predicted.y, abs=1e-9)
    assert [panel.y_title for panel in charts[None].panels] == ["C1", "C2", "C3", "C4"]
    assert [len(panel.curves) for panel in charts[None].panels] == [3] * 4
    alone = {chart.number: chart for chart in outcome_of(stage).charts}
    assert set(alone) == {"4.13", None}
    assert len(alone["4.13"].panels[0].curves) == 1


def test_bands_are_twice_the_scatter_of_what_uncertain_constants_predict(stage: RunResult, staircase: Simulated,
                                                                        trial: Data) -> None:
    """With constants drawn by the covariance of the identification, thrust and equilibrium currents scatter so."""
    charts = {chart.number: chart for chart in outcome_of(stage, staircase("2dof")).charts}
    found = identify(trial.recording)
    c1, thrust = found.standard_error["C1"], charts["4.13"].panels[0].curves[0]
    assert thrust.margin == pytest.approx([2.0 * c1 * gap_functions(MOTOR, 1e-3 * gap)[0] for gap in thrust.x])
    measured, predicted = charts["4.14"].panels[0].curves
    assert measured.margin is None
    gaps = 1e-3 * np.array(predicted.x)
    rng = np.random.default_rng(1)
    names = ("C2", "C3", "C4")
    centre = [stage.ends[f"estimator_10ms.{name}"] for name in names]
    drawn = rng.multivariate_normal(centre, found.diagnostics["v"].covariance, 4000)
    scatter = np.std([equilibrium_currents(trial.recording.stage, gaps, dict(zip(names, each, strict=True)))
                      for each in drawn], axis=0)
    assert predicted.margin == pytest.approx((2.0 * scatter).tolist(), rel=0.06)


def test_what_is_not_identified_has_no_band(simulated: Simulated, trial: Data, staircase: Simulated) -> None:
    """An air gap that is held tells nothing about the vertical constants: the band has no end, and is not drawn."""
    columns = columns_of(trial)
    still = {**columns, "v.encoder": np.full_like(columns["v.encoder"], 0.02)}
    charts = {chart.number: chart for chart in outcome_of(
        simulated("2dof-identification-rig", trial.recording.time, still), staircase("2dof")).charts}
    predicted = charts["4.14"].panels[0].curves[1]
    assert predicted.margin is not None
    assert np.isinf(predicted.margin).all()
    assert set(curve_data(predicted)["margin"]) == {None}
