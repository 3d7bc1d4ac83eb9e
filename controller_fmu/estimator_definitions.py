"""The FMUs of a rig that estimate: the estimator, and the regulator that takes over what it finds."""

from controller_fmu.adaptive_regulator import AdaptiveRegulator
from controller_fmu.adaptive_variables import adaptive_variables
from controller_fmu.drawings import DIAGRAMS, ICONS
from controller_fmu.estimator import Estimator
from controller_fmu.estimator_variables import estimator_variables, refusals
from maglev.fmi.definition import DefaultExperiment, Drawing, FmuDefinition
from pmlsm.stage_description import Rig

FOLDER = "controller_fmu"


def estimator(rig: Rig) -> FmuDefinition:
    """Definition of the estimator of a rig."""
    rows = f"rows_{'tilts' if rig.rotations else rig.name}.html"
    return FmuDefinition(
        name=f"Estimator{rig.suffix}",
        block=Estimator,
        arguments=(rig,),
        description=f"Estimator of the constants of the {rig.title} while it moves",
        variables=estimator_variables(rig),
        refusals=refusals(rig),
        experiment=DefaultExperiment(stop_time=500 * rig.sample_time, step=rig.sample_time),
        sampled=True,
        documentation=((FOLDER, "estimator.html"), (FOLDER, rows),
                       (FOLDER, "matched_filter.html"), ("pmlsm", "motor.html")),
        icon=Drawing("controller_fmu.estimator_drawings", "icon", (len(rig.axes),)),
        sketch=Drawing("controller_fmu.estimator_drawings", "block_diagram"))


def adaptive_regulator(rig: Rig, regulator: FmuDefinition, estimator: FmuDefinition) -> FmuDefinition:
    """Definition of the adaptive regulator of a rig, from those of its parts."""
    return FmuDefinition(
        name=f"AdaptiveRegulator{rig.suffix}",
        block=AdaptiveRegulator,
        arguments=(rig,),
        description=f"Adaptive regulator of the {rig.title}: output regulation on the feedback-linearised motors, with "
                    "constants that are estimated during the run",
        variables=adaptive_variables(rig, regulator, estimator),
        refusals=regulator.refusals,
        experiment=regulator.experiment,
        sampled=True,
        documentation=tuple(dict.fromkeys(((FOLDER, "adaptation.html"), *estimator.documentation,
                                           *regulator.documentation))),
        icon=Drawing(ICONS, "controller", ("adaptive", len(rig.axes))),
        sketch=Drawing(DIAGRAMS, "regulator", ("nonlinear",)))
