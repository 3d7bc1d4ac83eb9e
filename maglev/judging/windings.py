"""Resistances of the windings of a run, by which currents are losses."""

from collections.abc import Mapping
from typing import Any

from maglev.schema.run_plan import Motor, RunPlan


def winding_of(motor: Motor) -> str:
    """What the plant calls the winding of a motor, such as "plant.alpha.winding", by its currents."""
    return f"{motor.currents[0].rpartition('.')[0]}.winding" if motor.currents else ""


def phase_resistances(plan: RunPlan, settings: Mapping[str, Any] | None = None) -> dict[str, float]:
    """Resistance of a phase (ohm, cold) of each motor of which it is known.

    By what a sample of a study sets, `fmu.variable`, or else by the scenario's start values, or by the description of
    the stage; a plant that was put in and has no such parameter is taken for that stage.
    """
    described = {motor.name: motor.winding.resistance for motor in plan.rig.motors} if plan.rig is not None else {}
    found = {}
    for name, motor in plan.motors.items():
        full = f"{winding_of(motor)}.resistance"
        fmu, _, variable = full.partition(".")
        start = plan.fmus[fmu].start.get(variable) if fmu in plan.fmus else None
        value = (settings or {}).get(full, start.value if start is not None else described.get(name))
        if motor.currents and value is not None:
            found[name] = float(value)
    return found
