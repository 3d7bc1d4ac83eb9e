"""The FMUs Regulator2DOF and LinearRegulator2DOF."""

from controller_fmu.drawings import DIAGRAMS, ICONS
from controller_fmu.regulator_2dof import Regulator2DOF
from controller_fmu.status import LINEAR, NO_EQUILIBRIUM, NONLINEAR, STEP_MISFIT
from controller_fmu.variables import (
    REFUSED_STEP,
    SETPOINT_WITHOUT_EQUILIBRIUM,
    bumpless_start,
    internal_model_parameters,
    loop_parameters,
    model_constants,
    ports,
    regulator_gains,
    setpoint,
)
from fmi_export.definition import Drawing, Experiment, FmuDefinition
from pmlsm.rigs import RIG_2DOF

PARAMETERS = (
    *model_constants(RIG_2DOF),
    *loop_parameters(RIG_2DOF, "assumed, from the axes of Fig. 4.20"),
    *internal_model_parameters("assumed: the thesis uses none on this stage"),
    *regulator_gains("v", "stated, (4.17)", "none in the thesis"),
    *regulator_gains("h", "stated, (4.17)", "none in the thesis"))

REGULATOR_2DOF = FmuDefinition(
    name="Regulator2DOF",
    block=Regulator2DOF,
    arguments=(NONLINEAR,),
    description="Nonlinear regulator of the 2-DOF stage: output regulation on the feedback-linearised motor",
    variables=(
        # The thrust depends on the gap.
        *ports(RIG_2DOF, by_all=True, by_gap=True),
        *PARAMETERS),
    refusals={STEP_MISFIT: REFUSED_STEP},
    experiment=Experiment(stop_time=0.25, step=RIG_2DOF.sample_time),
    variable_step=False,
    documentation=(("controller_fmu", "linearisation_2dof.html"), ("controller_fmu", "regulator.html"),
                   ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
    icon=Drawing(ICONS, "controller", ("nonlinear", 2)),
    sketch=Drawing(DIAGRAMS, "regulator", ("nonlinear",)))

LINEAR_REGULATOR_2DOF = FmuDefinition(
    name="LinearRegulator2DOF",
    block=Regulator2DOF,
    arguments=(LINEAR,),
    description="Linear regulator of the 2-DOF stage: output regulation on the motor linearised about a set-point",
    variables=(
        *ports(RIG_2DOF),
        setpoint("the motor is linearised", "assumed: mid-range; an experiment sets its target"),
        bumpless_start(),
        *PARAMETERS),
    refusals={STEP_MISFIT: REFUSED_STEP, NO_EQUILIBRIUM: SETPOINT_WITHOUT_EQUILIBRIUM},
    experiment=Experiment(stop_time=0.25, step=RIG_2DOF.sample_time),
    variable_step=False,
    documentation=(("controller_fmu", "setpoint_2dof.html"), ("controller_fmu", "regulator.html"),
                   ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
    icon=Drawing(ICONS, "controller", ("linear", 2)),
    sketch=Drawing(DIAGRAMS, "regulator", ("linear",)))
