"""The FMU Plant2DOF."""

from fmi_export.definition import Drawing, Experiment, FmuDefinition
from plant_fmu.stage_2dof import H_BEYOND_STOP, RUN_AWAY, STEP_TOO_LONG, V_BEYOND_STOP, Stage2DOF
from plant_fmu.variables import stage_refusals, stage_variables
from pmlsm.rigs import RIG_2DOF

PLANT_2DOF = FmuDefinition(
    name="Plant2DOF",
    block=Stage2DOF,
    description="2-DOF stage levitated and driven by one iron-cored linear synchronous motor, with its amplifiers",
    variables=stage_variables(RIG_2DOF),
    refusals=stage_refusals(RIG_2DOF, (V_BEYOND_STOP, H_BEYOND_STOP), RUN_AWAY, STEP_TOO_LONG),
    experiment=Experiment(stop_time=0.25, step=RIG_2DOF.sample_time),
    variable_step=True,
    documentation=(("pmlsm", "motor.html"), ("plant_fmu", "stage_2dof.html"), ("plant_fmu", "effects.html")),
    icon=Drawing("plant_fmu.drawings", "icon", (2,)),
    sketch=Drawing("plant_fmu.drawings", "sketch_2dof"))
