"""The blocks that can be linearised, with the parameters that a user gives them."""

import re
from collections.abc import Mapping
from typing import Any

from maglev.descriptions.registry import definitions, known_stages
from maglev.files.errors import LinearModelError, MaglevError, one_of, option, or_of_own_stage, require_table
from maglev.fmi.definition import read
from maglev.fmi.parameter import Parameter, require_parameter
from pmlsm.stage_description import StageDescription

# FMUs of each stage that can be linearised: its plant, its output regulators, the nonlinear one first, its PID, and the
# adaptive regulator.
KINDS = ("Plant", "Regulator", "LinearRegulator", "ScheduledRegulator", "InterpolatedRegulator", "PID",
         "AdaptiveRegulator")

Quantity = float | str   # SI, or text with a unit such as "25 mm"


def linear_names(stage: StageDescription) -> list[str]:
    """Names that can be linearised of a stage: its plant, then its controllers."""
    made = definitions(stage)
    return [name for name in (f"{kind}{stage.suffix}" for kind in KINDS) if name in made]


def plants() -> dict[str, StageDescription]:
    return {linear_names(stage)[0]: stage for stage in known_stages().stages.values()}


def controllers() -> dict[str, StageDescription]:
    return {name: stage for stage in known_stages().stages.values() for name in linear_names(stage)[1:]}


def measurements() -> dict[str, StageDescription]:
    return {f"Measurement{stage.suffix}": stage for stage in known_stages().stages.values()}


def linear_stage(name: str) -> StageDescription:
    """Stage of an FMU that can be linearised; LinearModelError if there is no linear model of this name."""
    known = plants() | controllers() | measurements()
    if name not in known:
        raise LinearModelError(f"{name!r} cannot be linearised, expected "
                               f"{one_of(name, known, or_of_own_stage())}")
    return known[name]


def regulator_in(name: str) -> str:
    """Name of the regulator in one that adapts; of anything else, its own."""
    return name.removeprefix("Adaptive")


def block_of(name: str, parameters: Mapping[str, Quantity | bool]) -> Any:
    """New block for a linear model, with parameters by the names that the FMU has for them.

    Of a regulator that adapts it is its law, with the constants that it begins with: no constant moves at rest.
    LinearModelError if the FMU has no such parameter or cannot take its value.
    """
    linear_stage(name)
    definition = known_stages().definition(name)
    known = {variable.name: variable for variable in definition.variables if variable.causality == "parameter"}
    block = definition.new_block()
    require_table(parameters, f"{name}: parameters", LinearModelError, "{'y.mass': '7.2 kg'}")
    for key, given in parameters.items():
        require_parameter(key, known, name, LinearModelError)
        value = Parameter.of(known[key]).read(given, f"{name}: {key}", LinearModelError)
        known[key].write(block, value)
    if regulator_in(name) != name:
        prepare_fixed(name, block)
        block = block.regulator
    # Effects of a motor with another geometry; `prepare` raises an error for an impossible geometry.
    if name in plants():
        block.magnetics.prepare()
    elif name in controllers():
        block.model.layout.prepare()
    return block


def by_part(settings: Mapping[str, Quantity | bool], error: type[MaglevError], *further: str
            ) -> dict[str, dict[str, Quantity | bool]]:
    """Parameters of "plant", "controller" and further parts by their names there, from such as "plant.y.mass"."""
    require_table(settings, "set", error, "{'plant.y.mass': '7.2 kg'}")
    parts: dict[str, dict[str, Quantity | bool]] = {part: {} for part in ("plant", "controller", *further)}
    for name, value in settings.items():
        part, dot, variable = name.partition(".")
        if part not in parts or not dot:
            raise error(f"{option('set', {name: value})}: expected {' or '.join(f'{part}.…' for part in parts)}, such "
                        "as plant.y.mass=7.2kg")
        parts[part][variable] = value
    return parts


def prepare_fixed(name: str, block: Any) -> None:
    """Have a controller compute the values that follow from its fixed parameters.

    LinearModelError with the text of the FMU's status if it does not accept them.
    """
    status = block.start()
    if status:
        definition = known_stages().definition(name)
        places = {variable.name: variable.place for variable in definition.variables}
        text = re.sub(r"\{([\w.]+)\}", lambda match: repr(read(block, places[match[1]])),
                      definition.refusals[status])
        raise LinearModelError(f"{name}: {text}")
