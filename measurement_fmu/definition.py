"""The FMU of the measurement of a rig."""

from fmi_export.definition import DefaultExperiment, Drawing, FmuDefinition
from measurement_fmu.measurement import Measurement
from measurement_fmu.variables import REFUSALS, measurement_variables
from pmlsm.rig import Rig


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
        documentation=(("measurement_fmu", "measurement.html"),),
        icon=Drawing("measurement_fmu.drawings", "icon", (len(rig.axes),)),
        sketch=Drawing("measurement_fmu.drawings", "block_diagram"))
