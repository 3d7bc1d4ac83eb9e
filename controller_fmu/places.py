"""Attribute paths of the FMI variables in the block of a controller, by their names."""

from collections.abc import Iterable
from dataclasses import replace

from maglev.fmi.definition import Variable
from pmlsm.stage_description import ATTRACTION, COILS, IRON, StageDescription

# Places of constants in a `MotorModel`, by their units; the thrusts are a list.
CONSTANTS = {ATTRACTION: "attraction", COILS: "coils", IRON: "iron"}


def placed(stage: StageDescription, variables: Iterable[Variable], layout: str = "model.layout",
           allocation: str = "currents.allocation") -> tuple[Variable, ...]:
    """Variables with their paths in a block, in which a `MotorLayout` and a `ForceAllocation` have these paths."""
    return tuple(replace(v, path=place(stage, v.name, layout, allocation)) for v in variables)


def place(stage: StageDescription, name: str, layout: str = "model.layout",
          allocation: str = "currents.allocation") -> str:
    """Path of a variable."""
    owner, _, part = name.partition(".")
    if owner == "geometry":
        return f"{layout}.kinds[0].{name}"
    if name == "height":
        return f"platform.{name}"
    if owner in stage.motor_names:
        return of_motor(stage, owner, part, layout)
    if owner in stage.axis_names:
        return of_axis(stage, owner, part, allocation)
    return constant_place(stage, name) or name


def constant_place(stage: StageDescription, name: str) -> str:
    """Return the path of a constant of the model, or an empty text if there is no such constant."""
    for number, constant in enumerate(stage.constants):
        if constant.name == name:
            return f"model.{CONSTANTS.get(constant.unit, f'thrust[{number}]')}"
    return ""


def axis_number(stage: StageDescription, axis: str) -> int:
    """Number of an axis among the vertical one, the horizontal ones and the tilts, in that order."""
    return [each.name for each in (stage.vertical, *stage.horizontal, *stage.rotations)].index(axis)


def of_axis(stage: StageDescription, axis: str, part: str, allocation: str) -> str:
    """Return the path of a part of an axis, such as "reference"."""
    number = axis_number(stage, axis)
    if part in ("mass", "inertia"):
        names = ("mass_y", *("mass_x", "mass_z")[:len(stage.horizontal)], "inertia_roll", "inertia_pitch")
        return f"{allocation}.{names[number]}"
    return f"axes[{number}].{part}"


def of_motor(stage: StageDescription, motor: str, part: str, layout: str) -> str:
    """Return the path of a part of a motor, such as "i_a_cmd"."""
    number = stage.motor_names.index(motor)
    if part.startswith("geometry.") or part.endswith("_ratio"):
        kind = f"{layout}.kinds[{1 + [each.name for each in stage.unlike].index(motor)}]"
        return f"{kind}.{part}" if part.startswith("geometry.") else f"{kind}.ratio.{part.removesuffix('_ratio')}"
    if part in ("gap_measured", "x", "z"):
        return f"platform.places[{number}].{part}"
    return f"motors[{number}].{part}"
