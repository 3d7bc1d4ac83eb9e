"""The FMU Regulator2DOF."""

from controller_fmu.icon import CONTROLLER_ICON
from controller_fmu.regulator_2dof import STEP_MISFIT, Regulator2DOF
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
from pmlsm.data_sheet import SAMPLE_TIME_2DOF

FROM_H = (*input_names("h"), "v.measured")   # the thrust depends on the gap

REGULATOR_2DOF = FmuDefinition(
    name="Regulator2DOF",
    block=Regulator2DOF,
    description="Nonlinear regulator of the 2-DOF stage: output regulation on the feedback-linearised motor",
    variables=(
        *axis_inputs("v", "air gap"),
        *axis_inputs("h", "horizontal displacement"),
        *motor_outputs("motor", input_names("v", "h"), FROM_H, "h.measured"),
        axis_error("v"), axis_error("h"),
        *flags(input_names("v", "h")),
        constant("C1", "m/(s2.A)", "thrust (4.3)", "stated, Table 4.3"),
        constant("C2", "m/(s2.T2)", "attraction between magnets and iron (4.3)", "stated, Table 4.3"),
        constant("C3", "m/(s2.A.T)", "normal force between magnets and coils (4.3)", "stated, Table 4.3"),
        constant("C4", "m/(s2.A2)", "normal force between coils and iron (4.3)", "stated, Table 4.3"),
        *common_parameters("stated, section 4.1.4", "assumed, from the axes of Fig. 4.20",
                           "assumed: the thesis uses none on this stage"),
        *regulator_gains("v", "stated, (4.17)", "none in the thesis"),
        *regulator_gains("h", "stated, (4.17)", "none in the thesis")),
    refusals={STEP_MISFIT: REFUSED_STEP},
    experiment=Experiment(stop_time=0.2, step=SAMPLE_TIME_2DOF),
    variable_step=False,
    documentation=(("controller_fmu", "linearisation_2dof.html"), ("controller_fmu", "regulator.html"),
                   ("pmlsm", "motor.html")),
    icon=CONTROLLER_ICON)
