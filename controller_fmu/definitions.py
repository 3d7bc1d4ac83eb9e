"""The FMUs of the controllers of a rig."""

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
from pmlsm.stage_description import Rig
from pmlsm.variables import RATIOS, bad_geometry, motor_geometry

# Name, and what the description says, of the regulator with each law.
LAWS = {NONLINEAR: ("nonlinear", "Regulator", "on the feedback-linearised motors"),
        LINEAR: ("linear", "LinearRegulator", "on the motors linearised about a setpoint"),
        SCHEDULED: ("scheduled", "ScheduledRegulator",
                    "on the motors linearised about four setpoints, of which the measured gap chooses"),
        INTERPOLATED: ("interpolated", "InterpolatedRegulator",
                       "on the motors linearised at the measured gap, with the equilibrium current fed forward")}


def refusals(rig: Rig) -> dict[int, str]:
    """Refusals of every controller of a rig."""
    return {status.STEP_MISFIT: tables.REFUSED_STEP, status.BAD_GEOMETRY: bad_geometry(rig),
            **({status.BAD_PLACES: tables.bad_places(rig)} if rig.rotations else {})}


def tilts(rig: Rig, *pages: str) -> tuple[tuple[str, str], ...]:
    """Pages about a platform that tilts, if this one does."""
    return tuple(("controller_fmu", page) for page in (*pages, "tilts.html") if rig.rotations)


def default_experiment(rig: Rig) -> DefaultExperiment:
    """Five hundred samples, which no tool divides into steps that are none."""
    return DefaultExperiment(stop_time=500 * rig.sample_time, step=rig.sample_time)


def regulator(rig: Rig, law: int) -> FmuDefinition:
    """Definition of a regulator of a rig, with one of its laws.

    The thrust depends on the gap, or the gap chooses the linearisation; only the law that solves the vertical row at
    the gap asks the horizontal axes.
    """
    word, name, text = LAWS[law]
    kind = "tilts" if rig.rotations else rig.name
    pages = {NONLINEAR: (f"linearisation_{kind}.html",), LINEAR: (f"setpoint_{kind}.html",),
             SCHEDULED: (f"setpoint_{kind}.html", "schedule.html"),
             INTERPOLATED: (f"setpoint_{kind}.html", "interpolation.html")}[law]
    return FmuDefinition(
        name=f"{name}{rig.suffix}",
        block=Regulator,
        arguments=(rig, law),
        description=f"{word.capitalize()} regulator of the {rig.title}: output regulation {text}, with anti-windup",
        variables=placed(rig, (
            # Where the platform tilts, the lever of the thrust counts too.
            *tables.ports(rig, by_all=law == NONLINEAR or bool(rig.rotations), by_gap=law != LINEAR),
            *((tables.setpoint(rig, "the motors are linearised", "assumed: mid-range; an experiment sets its target"),
               tables.bumpless_start()) if law == LINEAR else ()),
            *tables.model_constants(rig),
            *tables.loop_parameters(rig, rig.source("design.current_limit")),
            *tables.internal_model_parameters(rig.source("design.antiwindup")),
            *(v for axis in rig.axes for v in tables.regulator_gains(rig, axis)),
            *tables.platform_parameters(rig),
            *motor_geometry(rig, *RATIOS))),
        refusals={**refusals(rig),
                  **({} if law == NONLINEAR else {status.NO_EQUILIBRIUM: no_equilibrium(rig, law)})},
        experiment=default_experiment(rig),
        sampled=True,
        documentation=(*(("controller_fmu", page) for page in pages), *tilts(rig), ("controller_fmu", "regulator.html"),
                       ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
        icon=Drawing(ICONS, "controller", (word, len(rig.axes))),
        sketch=Drawing(DIAGRAMS, "regulator", (word,)))


def no_equilibrium(rig: Rig, law: int) -> str:
    """Refusal of a law that cannot be designed."""
    schedule, table = rig.design.schedule, rig.design.table
    if law == SCHEDULED and schedule is not None:
        gaps = f"schedule's gaps of {', '.join(f'{1e3 * gap:g}' for gap in schedule.setpoints)}"
    elif law == INTERPOLATED and table is not None:
        gaps = f"table's gaps of {1e3 * table.gaps[0]:g} to {1e3 * table.gaps[-1]:g}"
    else:
        return tables.SETPOINT_WITHOUT_EQUILIBRIUM
    constants = ", ".join(f"{constant.name} = {{{constant.name}}} {constant.unit}" for constant in rig.constants
                          if constant.axis == rig.vertical.name)
    return f"{constants}, expected constants with which the model has equilibria at the {gaps} mm"


def pid(rig: Rig) -> FmuDefinition:
    """Definition of the PID controller of a rig."""
    corners = ", ".join(f"{axis}.prefilter = {{{axis}.prefilter}} rad/s" for axis in rig.axis_names)
    return FmuDefinition(
        name=f"PID{rig.suffix}",
        block=PID,
        arguments=(rig,),
        description=f"PID controller of the {rig.title}, one for each axis, with a pre-filter of the reference",
        variables=placed(rig, (
            *tables.ports(rig),
            *tables.model_constants(rig),
            *tables.loop_parameters(rig, rig.source("design.pid_current_limit")),
            tables.integral_hold(),
            tables.setpoint(rig, "the gains are designed", "assumed"),
            *(v for axis in rig.axes for v in tables.pid_parameters(axis)),
            *tables.platform_parameters(rig),
            *motor_geometry(rig, *RATIOS)), allocation="holding.allocation"),
        refusals={**refusals(rig), status.NO_EQUILIBRIUM: tables.SETPOINT_WITHOUT_EQUILIBRIUM,
                  status.PREFILTER_TOO_FAST: f"{corners}, expected at most 0.8 / sample_time, with sample_time = "
                                      "{sample_time} s"},
        experiment=default_experiment(rig),
        sampled=True,
        documentation=(("controller_fmu", "pid.html"), *tilts(rig, "pid_tilts.html"),
                       ("controller_fmu", "sampling.html"), ("pmlsm", "motor.html")),
        icon=Drawing(ICONS, "controller", ("PID", len(rig.axes))),
        sketch=Drawing(DIAGRAMS, "pid"))


def commutation(rig: Rig) -> FmuDefinition:
    """Definition of the commutation of a rig, without a law."""
    return FmuDefinition(
        name=f"Commutation{rig.suffix}",
        block=Commutation,
        arguments=(rig,),
        description=f"Commutation of the motors of the {rig.title}, for direct and quadrature currents that are inputs",
        variables=commutation_places(rig, (*tables.commutation_variables(rig), *motor_geometry(rig))),
        refusals=refusals(rig),
        experiment=default_experiment(rig),
        sampled=True,
        documentation=(("controller_fmu", "commutation.html"), *tilts(rig), ("pmlsm", "motor.html")),
        icon=Drawing(ICONS, "controller", ("commutation", len(rig.axes))),
        sketch=Drawing(DIAGRAMS, "commutation"))


def commutation_places(rig: Rig, variables: tuple[Variable, ...]) -> tuple[Variable, ...]:
    """Variables with their paths in a block that has no vertical axis, and parts that command."""
    horizontal = [axis.name for axis in rig.horizontal]
    return tuple(
        replace(v, path=f"axes[{horizontal.index(v.name.partition('.')[0])}].measured")
        if v.name.endswith(".measured") else
        replace(v, path=v.place.replace("].", "].command.")) if v.name.endswith("_cmd") else v
        for v in placed(rig, variables, "layout"))
