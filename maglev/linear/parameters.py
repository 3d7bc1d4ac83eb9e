"""The blocks that can be linearised, with the parameters that a user gives them."""

import re
from collections.abc import Mapping
from math import inf, isfinite
from operator import attrgetter
from typing import Any

from controller_fmu.pid_fmu import PID_2DOF, PID_3DOF
from controller_fmu.regulator_2dof_fmu import LINEAR_REGULATOR_2DOF, REGULATOR_2DOF
from controller_fmu.regulator_3dof_fmu import LINEAR_REGULATOR_3DOF, REGULATOR_3DOF, SCHEDULED_REGULATOR_3DOF
from maglev.errors import LinearModelError, QuantityError, nearest
from maglev.linear.rigs import RIGS, Rig
from maglev.units import UNITS, parse_quantity
from plant_fmu.plant_2dof import PLANT_2DOF
from plant_fmu.plant_3dof import PLANT_3DOF

PLANTS = {definition.name: definition for definition in (PLANT_2DOF, PLANT_3DOF)}
CONTROLLERS = {definition.name: definition for definition in (
    REGULATOR_2DOF, REGULATOR_3DOF, LINEAR_REGULATOR_2DOF, LINEAR_REGULATOR_3DOF, SCHEDULED_REGULATOR_3DOF,
    PID_2DOF, PID_3DOF)}
DEFINITIONS = {**PLANTS, **CONTROLLERS}

Quantity = float | str   # SI, or text with a unit such as "25 mm"


def rig_of(name: str) -> Rig:
    """Rig of a plant or controller.

    Raises
    ------
    LinearModelError
        If there is no linear model of an FMU of this name.
    """
    if name not in DEFINITIONS:
        raise LinearModelError(f"{name!r} cannot be linearised, expected one of {', '.join(DEFINITIONS)}; "
                               f"nearest is {nearest(name, DEFINITIONS)}")
    return RIGS[name[-4:]]


def block_of(name: str, parameters: Mapping[str, Quantity | bool]) -> Any:
    """New block of a plant or controller, with parameters by the names that the FMU has for them.

    Raises
    ------
    LinearModelError
        If the FMU has no such parameter or cannot take its value.
    """
    rig_of(name)
    definition = DEFINITIONS[name]
    known = {variable.name: variable for variable in definition.variables if variable.causality == "parameter"}
    block = definition.new_block()
    for key, given in parameters.items():
        if key not in known:
            raise LinearModelError(f"{name}: no parameter {key!r}; nearest is {nearest(key, known)}")
        variable = known[key]
        if variable.boolean:
            if not isinstance(given, bool):
                raise LinearModelError(f"{name}: {key} = {given!r}, expected true or false")
            value: float | bool = given
        else:
            low = -inf if variable.minimum is None else variable.minimum
            high = inf if variable.maximum is None else variable.maximum
            value = number(name, key, given, variable.unit)
            if not low <= value <= high:
                raise LinearModelError(f"{name}: {key} = {value!r} {variable.unit}, expected {low:g}…{high:g}")
        path, _, attribute = key.rpartition(".")
        setattr(attrgetter(path)(block) if path else block, attribute, value)
    return block


def number(name: str, key: str, given: Quantity, unit: str) -> float:
    """SI value of a quantity; where the unit is a composed one that no text can have, of a plain number."""
    try:
        if unit in UNITS or not unit:
            return parse_quantity(given, unit or "1")
        if isinstance(given, str) or not isfinite(given):
            raise QuantityError(f"{given!r}: expected a plain number, in {unit}")
        return float(given)
    except QuantityError as error:
        raise LinearModelError(f"{name}: {key}: {error}") from None


def prepare(name: str, block: Any) -> None:
    """Have a controller compute what follows from its fixed parameters.

    Raises
    ------
    LinearModelError
        With the text by which the FMU refuses them.
    """
    status = block.start()
    if status:
        text = re.sub(r"\{([\w.]+)\}", lambda match: repr(attrgetter(match[1])(block)),
                      DEFINITIONS[name].refusals[status])
        raise LinearModelError(f"{name}: {text}")
