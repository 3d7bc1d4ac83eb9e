"""The FMUs PID2DOF and PID3DOF."""

from controller_fmu.drawings import DIAGRAMS, ICONS
from controller_fmu.pid_2dof import PID2DOF
from controller_fmu.pid_3dof import PID3DOF
from controller_fmu.status import NO_EQUILIBRIUM, PREFILTER_TOO_FAST, STEP_MISFIT
from controller_fmu.variables import (
    REFUSED_STEP,
    SETPOINT_WITHOUT_EQUILIBRIUM,
    integral_hold,
    loop_parameters,
    model_constants,
    pid_parameters,
    ports,
    setpoint,
)
from fmi_export.definition import Drawing, Experiment, FmuDefinition
from pmlsm.rigs import RIG_2DOF, RIG_3DOF, Rig


def pid(name: str, block: type, rig: Rig, stage: str, limit_source: str, stop_time: float) -> FmuDefinition:
    """PID controller of a rig; the stage's name, the source of the limit, and the end of the default experiment (s)."""
    corners = ", ".join(f"{axis}.prefilter = {{{axis}.prefilter}} rad/s" for axis in rig.axis_names)
    return FmuDefinition(
        name=name,
        block=block,
        description=f"PID controller of the {stage}, one for each axis, with a pre-filter of the reference",
        variables=(
            *ports(rig),
            *model_constants(rig),
            *loop_parameters(rig, limit_source),
            integral_hold(),
            setpoint("the gains are designed", "assumed"),
            *(v for axis in rig.axis_names for v in pid_parameters(axis))),
        refusals={STEP_MISFIT: REFUSED_STEP, NO_EQUILIBRIUM: SETPOINT_WITHOUT_EQUILIBRIUM,
                  PREFILTER_TOO_FAST: f"{corners}, expected at most 0.8 / sample_time, with sample_time = "
                                      "{sample_time} s"},
        experiment=Experiment(stop_time=stop_time, step=rig.sample_time),
        variable_step=False,
        documentation=(("controller_fmu", "pid.html"), ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
        icon=Drawing(ICONS, "controller", ("PID", len(rig.axis_names))),
        sketch=Drawing(DIAGRAMS, "pid"))


PID_2DOF = pid("PID2DOF", PID2DOF, RIG_2DOF, "2-DOF stage", "assumed, as for the other controllers of this stage", 0.25)
PID_3DOF = pid("PID3DOF", PID3DOF, RIG_3DOF, "3-DOF stage",
               "assumed: the thesis limits commands with the antiwindup only", 0.1)
