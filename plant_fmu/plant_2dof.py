"""The FMU Plant2DOF."""

from fmi_export.definition import Experiment, FmuDefinition
from plant_fmu.icon import PLANT_ICON
from plant_fmu.stage_2dof import H_BEYOND_STOP, RUN_AWAY, STEP_TOO_LONG, V_BEYOND_STOP, Stage2DOF
from plant_fmu.variables import REFUSED_LENGTH, constant, stage_variables
from pmlsm.data_sheet import SAMPLE_TIME_2DOF

IDENTIFIED = "stated, Table 4.2; assumed to be the true stage"

PLANT_2DOF = FmuDefinition(
    name="Plant2DOF",
    block=Stage2DOF,
    description="2-DOF stage levitated and driven by one iron-cored linear synchronous motor, with its amplifiers",
    variables=stage_variables(
        constants=(
            constant("C1", "m/(s2.A)", "thrust (4.3)", IDENTIFIED),
            constant("C2", "m/(s2.T2)", "attraction between magnets and iron (4.3)", IDENTIFIED),
            constant("C3", "m/(s2.A.T)", "normal force between magnets and coils (4.3)", IDENTIFIED),
            constant("C4", "m/(s2.A2)", "normal force between coils and iron (4.3)", IDENTIFIED)),
        axes=(("v", "air gap"), ("h", "horizontal displacement")),
        motors=("motor",)),
    refusals={
        V_BEYOND_STOP: "v.position_start = {v.position_start} m, expected a place between the stops "
                       "v.stop.lower = {v.stop.lower} m and v.stop.upper = {v.stop.upper} m",
        H_BEYOND_STOP: "h.position_start = {h.position_start} m, expected a place between the stops "
                       "h.stop.lower = {h.stop.lower} m and h.stop.upper = {h.stop.upper} m",
        RUN_AWAY: "the mover has run away in the step from {time} s: v.position = {v.position} m, "
                  "h.position = {h.position} m, expected both within 1000 m and slower than 1e6 m/s",
        STEP_TOO_LONG: REFUSED_LENGTH},
    experiment=Experiment(stop_time=0.2, step=SAMPLE_TIME_2DOF),
    variable_step=True,
    documentation=(("pmlsm", "motor.html"), ("plant_fmu", "stage_2dof.html"), ("plant_fmu", "effects.html")),
    icon=PLANT_ICON)
