"""Procedures 2 and 3: equilibrium currents and the peak cogging force (sections 4.4.2, 4.4.3, 5.4.2, 5.4.3)."""

from typing import NamedTuple

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError
from maglev.identification.regressors import EstimatedStage, attraction_force, equilibrium_currents
from maglev.identification.settings import EPSILON
from maglev.runs.execution import RunResult
from maglev.runs.measuring import step_samples
from maglev.runs.procedure_data import Runs, column, constants_of, entry, estimate, position_of, stage_of
from maglev.runs.procedure_outcome import Chart, Curve, Outcome, Panel, ProcedureValue
from maglev.scenario.procedure import ProcedureSettings

SETTLED = 1.0 / 3.0   # of the time at an air gap, at its end
SPACING = 0.5e-3      # m, of the air gaps at which the cogging force is given


class Measured(NamedTuple):
    """Equilibria, shape (n,): air gaps asked for, their measured means (m), and mean direct currents (A)."""

    asked: Array
    gaps: Array
    currents: Array


def find_equilibria(result: RunResult, stage: EstimatedStage) -> Measured:
    """Equilibria of a run that holds one air gap after the other, ascending."""
    axis = stage.axes[0]
    reference = column(result, entry(result.plan.axes, axis, result).reference)
    position = position_of(result, stage, axis)
    current = np.mean([column(result, f"plant.{motor}.i_d") for motor in stage.motors], axis=0)
    starts = [0, *step_samples(reference)]
    ends = [*starts[1:], len(reference)]
    windows = [slice(end - max(1, round(SETTLED * (end - start))), end)
               for start, end in zip(starts, ends, strict=True)]
    rows = sorted((float(reference[window][0]), float(position[window].mean()), float(current[window].mean()))
                  for window in windows)
    return Measured(*np.array(rows).T)


def beside_each_other(seen: Measured, theory: Array, margin: Array | None = None) -> Panel:
    """Measured equilibrium currents, and those predicted (A), shape (n,), at the same air gaps, perhaps with a band."""
    return Panel("air gap (mm)", "i_d (A)", (Curve("measured", 1e3 * seen.gaps, seen.currents, marked=True),
                                             Curve("predicted", 1e3 * seen.gaps, theory, margin=margin)))


def evaluate_currents(settings: ProcedureSettings, runs: Runs) -> Outcome:
    """Outcome of Procedure 2 on the runs that completed: `currents` and `excitation`."""
    currents, excitation = (runs.get(settings.runs[part]) for part in ("currents", "excitation"))
    names = tuple(run.plan.name for run in (currents, excitation) if run is not None)
    if excitation is None:
        return Outcome(settings, names)
    stage = stage_of(excitation.plan)
    constants = stage.rows[0].constants
    values, table = constants_of(settings, excitation, constants)
    if currents is None:
        return Outcome(settings, names, tuple(values), (table,))
    seen = find_equilibria(currents, stage)
    theory = equilibrium_currents(stage, seen.gaps, estimate(excitation, constants))
    values += [ProcedureValue("equilibrium_current", here, gap=asked) for asked, here
               in zip(seen.asked.tolist(), seen.currents.tolist(), strict=True)]
    values += [ProcedureValue("equilibrium_deviation", abs(there - here), gap=asked) for asked, here, there
               in zip(seen.asked.tolist(), seen.currents.tolist(), theory.tolist(), strict=True)]
    chart = Chart(settings.figures.get("currents"),
                  f"Equilibrium currents: measured, and predicted by the constants with ε = {EPSILON:g}.",
                  (beside_each_other(seen, theory),))
    return Outcome(settings, names, tuple(values), (table,), (chart,))


def evaluate_cogging(settings: ProcedureSettings, runs: Runs) -> Outcome:
    """Outcome of Procedure 3 on the runs that completed: `offset`, and of Procedure 2 `excitation` and `currents`.

    The force follows from an attraction that is estimated between the slots.

    ξ(g) = M (C − Ĉ) f2(g), C of the attraction at zero displacement and Ĉ between the slots. Of the four motors of the
    3-DOF stage that is the force of one, as in the thesis's figure; on the mover acts four times as much.
    """
    offset, excitation, currents = (runs.get(settings.runs[part]) for part in ("offset", "excitation", "currents"))
    names = tuple(run.plan.name for run in (offset, excitation, currents) if run is not None)
    if offset is None or excitation is None or settings.gaps is None:
        return Outcome(settings, names)
    stage = stage_of(offset.plan)
    constants = stage.rows[0].constants
    attraction = constants[0]
    at_zero, between = (estimate(run, constants) for run in (excitation, offset))
    low, high = settings.gaps
    gaps: Array = low + SPACING * np.arange(round((high - low) / SPACING) + 1.0)
    mass = offset.parameters.get(f"plant.{stage.axes[0]}.mass")
    if mass is None:
        raise ScenarioError(f"the plant has no parameter {stage.axes[0]}.mass, expected one for the force")
    force = attraction_force(stage, gaps, at_zero[attraction] - between[attraction], mass)
    values = [ProcedureValue("constant", between[attraction], constant=attraction, epsilon=EPSILON)]
    values += [ProcedureValue("cogging_force", value, gap=gap)
               for gap, value in zip(gaps.tolist(), force.tolist(), strict=True)]
    curves = [Curve("predicted, no offset", 1e3 * gaps, equilibrium_currents(stage, gaps, at_zero)),
              Curve("predicted, between the slots", 1e3 * gaps, equilibrium_currents(stage, gaps, between))]
    if currents is not None:
        seen = find_equilibria(currents, stage)
        curves.insert(0, Curve("measured, no offset", 1e3 * seen.gaps, seen.currents, marked=True))
    charts = (Chart(settings.figures.get("force"), "Estimate of the peak cogging force of one motor over the air gap.",
                    (Panel("air gap (mm)", "force (N)", (Curve("estimate", 1e3 * gaps, force),)),)),
              Chart(settings.figures.get("currents"),
                    "Equilibrium currents: measured, and predicted without an offset and between the slots.",
                    (Panel("air gap (mm)", "i_d (A)", tuple(curves)),)))
    return Outcome(settings, names, tuple(values), (constants_of(settings, offset, [attraction])[1],), charts)
