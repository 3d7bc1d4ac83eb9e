"""The FMUs of the controllers of a stage."""

from dataclasses import replace

import controller_fmu.status as status
import controller_fmu.variables as tables
from controller_fmu.commutation import Commutation
from controller_fmu.drawings import DIAGRAMS, ICONS
from controller_fmu.pid import PID
from controller_fmu.places import placed
from controller_fmu.regulator import Regulator
from controller_fmu.status import INTERPOLATED, LINEAR, NONLINEAR, SCHEDULED
from maglev.fmi.definition import DefaultExperiment, Drawing, FmuDefinition, Variable
from pmlsm.stage_description import StageDescription
from pmlsm.variables import RATIOS, bad_geometry, motor_geometry

# Name and description of the regulator with each law.
LAWS = {NONLINEAR: ("nonlinear", "Regulator", "on the feedback-linearised motors"),
        LINEAR: ("linear", "LinearRegulator", "on the motors linearised about a setpoint"),
        SCHEDULED: ("scheduled", "ScheduledRegulator",
                    "on the motors linearised about one of four setpoints, which the measured gap selects"),
        INTERPOLATED: ("interpolated", "InterpolatedRegulator",
                       "on the motors linearised at the measured gap, with the equilibrium current fed forward")}


def refusals(stage: StageDescription) -> dict[int, str]:
    """Refusals of every controller of a stage."""
    return {status.STEP_MISFIT: tables.REFUSED_STEP, status.BAD_GEOMETRY: bad_geometry(stage),
            **({status.BAD_PLACES: tables.bad_places(stage)} if stage.rotations else {})}


def tilts(stage: StageDescription, *pages: str) -> tuple[tuple[str, str], ...]:
    """Pages about a platform that tilts, if this one does."""
    return tuple(("controller_fmu", page) for page in (*pages, "tilts.html") if stage.rotations)


def default_experiment(stage: StageDescription) -> DefaultExperiment:
    """Return an experiment of five hundred samples, so that tools choose default steps that the FMU accepts."""
    return DefaultExperiment(stop_time=500 * stage.sample_time, step=stage.sample_time)


def regulator(stage: StageDescription, law: int) -> FmuDefinition:
    """Definition of a regulator of a stage, with one of its laws.

    The thrust depends on the gap, or the gap chooses the linearisation; only the law that solves the vertical row at
    the gap asks the horizontal axes.
    """
    word, name, text = LAWS[law]
    kind = "tilts" if stage.rotations else stage.name
    pages = {NONLINEAR: (f"linearisation_{kind}.html",), LINEAR: (f"setpoint_{kind}.html",),
             SCHEDULED: (f"setpoint_{kind}.html", "schedule.html"),
             INTERPOLATED: (f"setpoint_{kind}.html", "interpolation.html")}[law]
    return FmuDefinition(
        name=f"{name}{stage.suffix}",
        block=Regulator,
        arguments=(stage, law),
        description=f"{word.capitalize()} regulator of the {stage.title}: output regulation {text}, with anti-windup",
        variables=placed(stage, (
            # Where the platform tilts, the lever of the thrust counts too.
            *tables.ports(stage, by_all=law == NONLINEAR or bool(stage.rotations), by_gap=law != LINEAR),
            *((tables.setpoint(stage, "the motors are linearised", "assumed: mid-range; an experiment sets its target"),
               tables.bumpless_start()) if law == LINEAR else ()),
            *tables.model_constants(stage),
            *tables.loop_parameters(stage, stage.source("design.current_limit")),
            *tables.internal_model_parameters(stage.source("design.antiwindup")),
            *(v for axis in stage.axes for v in tables.regulator_gains(stage, axis)),
            *tables.platform_parameters(stage),
            *motor_geometry(stage, *RATIOS))),
        refusals={**refusals(stage),
                  **({} if law == NONLINEAR else {status.NO_EQUILIBRIUM: no_equilibrium(stage, law)})},
        experiment=default_experiment(stage),
        sampled=True,
        documentation=(*(("controller_fmu", page) for page in pages), *tilts(stage),
                       ("controller_fmu", "regulator.html"),
                       ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
        icon=Drawing(ICONS, "controller", (word, len(stage.axes))),
        sketch=Drawing(DIAGRAMS, "regulator", (word,)))


def no_equilibrium(stage: StageDescription, law: int) -> str:
    """Refusal of a law that cannot be designed."""
    schedule, table = stage.design.schedule, stage.design.table
    if law == SCHEDULED and schedule is not None:
        gaps = f"schedule's gaps of {', '.join(f'{1e3 * gap:g}' for gap in schedule.setpoints)}"
    elif law == INTERPOLATED and table is not None:
        gaps = f"table's gaps of {1e3 * table.gaps[0]:g} to {1e3 * table.gaps[-1]:g}"
    else:
        return tables.SETPOINT_WITHOUT_EQUILIBRIUM
    constants = ", ".join(f"{constant.name} = {{{constant.name}}} {constant.unit}" for constant in stage.constants
                          if constant.axis == stage.vertical.name)
    return f"{constants}, expected constants with which the model has equilibria at the {gaps} mm"


def pid(stage: StageDescription) -> FmuDefinition:
    """Definition of the PID controller of a stage."""
    corners = ", ".join(f"{axis}.prefilter = {{{axis}.prefilter}} rad/s" for axis in stage.axis_names)
    return FmuDefinition(
        name=f"PID{stage.suffix}",
        block=PID,
        arguments=(stage,),
        description=f"PID controller of the {stage.title}, one for each axis, with a pre-filter of the reference",
        variables=placed(stage, (
            *tables.ports(stage),
            *tables.model_constants(stage),
            *tables.loop_parameters(stage, stage.source("design.pid_current_limit")),
            tables.integral_hold(),
            tables.setpoint(stage, "the gains are designed", "assumed"),
            *(v for axis in stage.axes for v in tables.pid_parameters(axis)),
            *tables.platform_parameters(stage),
            *motor_geometry(stage, *RATIOS)), allocation="holding.allocation"),
        refusals={**refusals(stage), status.NO_EQUILIBRIUM: tables.SETPOINT_WITHOUT_EQUILIBRIUM,
                  status.PREFILTER_TOO_FAST: f"{corners}, expected at most 0.8 / sample_time, with sample_time = "
                                      "{sample_time} s"},
        experiment=default_experiment(stage),
        sampled=True,
        documentation=(("controller_fmu", "pid.html"), *tilts(stage, "pid_tilts.html"),
                       ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
        icon=Drawing(ICONS, "controller", ("PID", len(stage.axes))),
        sketch=Drawing(DIAGRAMS, "pid"))


def commutation(stage: StageDescription) -> FmuDefinition:
    """Definition of the commutation of a stage, without a law."""
    return FmuDefinition(
        name=f"Commutation{stage.suffix}",
        block=Commutation,
        arguments=(stage,),
        description=f"Commutation of the motors of the {stage.title}, for direct and quadrature currents that are "
                    f"inputs",
        variables=commutation_places(stage, (*tables.commutation_variables(stage), *motor_geometry(stage))),
        refusals=refusals(stage),
        experiment=default_experiment(stage),
        sampled=True,
        documentation=(("controller_fmu", "commutation.html"), *tilts(stage), ("pmlsm", "motor.html")),
        icon=Drawing(ICONS, "controller", ("commutation", len(stage.axes))),
        sketch=Drawing(DIAGRAMS, "commutation"))


def commutation_places(stage: StageDescription, variables: tuple[Variable, ...]) -> tuple[Variable, ...]:
    """Variables with their paths in a block that has no vertical axis, and parts that command."""
    horizontal = [axis.name for axis in stage.horizontal]
    return tuple(
        replace(v, path=f"axes[{horizontal.index(v.name.partition('.')[0])}].measured")
        if v.name.endswith(".measured") else
        replace(v, path=v.place.replace("].", "].command.")) if v.name.endswith("_cmd") else v
        for v in placed(stage, variables, "layout"))
