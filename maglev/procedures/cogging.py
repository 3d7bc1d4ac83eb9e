"""Procedure 3: the peak cogging force, from an attraction estimated between the slots (sections 4.4.3, 5.4.3)."""

import numpy as np

from maglev.arrays import Array
from maglev.errors import ScenarioError
from maglev.identification.rigs import attraction_force, equilibrium_currents
from maglev.procedures.equilibrium import measured
from maglev.procedures.outcome import Chart, Curve, Outcome, Panel, ProcedureValue
from maglev.procedures.rig_data import EPSILON, Runs, constant_table, estimate, mm, rig_of
from maglev.schema.judged.procedure import ProcedureSettings

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
    rig = rig_of(offset.plan)
    constants = rig.rows[0].constants
    attraction = constants[0]
    at_zero, between = estimate(excitation, EPSILON, constants), estimate(offset, EPSILON, constants)
    low, high = settings.gaps
    gaps: Array = low + SPACING * np.arange(round((high - low) / SPACING) + 1.0)
    mass = offset.parameters.get(f"plant.{rig.axes[0]}.mass")
    if mass is None:
        raise ScenarioError(f"the plant has no parameter {rig.axes[0]}.mass, expected one for the force")
    force = attraction_force(rig, gaps, at_zero[attraction] - between[attraction], mass)
    values = [ProcedureValue("constant", between[attraction], constant=attraction, epsilon=EPSILON)]
    values += [ProcedureValue("cogging_force", value, gap=gap)
               for gap, value in zip(gaps.tolist(), force.tolist(), strict=True)]
    curves = [Curve("predicted, no offset", mm(gaps), equilibrium_currents(rig, gaps, at_zero).tolist()),
              Curve("predicted, between the slots", mm(gaps), equilibrium_currents(rig, gaps, between).tolist())]
    if currents is not None:
        seen = measured(currents, rig)
        curves.insert(0, Curve("measured, no offset", mm(seen.gaps), seen.currents.tolist(), marked=True))
    charts = (Chart(settings.figures.get("force"), "Estimate of the peak cogging force of one motor over the air gap.",
                    (Panel("air gap (mm)", "force (N)", (Curve("estimate", mm(gaps), force.tolist()),)),)),
              Chart(settings.figures.get("currents"),
                    "Equilibrium currents: measured, and predicted without an offset and between the slots.",
                    (Panel("air gap (mm)", "i_d (A)", tuple(curves)),)))
    return Outcome(settings, names, tuple(values), (constant_table(settings, offset, [attraction]),), charts)
