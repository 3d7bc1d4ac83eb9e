"""Procedure 4: all constants at once, and the model with them next to the stage (sections 4.4.4, 5.4.4)."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from maglev.files.arrays import Array
from maglev.identification.estimators import run_estimator as estimate_offline
from maglev.identification.identify import Identification, identify, observed
from maglev.identification.recording import MotionRecording
from maglev.identification.regressors import EstimatedStage, equilibrium_currents, regressors, row_of, thrust_shape
from maglev.identification.settings import EPSILON, METHODS
from maglev.runs.equilibrium_currents import beside_each_other, find_equilibria
from maglev.runs.execution import RunResult
from maglev.runs.parabolas import Thrust, all_thrusts, over_gap
from maglev.runs.procedure_data import Runs, column, constants_of, estimate, estimators, positions_of, stage_of
from maglev.runs.procedure_outcome import Chart, Curve, Outcome, Panel, ProcedureValue, ValueTable
from maglev.scenario.procedure import ProcedureSettings

POINTS = 31            # of a predicted curve over the air gap
CONVERGENCE = 400      # points of an estimate over time, at most
ERRORS = 2.0           # standard errors to both sides of a curve
DIFFERENCE = 1e-4      # share of a constant, for the slopes of the prediction
BAND = f"The band is {ERRORS:g} standard errors wide to both sides; it does not contain the effect of friction."


def evaluate(settings: ProcedureSettings, runs: Runs) -> Outcome:
    """Outcome of Procedure 4 on the completed runs `stage` and `model`; for the figures `currents`, `parabolas`."""
    stage_run, model = runs.get(settings.runs["stage"]), runs.get(settings.runs["model"])
    if stage_run is None:
        return Outcome(settings, ())
    stage = stage_of(stage_run.plan)
    values, table = constants_of(settings, stage_run, stage.constants)
    if model is not None:
        for axis in (row.axis for row in stage.rows):   # tilts are held, or small
            values += [ProcedureValue(f"{name}_deviation", rms_deviation(stage_run, model, f"{axis}.{signal}"),
                                      axis=axis)
                       for name, signal in (("position", "position"), ("speed", "velocity"))]
    held = [thrust for thrust in all_thrusts(settings.runs["parabolas"], runs) if thrust.alone]
    values += [ProcedureValue("thrust", thrust.by_parabola, axis=thrust.axis, gap=thrust.gap) for thrust in held]
    i_d, i_q = (np.stack([column(stage_run, f"plant.{motor}.{current}") for motor in stage.motors], axis=1)
                for current in ("i_d", "i_q"))
    identified = identify(MotionRecording(stage, stage_run.time, positions_of(stage_run, stage), i_d, i_q))
    charts = [thrust_chart(settings, stage_run, held, identified),
              *current_charts(settings, stage_run, runs, identified),
              convergence_chart(stage_run, stage)]
    return Outcome(settings, tuple(run.plan.name for run in (stage_run, model) if run is not None), tuple(values),
                   (table, offline_table(identified)), tuple(charts),
                   tuple(identified.warnings))


def rms_deviation(stage_run: RunResult, model: RunResult, name: str) -> float:
    """RMS of model − stage over the RMS of the stage's motion about its mean, for as long as both ran."""
    rows = min(len(model.time), len(stage_run.time))
    there, here = column(model, f"plant.{name}")[:rows], column(stage_run, f"plant.{name}")[:rows]
    motion = float(here.std())
    return float(np.sqrt(np.mean((there - here) ** 2))) / motion if motion > 0.0 else math.inf


def offline_table(model: Identification) -> ValueTable:
    """Return the constants by the three estimators of chapter 3 on the recorded rows, with their uncertainties."""
    recording, stage = model.recording, model.recording.stage
    rows = regressors(stage, recording.positions, recording.i_d, recording.i_q,
                      observed(recording.positions, recording.dt))
    by_method = {method: estimate_offline(method, rows, recording.time, model.guess, EPSILON).final
                 for method in METHODS}
    header = ("constant", *METHODS, "standard error", "with friction terms")
    return ValueTable(
        f"The same by the estimators offline, ε = {EPSILON:g}", header,
        tuple((name, *(f"{by_method[method][name]:.5g}" for method in METHODS), f"{model.standard_error[name]:.2g}",
               f"{model.with_friction[name]:.5g}") for name in stage.constants))


def thrust_chart(settings: ProcedureSettings, stage_run: RunResult, thrusts: Sequence[Thrust],
                 model: Identification) -> Chart:
    """Thrust over the air gap, next to that of Procedure 1 where its runs are there."""
    gaps = np.linspace(*(settings.gaps or (0.015, 0.025)), POINTS)   # m
    stage = model.recording.stage
    constants = estimate(stage_run, stage.constants)
    panels = []
    for axis in (axis.name for axis in stage.described.horizontal):
        constant = row_of(stage, axis).constants[0]
        margin = ERRORS * model.standard_error[constant] * thrust_shape(stage, gaps)
        curves = [Curve("all constants at once", 1e3 * gaps, constants[constant] * thrust_shape(stage, gaps),
                        margin=margin)]
        held = [thrust for thrust in thrusts if thrust.axis == axis]
        if held:
            curves += [Curve("parabolas", *over_gap(held, [thrust.by_parabola for thrust in held]), marked=True),
                       Curve(f"held air gaps, ε = {EPSILON:g}",
                             *over_gap(held, [thrust.estimated for thrust in held]))]
        panels.append(Panel("air gap (mm)", f"L of {axis} (m/(s²·A))", tuple(curves)))
    return Chart(settings.figures.get("thrust"),
                 f"Thrust over the air gap, by all constants at once and at held air gaps. {BAND}", tuple(panels))


def current_charts(settings: ProcedureSettings, stage_run: RunResult, runs: Runs, model: Identification) -> list[Chart]:
    """Predicted equilibrium currents next to those of Procedure 2, if its run is there."""
    stage = model.recording.stage
    currents = runs.get(settings.runs["currents"])
    if currents is None:
        return []
    seen = find_equilibria(currents, stage)
    constants = estimate(stage_run, stage.rows[0].constants)
    theory = equilibrium_currents(stage, seen.gaps, constants)
    margin = ERRORS * current_errors(model, seen.gaps, constants)
    return [Chart(settings.figures.get("currents"),
                  f"Equilibrium currents: measured, and predicted by all constants at once. {BAND}",
                  (beside_each_other(seen, theory, margin),))]


def current_errors(model: Identification, gaps: Array, constants: Mapping[str, float]) -> Array:
    """Standard errors (A), shape (n,), of the equilibrium currents that constants predict at air gaps (m).

    Linearised. The constants of the vertical row are strongly correlated: the currents are known much better than
    each of them.
    """
    stage = model.recording.stage
    names = stage.rows[0].constants
    slopes = np.empty((len(gaps), len(names)))
    for k, name in enumerate(names):
        step = DIFFERENCE * (abs(constants[name]) or 1.0)
        more, less = ({**constants, name: constants[name] + sign * step} for sign in (1.0, -1.0))
        slopes[:,
               k] = (equilibrium_currents(stage, gaps, more) - equilibrium_currents(stage, gaps, less)) / (2.0 * step)
    covariance = model.diagnostics[stage.axes[0]].covariance
    if not np.isfinite(covariance).all():
        return np.full(len(gaps), np.inf)
    return np.asarray(np.sqrt(np.maximum(np.einsum("nj,jk,nk->n", slopes, covariance, slopes), 0.0)))


def convergence_chart(stage_run: RunResult, stage: EstimatedStage) -> Chart:
    rows = np.unique(np.linspace(0, len(stage_run.time) - 1, CONVERGENCE).astype(int))
    panels = tuple(Panel("time (s)", constant, tuple(
        Curve(f"ε = {epsilon:g}", stage_run.time[rows], column(stage_run, f"{name}.{constant}")[rows])
        for epsilon, name in estimators(stage_run).items())) for constant in stage.constants)
    return Chart(None, f"{stage_run.plan.title}: the estimates over time, from half of the values of the thesis.",
                 panels)
