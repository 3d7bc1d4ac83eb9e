"""Procedure 3: the peak cogging force, from an attraction estimated between the slots (sections 4.4.3, 5.4.3)."""

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError
from maglev.identification.regressors import attraction_force, equilibrium_currents
from maglev.identification.settings import EPSILON
from maglev.runs.equilibrium_currents import find_equilibria
from maglev.runs.procedure_data import Runs, constants_of, estimate, stage_of
from maglev.runs.procedure_outcome import Chart, Curve, Outcome, Panel, ProcedureValue
from maglev.scenario.procedure import ProcedureSettings

SPACING = 0.5e-3   # m, of the air gaps at which the force is given


def evaluate(settings: ProcedureSettings, runs: Runs) -> Outcome:
    """Outcome of Procedure 3 on the runs that completed: `offset`, and of Procedure 2 `excitation` and `currents`.

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
