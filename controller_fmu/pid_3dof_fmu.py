"""The FMU PID3DOF."""

from controller_fmu.icon import CONTROLLER_ICON
from controller_fmu.pid_3dof import PID3DOF
from controller_fmu.status import NO_EQUILIBRIUM, PREFILTER_TOO_FAST, STEP_MISFIT
from controller_fmu.variables import (
    REFUSED_STEP,
    SETPOINT_WITHOUT_EQUILIBRIUM,
    input_names,
    integral_hold,
    loop_parameters,
    model_constants_3dof,
    pid_parameters,
    ports_3dof,
    setpoint,
)
from fmi_export.definition import Experiment, FmuDefinition
from pmlsm.data_sheet import SAMPLE_TIME_3DOF

PID_3DOF = FmuDefinition(
    name="PID3DOF",
    block=PID3DOF,
    description="PID controller of the 3-DOF stage, one for each axis, with a pre-filter of the reference",
    variables=(
        *ports_3dof(d_from=input_names("y"), x_from=input_names("x"), z_from=input_names("z")),
        *model_constants_3dof(),
        *loop_parameters("stated, section 5.1.4", "assumed: the thesis limits commands with the antiwindup only"),
        integral_hold(),
        setpoint("the gains are designed", "assumed"),
        *pid_parameters("y"),
        *pid_parameters("x"),
        *pid_parameters("z")),
    refusals={STEP_MISFIT: REFUSED_STEP, NO_EQUILIBRIUM: SETPOINT_WITHOUT_EQUILIBRIUM,
              PREFILTER_TOO_FAST: "y.prefilter = {y.prefilter} rad/s, x.prefilter = {x.prefilter} rad/s, z.prefilter = "
                                  "{z.prefilter} rad/s, expected at most 0.8 / sample_time, with sample_time = "
                                  "{sample_time} s"},
    experiment=Experiment(stop_time=0.1, step=SAMPLE_TIME_3DOF),
    variable_step=False,
    documentation=(("controller_fmu", "pid.html"), ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
    icon=CONTROLLER_ICON)
