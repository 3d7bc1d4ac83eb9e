"""The FMUs Regulator3DOF, LinearRegulator3DOF and ScheduledRegulator3DOF."""

from controller_fmu.drawings import DIAGRAMS, ICONS
from controller_fmu.regulator_3dof import Regulator3DOF
from controller_fmu.status import LINEAR, NO_EQUILIBRIUM, NONLINEAR, SCHEDULED, STEP_MISFIT
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
from pmlsm.rigs import RIG_3DOF

PARAMETERS = (
    *model_constants(RIG_3DOF),
    *loop_parameters(RIG_3DOF, "stated, section 5.6.2"),
    *internal_model_parameters("stated, section 5.6.2"),
    *regulator_gains("y", "stated, (5.14); the text there says Kz (corrected)", "stated, (5.15)"),
    *regulator_gains("x", "stated, (5.14)", "stated, (5.15)"),
    *regulator_gains("z", "stated, (5.14)", "stated, (5.15)"))

REGULATOR_3DOF = FmuDefinition(
    name="Regulator3DOF",
    block=Regulator3DOF,
    arguments=(NONLINEAR,),
    description="Nonlinear regulator of the 3-DOF stage: output regulation on the feedback-linearised motors, "
                "with antiwindup",
    variables=(
        # The thrust depends on the gap.
        *ports(RIG_3DOF, by_all=True, by_gap=True),
        *PARAMETERS),
    refusals={STEP_MISFIT: REFUSED_STEP},
    experiment=Experiment(stop_time=0.1, step=RIG_3DOF.sample_time),
    variable_step=False,
    documentation=(("controller_fmu", "linearisation_3dof.html"), ("controller_fmu", "regulator.html"),
                   ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
    icon=Drawing(ICONS, "controller", ("nonlinear", 3)),
    sketch=Drawing(DIAGRAMS, "regulator", ("nonlinear",)))

LINEAR_REGULATOR_3DOF = FmuDefinition(
    name="LinearRegulator3DOF",
    block=Regulator3DOF,
    arguments=(LINEAR,),
    description="Linear regulator of the 3-DOF stage: output regulation on the motors linearised about a set-point, "
                "with antiwindup",
    variables=(
        *ports(RIG_3DOF),
        setpoint("the motors are linearised", "assumed: mid-range; an experiment sets its target"),
        bumpless_start(),
        *PARAMETERS),
    refusals={STEP_MISFIT: REFUSED_STEP, NO_EQUILIBRIUM: SETPOINT_WITHOUT_EQUILIBRIUM},
    experiment=Experiment(stop_time=0.1, step=RIG_3DOF.sample_time),
    variable_step=False,
    documentation=(("controller_fmu", "setpoint_3dof.html"), ("controller_fmu", "regulator.html"),
                   ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
    icon=Drawing(ICONS, "controller", ("linear", 3)),
    sketch=Drawing(DIAGRAMS, "regulator", ("linear",)))

SCHEDULED_REGULATOR_3DOF = FmuDefinition(
    name="ScheduledRegulator3DOF",
    block=Regulator3DOF,
    arguments=(SCHEDULED,),
    description="Gain-scheduled regulator of the 3-DOF stage: output regulation on the motors linearised about four "
                "set-points, the measured gap chooses, with antiwindup",
    variables=(
        # The gap chooses the linearisation.
        *ports(RIG_3DOF, by_gap=True),
        *PARAMETERS),
    refusals={STEP_MISFIT: REFUSED_STEP,
              NO_EQUILIBRIUM: "C3 = {C3} m/(s2.T2), C4 = {C4} m/(s2.A.T), C5 = {C5} m/(s2.A2), expected constants with "
                              "which the model has equilibria at the schedule's gaps of 27, 25, 23 and 21 mm"},
    experiment=Experiment(stop_time=0.1, step=RIG_3DOF.sample_time),
    variable_step=False,
    documentation=(("controller_fmu", "setpoint_3dof.html"), ("controller_fmu", "schedule.html"),
                   ("controller_fmu", "regulator.html"), ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
    icon=Drawing(ICONS, "controller", ("scheduled", 3)),
    sketch=Drawing(DIAGRAMS, "regulator", ("scheduled",)))
