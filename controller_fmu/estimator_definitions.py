"""The FMUs of a stage that estimate: the estimator, and the regulator that takes over what it finds."""

from controller_fmu.adaptive_regulator import AdaptiveRegulator
from controller_fmu.adaptive_variables import adaptive_variables
from controller_fmu.drawings import DIAGRAMS, ICONS
from controller_fmu.estimator import Estimator
from controller_fmu.estimator_variables import estimator_variables, refusals
from maglev.fmi.definition import DefaultExperiment, Drawing, FmuDefinition
from pmlsm.stage_description import StageDescription

FOLDER = "controller_fmu"


def estimator(stage: StageDescription) -> FmuDefinition:
    """Definition of the estimator of a stage."""
    rows = f"rows_{'tilts' if stage.rotations else stage.name}.html"
    return FmuDefinition(
        name=f"Estimator{stage.suffix}",
        block=Estimator,
        arguments=(stage,),
        description=f"Online estimator of the constants of the {stage.title}",
        variables=estimator_variables(stage),
        refusals=refusals(stage),
        experiment=DefaultExperiment(stop_time=500 * stage.sample_time, step=stage.sample_time),
        sampled=True,
        documentation=((FOLDER, "estimator.html"), (FOLDER, rows),
                       (FOLDER, "matched_filter.html"), ("pmlsm", "motor.html")),
        icon=Drawing("controller_fmu.estimator_drawings", "icon", (len(stage.axes),)),
        sketch=Drawing("controller_fmu.estimator_drawings", "block_diagram"))


def adaptive_regulator(stage: StageDescription, regulator: FmuDefinition, estimator: FmuDefinition) -> FmuDefinition:
    """Definition of the adaptive regulator of a stage, from those of its parts."""
    return FmuDefinition(
        name=f"AdaptiveRegulator{stage.suffix}",
        block=AdaptiveRegulator,
        arguments=(stage,),
        description=f"Adaptive regulator of the {stage.title}: output regulation on the feedback-linearised motors, "
                    f"with "
                    "constants that are estimated during the run",
        variables=adaptive_variables(stage, regulator, estimator),
        refusals=regulator.refusals,
        experiment=regulator.experiment,
        sampled=True,
        documentation=tuple(dict.fromkeys(((FOLDER, "adaptation.html"), *estimator.documentation,
                                           *regulator.documentation))),
        icon=Drawing(ICONS, "controller", ("adaptive", len(stage.axes))),
        sketch=Drawing(DIAGRAMS, "regulator", ("nonlinear",)))
