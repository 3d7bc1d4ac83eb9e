"""The FMU Plant3DOF."""

from fmi_export.definition import Drawing, Experiment, FmuDefinition
from plant_fmu.stage_3dof import RUN_AWAY, STEP_TOO_LONG, X_BEYOND_STOP, Y_BEYOND_STOP, Z_BEYOND_STOP, Stage3DOF
from plant_fmu.variables import stage_refusals, stage_variables
from pmlsm.rigs import RIG_3DOF

PLANT_3DOF = FmuDefinition(
    name="Plant3DOF",
    block=Stage3DOF,
    description="3-DOF stage levitated and driven by two pairs of iron-cored linear synchronous motors, "
                "with their amplifiers",
    variables=stage_variables(RIG_3DOF),
    refusals=stage_refusals(RIG_3DOF, (Y_BEYOND_STOP, X_BEYOND_STOP, Z_BEYOND_STOP), RUN_AWAY, STEP_TOO_LONG),
    experiment=Experiment(stop_time=0.1, step=RIG_3DOF.sample_time),
    variable_step=True,
    documentation=(("pmlsm", "motor.html"), ("plant_fmu", "stage_3dof.html"), ("plant_fmu", "effects.html")),
    icon=Drawing("plant_fmu.drawings", "icon", (3,)),
    sketch=Drawing("plant_fmu.drawings", "sketch_3dof"))
