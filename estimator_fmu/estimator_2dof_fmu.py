"""The FMU Estimator2DOF."""

from estimator_fmu.estimator_2dof import STEP_MISFIT, Estimator2DOF
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
from pmlsm.data_sheet import SAMPLE_TIME_2DOF

GUESS = "assumed: half of Table 4.3, so that it has to be left"
OF_V = ("v.measured", "motor.i_d", "motor.i_q")
OF_H = ("h.measured", "v.measured", "motor.i_q")

ESTIMATOR_2DOF = FmuDefinition(
    name="Estimator2DOF",
    block=Estimator2DOF,
    description="Estimator of the constants of the 2-DOF stage while it moves",
    variables=(
        measured_axis("v", "air gap"),
        measured_axis("h", "horizontal displacement"),
        *motor_inputs("motor"),
        *estimate("C1", THRUST, "thrust (4.3)", OF_H),
        *estimate("C2", ATTRACTION, "attraction between magnets and iron (4.3)", OF_V),
        *estimate("C3", COILS, "normal force between magnets and coils (4.3)", OF_V),
        *estimate("C4", IRON, "normal force between coils and iron (4.3)", OF_V),
        *axis_outputs("v", OF_V),
        *axis_outputs("h", OF_H),
        *guess("C1", THRUST, GUESS, 1e-4),
        *guess("C2", ATTRACTION, GUESS, 1e-6),
        *guess("C3", COILS, GUESS, 1e-4),
        *guess("C4", IRON, GUESS, 1e-2),
        *estimator_parameters("stated, section 4.1.4")),
    refusals={STEP_MISFIT: REFUSED_STEP},
    experiment=Experiment(stop_time=0.2, step=SAMPLE_TIME_2DOF),
    variable_step=False,
    documentation=(("estimator_fmu", "estimator.html"), ("estimator_fmu", "rows_2dof.html"),
                   ("estimator_fmu", "matched_filter.html"), ("pmlsm", "motor.html")),
    icon=ESTIMATOR_ICON)
