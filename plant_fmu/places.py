"""Attribute paths of the FMI variables in the block of a plant, by the names of the variables."""

from collections.abc import Iterable
from dataclasses import replace

from maglev.fmi.definition import Variable
from pmlsm.stage_description import ATTRACTION, COILS, IRON, StageDescription

CONSTANTS = {ATTRACTION: "attraction", COILS: "coils", IRON: "iron"}   # of the gap, by their units; thrusts are a list
MAGNETICS = {"attraction_modulation": "modulation", "magnet_rise": "magnet_rise"}
OF_MOVER = ("height", "payload", "yaw_moment")
OF_MOUNT = ("x", "z", "gap", "gap_encoder", "stop", "normal", "thrust")


def placed(stage: StageDescription, variables: Iterable[Variable]) -> tuple[Variable, ...]:
    """Return variables of a plant with their paths in a `Stage`."""
    paths = ((variable, place(stage, variable.name)) for variable in variables)
    return tuple(replace(variable, path="" if path == variable.name else path) for variable, path in paths)


def place(stage: StageDescription, name: str) -> str:
    """Return the path of a named object, such as a variable."""
    rated = name.startswith("der(")
    name = name[4:-1] if rated else name
    owner, _, part = name.partition(".")
    if owner == "geometry":
        path = f"magnetics.kinds[0].{name}"
    elif constant := constant_place(stage, name):
        path = constant
    elif name in MAGNETICS:
        path = f"magnetics.{MAGNETICS[name]}"
    elif owner in OF_MOVER:
        path = f"mover.{name}"
    elif owner in stage.motor_names:
        path = of_motor(stage, owner, part, rated)
    elif owner in stage.axis_names:
        path = of_axis(stage, owner, part, rated)
    else:
        path = name
    return path


def constant_place(stage: StageDescription, name: str) -> str:
    """Return the path of a constant of the velocity rows; empty for any other name."""
    for number, constant in enumerate(stage.constants):
        if constant.name == name:
            return f"magnetics.{CONSTANTS.get(constant.unit, f'thrust[{number}]')}"
    return ""


def of_axis(stage: StageDescription, axis: str, part: str, rated: bool) -> str:
    """Return the path of a part of an axis; for the rate of a state, the sum of its weighted slopes."""
    tilts = [tilt.name for tilt in stage.rotations]
    first, _, rest = part.partition(".")
    if first == "guide":
        return f"mover.guides[{tilts.index(axis)}].{rest}"
    part = {"torque": "force", "inertia": "mass", "friction.deflection": "deflection"}.get(part, part)
    return f"axes[{stage.axis_number(axis)}].{part}{'_sum' if rated else ''}"


def of_motor(stage: StageDescription, motor: str, part: str, rated: bool) -> str:
    """Return the path of a part of a motor."""
    number = stage.motor_names.index(motor)
    first, _, rest = part.partition(".")
    if first == "geometry" or first.endswith("_ratio"):
        kind = 1 + [each.name for each in stage.unlike].index(motor)
        return f"magnetics.kinds[{kind}].{part if first == 'geometry' else 'ratio.' + first.removesuffix('_ratio')}"
    if first in OF_MOUNT:
        return f"mover.mounts[{number}].{part}"
    if first.startswith("phase_"):
        part = f"phases[{'abc'.index(first[-1])}].{rest}"
    elif rated and first.startswith("i_"):
        part = f"phases[{'abc'.index(first[-1])}].current"
    return f"motors[{number}].{part}{'_rate' if rated else ''}"
