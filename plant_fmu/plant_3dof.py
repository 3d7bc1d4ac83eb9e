"""The FMU Plant3DOF."""

from fmi_export.definition import Experiment, FmuDefinition
from plant_fmu.icon import PLANT_ICON
from plant_fmu.stage_3dof import RUN_AWAY, STEP_TOO_LONG, X_BEYOND_STOP, Y_BEYOND_STOP, Z_BEYOND_STOP, Stage3DOF
from plant_fmu.variables import REFUSED_LENGTH, constant, ripple_parameters, stage_variables
from pmlsm.data_sheet import SAMPLE_TIME_3DOF

IDENTIFIED = "stated, Table 5.2; assumed to be the true stage"

PLANT_3DOF = FmuDefinition(
    name="Plant3DOF",
    block=Stage3DOF,
    description="3-DOF stage levitated and driven by two pairs of iron-cored linear synchronous motors, "
                "with their amplifiers",
    variables=stage_variables(
        constants=(
            constant("C1", "m/(s2.A)", "thrust along x (5.3)", IDENTIFIED),
            constant("C2", "m/(s2.A)", "thrust along z (5.3)", IDENTIFIED),
            constant("C3", "m/(s2.T2)", "attraction between magnets and iron (5.3)", IDENTIFIED),
            constant("C4", "m/(s2.A.T)", "normal force between magnets and coils (5.3)", IDENTIFIED),
            constant("C5", "m/(s2.A2)", "normal force between coils and iron (5.3)", IDENTIFIED)),
        axes=(("y", "air gap"), ("x", "horizontal displacement along x"), ("z", "horizontal displacement along z")),
        motors=("alpha", "beta"),
        extra=ripple_parameters("y")),
    refusals={
        **{status: f"{axis}.position_start = {{{axis}.position_start}} m, expected a place between the stops "
                   f"{axis}.stop.lower = {{{axis}.stop.lower}} m and {axis}.stop.upper = {{{axis}.stop.upper}} m"
           for status, axis in ((Y_BEYOND_STOP, "y"), (X_BEYOND_STOP, "x"), (Z_BEYOND_STOP, "z"))},
        RUN_AWAY: "the mover has run away in the step from {time} s: y.position = {y.position} m, "
                  "x.position = {x.position} m, z.position = {z.position} m, "
                  "expected all within 1000 m and slower than 1e6 m/s",
        STEP_TOO_LONG: REFUSED_LENGTH},
    experiment=Experiment(stop_time=0.1, step=SAMPLE_TIME_3DOF),
    variable_step=True,
    documentation=(("pmlsm", "motor.html"), ("plant_fmu", "stage_3dof.html"), ("plant_fmu", "effects.html")),
    icon=PLANT_ICON)
