"""The FMU Estimator3DOF."""

from estimator_fmu.estimator_3dof import STEP_MISFIT, Estimator3DOF
from estimator_fmu.icon import ESTIMATOR_ICON
from estimator_fmu.variables import (
    ATTRACTION,
    COILS,
    IRON,
    REFUSED_STEP,
    THRUST,
    axis_outputs,
    estimate,
    estimator_parameters,
    guess,
    measured_axis,
    motor_inputs,
)
from fmi_export.definition import Experiment, FmuDefinition
from pmlsm.data_sheet import SAMPLE_TIME_3DOF

GUESS = "assumed: half of Table 5.3, so that it has to be left"
OF_Y = ("y.measured", "alpha.i_d", "alpha.i_q", "beta.i_d", "beta.i_q")
OF_X = ("x.measured", "y.measured", "alpha.i_q")
OF_Z = ("z.measured", "y.measured", "beta.i_q")

ESTIMATOR_3DOF = FmuDefinition(
    name="Estimator3DOF",
    block=Estimator3DOF,
    description="Estimator of the constants of the 3-DOF stage while it moves",
    variables=(
        measured_axis("y", "air gap"),
        measured_axis("x", "horizontal displacement along x"),
        measured_axis("z", "horizontal displacement along z"),
        *motor_inputs("alpha"),
        *motor_inputs("beta"),
        *estimate("C1", THRUST, "thrust along x (5.3)", OF_X),
        *estimate("C2", THRUST, "thrust along z (5.3)", OF_Z),
        *estimate("C3", ATTRACTION, "attraction between magnets and iron (5.3)", OF_Y),
        *estimate("C4", COILS, "normal force between magnets and coils (5.3)", OF_Y),
        *estimate("C5", IRON, "normal force between coils and iron (5.3)", OF_Y),
        *axis_outputs("y", OF_Y),
        *axis_outputs("x", OF_X),
        *axis_outputs("z", OF_Z),
        *guess("C1", THRUST, GUESS, 1e-2),
        *guess("C2", THRUST, GUESS, 1e-2),
        *guess("C3", ATTRACTION, GUESS, 1e-6),
        *guess("C4", COILS, GUESS, 1e-4),
        *guess("C5", IRON, GUESS, 1e-1),
        *estimator_parameters("stated, section 5.1.4")),
    refusals={STEP_MISFIT: REFUSED_STEP},
    experiment=Experiment(stop_time=0.1, step=SAMPLE_TIME_3DOF),
    variable_step=False,
    documentation=(("estimator_fmu", "estimator.html"), ("estimator_fmu", "rows_3dof.html"),
                   ("estimator_fmu", "matched_filter.html"), ("pmlsm", "motor.html")),
    icon=ESTIMATOR_ICON)
