"""Limits that a run has: where the end stops of its axes are, and how much current its motors may carry."""

from collections.abc import Mapping
from typing import NamedTuple

from maglev.schema.run_plan import RunPlan


class Limit(NamedTuple):
    """Levels (SI) that a panel marks: its kind, the axis or motor it shows, what they are in words, and where."""

    kind: str
    of: str
    text: str
    values: list[float]


def limits(plan: RunPlan, parameters: Mapping[str, float]) -> list[Limit]:
    """Limits by the parameters (SI) that a run started with; of FMUs with other names none."""
    found = []
    for name, axis in plan.axes.items():
        stop = axis.position.rpartition(".")[0] + ".stop."
        if stop + "lower" in parameters and stop + "upper" in parameters:
            found.append(Limit("position", name, "end stops", [parameters[stop + end] for end in ("lower", "upper")]))
    for name, motor in plan.motors.items():
        peak = parameters.get(motor.currents[0].rpartition(".")[0] + ".amplifier.peak") if motor.currents else None
        limit = parameters.get(motor.commands[0].partition(".")[0] + ".current_limit") if motor.commands else None
        if peak:
            found.append(Limit("currents", name, f"peak of the amplifiers, {peak:g} A", [-peak, peak]))
        if limit:   # 0 is none
            found.append(Limit("commands", name, f"limit of the commands, {limit:g} A", [-limit, limit]))
    return found
