"""The FMUs of stage and controller in one: variables and refusals are those of both parts."""

import re
from dataclasses import replace

from controller_fmu.adaptive_regulator import AdaptiveRegulator
from controller_fmu.status import STEP_MISFIT
from maglev.closed_loop.closed_loop import COMMAND_TOO_LARGE, OF_PLANT, AdaptiveLoop, ClosedLoop
from maglev.fmi.definition import SAMPLE_TIME, DefaultExperiment, Drawing, FmuDefinition, Variable
from pmlsm.stage_description import StageDescription

# Whole samples, whichever the stage, and at most 1000: fmpy doubles a shorter step until there are no more.
EXPERIMENT = DefaultExperiment(stop_time=26.0, step=40.0e-3)

DRAWINGS = "maglev.closed_loop.drawings"

MEANING = "sample time; the communication step must be a whole multiple of it"

REFUSED_STEP = ("communication step = {step} s, expected a whole multiple of controller.sample_time = "
                "{controller.sample_time} s, at most 1000 s")


def closed_loop(stage: StageDescription, controller: FmuDefinition, plant: FmuDefinition) -> FmuDefinition:
    """Definition of a loop of a stage, from those of its parts; its icon has the controller's law."""
    word = controller.name.removesuffix(stage.suffix).removesuffix("Regulator")
    return FmuDefinition(
        name=f"ClosedLoop{word}{stage.suffix}",
        block=AdaptiveLoop if controller.block is AdaptiveRegulator else ClosedLoop,
        arguments=(controller.block, controller.arguments, plant.block, plant.arguments),
        description=f"Closed loop of {controller.name} and {plant.name}, stepped in sequence, controller first",
        variables=loop_variables(controller, plant),
        refusals=loop_refusals(controller, plant),
        experiment=EXPERIMENT,
        documentation=tuple(dict.fromkeys((("maglev.closed_loop", "closed_loop.html"), *controller.documentation,
                                           *plant.documentation))),
        icon=Drawing(DRAWINGS, "icon", () if controller.icon is None else controller.icon.arguments),
        sketch=Drawing(DRAWINGS, "loop", (controller.name, plant.name)))


def loop_variables(controller: FmuDefinition, plant: FmuDefinition) -> tuple[Variable, ...]:
    """Inputs that the loop leaves open, then outputs and parameters of both parts, the controller's first.

    The loop connects the readings of the encoders, and the commands, which have the same name in both parts.
    """
    commands = connected_commands(controller, plant)
    references = [v for v in controller.variables if v.causality == "input" and not v.name.endswith("measured")]
    forces = [v for v in plant.variables if v.causality == "input" and v.name not in commands]
    # References are read at samples, and so held between two rows of an importer's input file.
    inputs = (*(replace(v, path=f"controller.{v.place}", variability="discrete") for v in references),
              *(replace(v, path=f"plant.{v.place}") for v in forces))
    # A measurement depends on no input at its sample: a state lies between.
    return (*inputs, *(part_variable(part, v, {open_input.name for open_input in inputs})
                       for causality in ("output", "parameter")
                       for part, fmu in (("controller", controller), ("plant", plant))
                       for v in fmu.variables if v.causality == causality))


def connected_commands(controller: FmuDefinition, plant: FmuDefinition) -> list[str]:
    """Names of the outputs of the controller that are inputs of the plant."""
    outputs = {v.name for v in controller.variables if v.causality == "output"}
    return [v.name for v in plant.variables if v.causality == "input" and v.name in outputs]


def part_variable(part: str, variable: Variable, inputs: set[str]) -> Variable:
    """Output or parameter of a part as one of the loop, which has the named inputs."""
    return replace(variable, name=f"{part}.{variable.name}", path=f"{part}.{variable.path}" if variable.path else "",
                   description=MEANING if variable.name == SAMPLE_TIME else variable.description,
                   depends_on=tuple(name for name in variable.depends_on if name in inputs),
                   starts_from=tuple(f"{part}.{name}" for name in variable.starts_from))


def loop_refusals(controller: FmuDefinition, plant: FmuDefinition) -> dict[int, str]:
    """Texts of the errors of either part, about the loop's variables."""
    commands = ", ".join(f"controller.{name} = {{controller.{name}}} A"
                         for name in connected_commands(controller, plant))
    return {**{status: of_part("controller", text) for status, text in controller.refusals.items()},
            **{OF_PLANT + status: of_part("plant", text) for status, text in plant.refusals.items()},
            STEP_MISFIT: REFUSED_STEP,
            COMMAND_TOO_LARGE: f"{commands}, expected all within 1000 A"}


def of_part(part: str, text: str) -> str:
    """Refusal of a part, whose variables stand there as `name = {name}`, with their names in the loop."""
    return re.sub(r"\b(?!step )([\w.]+) = \{\1\}", rf"{part}.\1 = {{{part}.\1}}", text)
