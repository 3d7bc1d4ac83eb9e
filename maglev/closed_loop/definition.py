"""The FMUs of stage and controller in one."""

from controller_fmu.adaptive_regulator import AdaptiveRegulator
from maglev.closed_loop.closed_loop import AdaptiveLoop, ClosedLoop
from maglev.closed_loop.variables import loop_refusals, loop_variables
from maglev.fmi.definition import DefaultExperiment, Drawing, FmuDefinition
from pmlsm.stage_description import StageDescription

# Whole samples, whichever the stage, and at most 1000: fmpy doubles a shorter step until there are no more.
EXPERIMENT = DefaultExperiment(stop_time=26.0, step=40.0e-3)

DRAWINGS = "maglev.closed_loop.drawings"


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
