"""The FMU of the measurement of a stage."""

from controller_fmu.measurement import Measurement
from controller_fmu.measurement_variables import REFUSALS, measurement_variables
from maglev.fmi.definition import DefaultExperiment, Drawing, FmuDefinition
from pmlsm.stage_description import StageDescription


def measurement(stage: StageDescription) -> FmuDefinition:
    """Definition of the measurement of a stage, between its plant and a controller."""
    return FmuDefinition(
        name=f"Measurement{stage.suffix}",
        block=Measurement,
        arguments=(stage,),
        description=f"Encoders of the {stage.title} as a controller reads them",
        variables=measurement_variables(stage),
        refusals=REFUSALS,
        experiment=DefaultExperiment(stop_time=500 * stage.sample_time, step=stage.sample_time),
        sampled=True,
        documentation=(("controller_fmu", "measurement.html"),),
        icon=Drawing("controller_fmu.measurement_drawings", "icon", (len(stage.axes),)),
        sketch=Drawing("controller_fmu.measurement_drawings", "block_diagram"))
