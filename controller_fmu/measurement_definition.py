"""The FMU of the measurement of a rig."""

from controller_fmu.measurement import Measurement
from controller_fmu.measurement_variables import REFUSALS, measurement_variables
from maglev.fmi.definition import DefaultExperiment, Drawing, FmuDefinition
from pmlsm.stage_description import Rig


def measurement(rig: Rig) -> FmuDefinition:
    """Definition of the measurement of a rig, between its plant and a controller."""
    return FmuDefinition(
        name=f"Measurement{rig.suffix}",
        block=Measurement,
        arguments=(rig,),
        description=f"What a controller gets of the encoders of the {rig.title}",
        variables=measurement_variables(rig),
        refusals=REFUSALS,
        experiment=DefaultExperiment(stop_time=500 * rig.sample_time, step=rig.sample_time),
        sampled=True,
        documentation=(("controller_fmu", "measurement.html"),),
        icon=Drawing("controller_fmu.measurement_drawings", "icon", (len(rig.axes),)),
        sketch=Drawing("controller_fmu.measurement_drawings", "block_diagram"))
