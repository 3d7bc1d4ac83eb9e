"""The FMU of a stage."""

from maglev.fmi.definition import DefaultExperiment, Drawing, FmuDefinition
from plant_fmu.continuous import continuous_stage
from plant_fmu.stage import Stage
from plant_fmu.variables import stage_refusals, stage_variables
from pmlsm.stage_description import StageDescription


def plant(stage: StageDescription) -> FmuDefinition:
    """Definition of the plant of a stage."""
    # A drawing from the side shows no tilt.
    drawn = stage.axis_names if len(stage.horizontal) == 2 else stage.axis_names[:2]
    page = "stage_tilts.html" if stage.rotations else f"stage_{stage.name}.html"
    return FmuDefinition(
        name=f"Plant{stage.suffix}",
        block=Stage,
        arguments=(stage,),
        description=f"{stage.title} {stage.text}, with its amplifiers",
        variables=stage_variables(stage),
        refusals=stage_refusals(stage),
        experiment=DefaultExperiment(stop_time=500 * stage.sample_time, step=stage.sample_time),
        variable_step=True,
        continuous=continuous_stage(stage),
        documentation=(("pmlsm", "motor.html"), ("plant_fmu", page), ("plant_fmu", "effects.html")),
        icon=Drawing("plant_fmu.drawings", "icon", (len(drawn),)),
        sketch=Drawing("plant_fmu.drawings", "stage_sketch", (stage.title, *drawn)))
