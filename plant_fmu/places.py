"""Where the FMI variables of a plant lie in its block: attribute paths, by the names of the variables."""

from collections.abc import Iterable
from dataclasses import replace

from maglev.fmi.definition import Variable
from pmlsm.stage_description import ATTRACTION, COILS, IRON, Rig

CONSTANTS = {ATTRACTION: "attraction", COILS: "coils", IRON: "iron"}   # of the gap, by their units; thrusts are a list
MAGNETICS = {"attraction_modulation": "modulation", "magnet_rise": "magnet_rise"}
OF_MOVER = ("height", "payload", "yaw_moment")
OF_MOUNT = ("x", "z", "gap", "gap_encoder", "stop", "normal", "thrust")


def placed(rig: Rig, variables: Iterable[Variable]) -> tuple[Variable, ...]:
    """Return variables of a plant with their paths in a `Stage`."""
    paths = ((variable, place(rig, variable.name)) for variable in variables)
    return tuple(replace(variable, path="" if path == variable.name else path) for variable, path in paths)


def place(rig: Rig, name: str) -> str:
    """Return the path of what has a name, such as a variable."""
    rated = name.startswith("der(")
    name = name[4:-1] if rated else name
    owner, _, part = name.partition(".")
    if owner == "geometry":
        path = f"magnetics.kinds[0].{name}"
    elif constant := constant_place(rig, name):
        path = constant
    elif name in MAGNETICS:
        path = f"magnetics.{MAGNETICS[name]}"
    elif owner in OF_MOVER:
        path = f"mover.{name}"
    elif owner in rig.motor_names:
        path = of_motor(rig, owner, part, rated)
    elif owner in rig.axis_names:
        path = of_axis(rig, owner, part, rated)
    else:
        path = name
    return path


def constant_place(rig: Rig, name: str) -> str:
    """Return the path of a constant of the velocity rows; empty if it is none."""
    for number, constant in enumerate(rig.constants):
        if constant.name == name:
            return f"magnetics.{CONSTANTS.get(constant.unit, f'thrust[{number}]')}"
    return ""


def of_axis(rig: Rig, axis: str, part: str, rated: bool) -> str:
    """Return the path of what an axis has; of the rate of a state the sum of its weighted slopes."""
    tilts = [tilt.name for tilt in rig.rotations]
    first, _, rest = part.partition(".")
    if first == "guide":
        return f"mover.guides[{tilts.index(axis)}].{rest}"
    part = {"torque": "force", "inertia": "mass", "friction.deflection": "deflection"}.get(part, part)
    return f"axes[{rig.axis_number(axis)}].{part}{'_sum' if rated else ''}"


def of_motor(rig: Rig, motor: str, part: str, rated: bool) -> str:
    """Return the path of what a motor has."""
    number = rig.motor_names.index(motor)
    first, _, rest = part.partition(".")
    if first == "geometry" or first.endswith("_ratio"):
        kind = 1 + [each.name for each in rig.unlike].index(motor)
        return f"magnetics.kinds[{kind}].{part if first == 'geometry' else 'ratio.' + first.removesuffix('_ratio')}"
    if first in OF_MOUNT:
        return f"mover.mounts[{number}].{part}"
    if first.startswith("phase_"):
        part = f"phases[{'abc'.index(first[-1])}].{rest}"
    elif rated and first.startswith("i_"):
        part = f"phases[{'abc'.index(first[-1])}].current"
    return f"motors[{number}].{part}{'_rate' if rated else ''}"
