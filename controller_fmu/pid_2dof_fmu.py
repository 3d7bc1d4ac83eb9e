"""The FMU PID2DOF."""

from controller_fmu.icon import CONTROLLER_ICON
from controller_fmu.pid_2dof import PID2DOF
from controller_fmu.status import NO_EQUILIBRIUM, PREFILTER_TOO_FAST, STEP_MISFIT
from controller_fmu.variables import (
    REFUSED_STEP,
    SETPOINT_WITHOUT_EQUILIBRIUM,
    input_names,
    integral_hold,
    loop_parameters,
    model_constants_2dof,
    pid_parameters,
    ports_2dof,
    setpoint,
)
from fmi_export.definition import Experiment, FmuDefinition
from pmlsm.data_sheet import SAMPLE_TIME_2DOF

PID_2DOF = FmuDefinition(
    name="PID2DOF",
    block=PID2DOF,
    description="PID controller of the 2-DOF stage, one for each axis, with a pre-filter of the reference",
    variables=(
        *ports_2dof(d_from=input_names("v"), q_from=input_names("h")),
        *model_constants_2dof(),
        *loop_parameters("stated, section 4.1.4", "assumed, as for the other controllers of this stage"),
        integral_hold(),
        setpoint("the gains are designed", "assumed"),
        *pid_parameters("v"),
        *pid_parameters("h")),
    refusals={STEP_MISFIT: REFUSED_STEP, NO_EQUILIBRIUM: SETPOINT_WITHOUT_EQUILIBRIUM,
              PREFILTER_TOO_FAST: "v.prefilter = {v.prefilter} rad/s, h.prefilter = {h.prefilter} rad/s, expected at "
                                  "most 0.8 / sample_time, with sample_time = {sample_time} s"},
    experiment=Experiment(stop_time=0.2, step=SAMPLE_TIME_2DOF),
    variable_step=False,
    documentation=(("controller_fmu", "pid.html"), ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
    icon=CONTROLLER_ICON)
