"""The FMU of a stage."""

from maglev.fmi.definition import DefaultExperiment, Drawing, FmuDefinition
from plant_fmu.continuous import continuous_stage
from plant_fmu.stage import Stage
from plant_fmu.variables import stage_refusals, stage_variables
from pmlsm.stage_description import Rig


def plant(rig: Rig) -> FmuDefinition:
    """Definition of the plant of a rig."""
    # A tilt about what is seen from the side is in no drawing.
    drawn = rig.axis_names if len(rig.horizontal) == 2 else rig.axis_names[:2]
    page = "stage_tilts.html" if rig.rotations else f"stage_{rig.name}.html"
    return FmuDefinition(
        name=f"Plant{rig.suffix}",
        block=Stage,
        arguments=(rig,),
        description=f"{rig.title} {rig.text}, with its amplifiers",
        variables=stage_variables(rig),
        refusals=stage_refusals(rig),
        experiment=DefaultExperiment(stop_time=500 * rig.sample_time, step=rig.sample_time),
        variable_step=True,
        continuous=continuous_stage(rig),
        documentation=(("pmlsm", "motor.html"), ("plant_fmu", page), ("plant_fmu", "effects.html")),
        icon=Drawing("plant_fmu.drawings", "icon", (len(drawn),)),
        sketch=Drawing("plant_fmu.drawings", "stage_sketch", (rig.title, *drawn)))
