"""The FMU Regulator3DOF."""

from controller_fmu.icon import CONTROLLER_ICON
from controller_fmu.regulator_3dof import STEP_MISFIT, Regulator3DOF
from controller_fmu.variables import (
    REFUSED_STEP,
    axis_error,
    axis_inputs,
    common_parameters,
    constant,
    flags,
    input_names,
    motor_outputs,
    regulator_gains,
)
from fmi_export.definition import Experiment, FmuDefinition
from pmlsm.data_sheet import SAMPLE_TIME_3DOF

FROM_X = (*input_names("x"), "y.measured")   # the thrust depends on the gap
FROM_Z = (*input_names("z"), "y.measured")
FROM_ALL = input_names("y", "x", "z")

REGULATOR_3DOF = FmuDefinition(
    name="Regulator3DOF",
    block=Regulator3DOF,
    description="Nonlinear regulator of the 3-DOF stage: output regulation on the feedback-linearised motors, "
                "with antiwindup",
    variables=(
        *axis_inputs("y", "air gap"),
        *axis_inputs("x", "horizontal displacement along x"),
        *axis_inputs("z", "horizontal displacement along z"),
        *motor_outputs("alpha", FROM_ALL, FROM_X, "x.measured"),
        *motor_outputs("beta", FROM_ALL, FROM_Z, "z.measured"),
        axis_error("y"), axis_error("x"), axis_error("z"),
        *flags(FROM_ALL),
        constant("C1", "m/(s2.A)", "thrust along x (5.3)", "stated, Table 5.3"),
        constant("C2", "m/(s2.A)", "thrust along z (5.3)", "stated, Table 5.3"),
        constant("C3", "m/(s2.T2)", "attraction between magnets and iron (5.3)", "stated, Table 5.3"),
        constant("C4", "m/(s2.A.T)", "normal force between magnets and coils (5.3)", "stated, Table 5.3"),
        constant("C5", "m/(s2.A2)", "normal force between coils and iron (5.3)", "stated, Table 5.3"),
        *common_parameters("stated, section 5.1.4", "stated, section 5.6.2", "stated, section 5.6.2"),
        *regulator_gains("y", "stated, (5.14); the text there says Kz (corrected)", "stated, (5.15)"),
        *regulator_gains("x", "stated, (5.14)", "stated, (5.15)"),
        *regulator_gains("z", "stated, (5.14)", "stated, (5.15)")),
    refusals={STEP_MISFIT: REFUSED_STEP},
    experiment=Experiment(stop_time=0.1, step=SAMPLE_TIME_3DOF),
    variable_step=False,
    documentation=(("controller_fmu", "linearisation_3dof.html"), ("controller_fmu", "regulator.html"),
                   ("pmlsm", "motor.html")),
    icon=CONTROLLER_ICON)
