"""The blocks of the controllers of a stage, written from its description: regulator, PID, commutation."""

from maglev.rig.text import (
    commented,
    constants,
    each,
    geometry,
    module,
    thrust_constant,
    times,
    vertical_constants,
)
from pmlsm.rig import Rig

STEP = '''
    def step(self, t: float, dt: float) -> int:
        """Sample if the sampling grid has a point at t; the commands hold over t to t + dt (s)."""
        if not self.clock.fits(dt, self.sample_time):
            return STEP_MISFIT
        if self.clock.due(dt, self.sample_time):
            self.sample()
        return STEPPED
'''


def taken(rig: Rig) -> str:
    """Constants of the vertical row with one direct current in all motors."""
    return ", ".join(times(rig.carrying, f"self.{name}") for name in vertical_constants(rig))


def driven(rig: Rig, axis: str, f1: str) -> str:
    """Acceleration of a horizontal axis by a quadrature current of -1 A in all motors that drive it."""
    motors = rig.sharing * len(rig.motors_of(axis))
    return f"{times(motors, f'self.{thrust_constant(rig, axis)}')} * {f1}"


def command_lines(rig: Rig, direct: str, quadrature: str) -> str:
    """Commands to the motors; {0} in `quadrature` is the axis that a motor drives."""
    return "\n".join(f"        {motor.name}.command({direct}, {quadrature.format(motor.drives)}, self.current_limit, "
                     f"self.geometry.electrical_angle({motor.drives}.measured))" for motor in rig.motors)


def first_motor(rig: Rig, axis: str) -> str:
    """Motor whose excess of current corrects an axis; all that drive it have the same, and all direct ones are one."""
    return rig.motors[0].name if axis == rig.vertical.name else rig.motors_of(axis)[0].name


def regulator(rig: Rig) -> str:
    """Text of `controller_fmu/regulator_NAME.py`."""
    vertical = rig.vertical.name
    axes, motors, horizontal = rig.axis_names, rig.motor_names, [axis.name for axis in rig.horizontal]
    scheduled = rig.design.schedule
    statuses = f"BAD_GEOMETRY, LINEAR, NO_EQUILIBRIUM, NONLINEAR, {'SCHEDULED, ' if scheduled else ''}STEP_MISFIT, STEPPED"
    iron = vertical_constants(rig)[2]
    squares = " + ".join(f"i_q_{axis} * i_q_{axis}" for axis in horizontal for _ in rig.motors_of(axis))
    by_quadrature = f"({squares})" if " + " in squares else squares
    prepared = """
        if self.law == SCHEDULED and not self.schedule.prepare(self.geometry, vertical.attraction, vertical.coils,
                                                               vertical.iron):
            return NO_EQUILIBRIUM""" if scheduled else ""
    chosen = f"""
        if self.law == SCHEDULED:
            self.schedule.choose({vertical}.measured, self.vertical.linear)""" if scheduled else ""
    limited = " or ".join(f"{motor}.limited" for motor in motors)
    return module(f'''
"""Regulators of the {rig.title} (4.15), (4.16), (5.13): output regulation, feedback-linearised or linearised."""

from math import pi

{"from controller_fmu.gain_schedule import GainSchedule" + chr(10) if scheduled else ""}\
from controller_fmu.internal_model import OscillatorStep
from controller_fmu.motor_command import MotorCommand
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import {statuses}
from controller_fmu.velocity_observer import ObserverFilter
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.motor_geometry import MotorGeometry


class Regulator{rig.suffix}:
    """Samples positions and references, commands phase currents that hold until the next sample.

    The law is NONLINEAR: the motors are feedback-linearised at the measured gap (4.12), (5.7). Or LINEAR: they are
    linearised about the set-point such that the closed loop has the same poles there (sections 4.6.1, 5.6.3).
{"    Or SCHEDULED: linear about the set-point of the region that the measured gap lies in (Table 5.4)." + chr(10) if scheduled else ""}\
    All motors get the same direct current.
    """

    def __init__(self, law: int = NONLINEAR):
        self.law = law
{commented([*constants(rig, "model"),
            (f"self.sample_time = {rig.sample_time!r}", "s, parameter"),
            ("self.omega0 = 1.5 * pi", "rad/s, parameter"),
            (f"self.setpoint = {rig.vertical.start!r}", "m, parameter of the linear law: gap of its linearisation"),
            ("self.bumpless = True", "parameter of the linear law"),
            (f"self.current_limit = {rig.design.current_limit!r}", "A, parameter, 0 = none"),
            (f"self.antiwindup = {rig.design.antiwindup}", "parameter"),
            ("self.trip_error = 0.0", "m, parameter, 0 = never"), *geometry(rig)])}
{chr(10).join(f"        self.{axis.name} = OutputRegulator({', '.join(map(repr, (*axis.design.gains, axis.design.antiwindup_gain, axis.start)))})" for axis in rig.axes)}
        self.observer = ObserverFilter()
        self.oscillator = OscillatorStep()
        self.vertical = VerticalLaw(law)
{f"        self.schedule = GainSchedule({', '.join(map(repr, (*scheduled.bounds, *scheduled.setpoints)))})" + chr(10) if scheduled else ""}\
        self.clock = SampleClock()
{each(motors, "        self.{0} = MotorCommand()")}
        self.started = False    # state: a measurement has come in
        self.saturated = False  # output
        self.feasible = True    # output
        self.tripped = False    # state and output

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        if not self.geometry.prepare():
            return BAD_GEOMETRY
        self.observer.prepare(self.sample_time)
        self.oscillator.prepare(self.omega0, self.sample_time)
        self.take_constants()
        vertical = self.vertical
        if self.law == LINEAR and not vertical.linearise(self.geometry, self.setpoint):
            return NO_EQUILIBRIUM{prepared}
        return STEPPED

    def take_constants(self) -> None:
        """Hand the constants to the vertical law: all motors attract, and one direct current flows in them."""
        self.vertical.take_constants({taken(rig)})
{STEP}
    def sample(self) -> None:
        """Run the law once."""
{each(axes, "        {0} = self.{0}")}
        if not self.started and {vertical}.measured <= 0.0:
            return   # an importer that has not exchanged values yet: this is no measurement
        self.take_constants(){chosen}
        if not self.started:
            # Not bumpless, it begins as though the mover rested at the set-point.
            gap = {vertical}.measured if self.bumpless else self.setpoint
            error = {vertical}.measured - {vertical}.reference if self.bumpless else 0.0
            {vertical}.start(self.vertical.holding_demand(self.geometry, gap, error), error)
{each(horizontal, "            {0}.start(0.0, {0}.measured - {0}.reference if self.bumpless else 0.0)")}
            self.started = True
{each(axes, "        {0}.sample(self.observer, self.sample_time)")}
        if {each(axes, "exceeds({0}.error, self.trip_error)", " or ")}:
            self.tripped = True
{each(motors, "        {0} = self.{0}")}
        if self.tripped:
{each(motors, "            {0}.release()")}
            self.saturated = False
            self.feasible = True   # nothing is demanded any more
            return
        i_d, {each(horizontal, "i_q_{0}", ", ")} = self.currents({each(axes, "{0}.demand()", ", ")})
{command_lines(rig, "i_d", "i_q_{0}")}
        self.saturated = {limited}
        antiwindup_time = self.sample_time if self.antiwindup else 0.0
        {vertical}.update(self.oscillator, antiwindup_time * {first_motor(rig, vertical)}.excess_d)
{chr(10).join(f"        {axis}.update(self.oscillator, antiwindup_time * {first_motor(rig, axis)}.excess_q)" for axis in horizontal)}

    def currents(self, {each(axes, "demand_{0}: float", ", ")}) -> tuple[{", ".join(["float"] * len(axes))}]:
        """Currents i_d, {each(horizontal, "i_q of {0}", ", ")} (A) for the demanded accelerations (m/s²), (4.12), (5.7) or linear."""
        vertical = self.vertical
        vertical.look(self.geometry, self.{vertical}.measured)
{chr(10).join(f"        i_q_{axis} = -demand_{axis} / ({driven(rig, axis, 'vertical.f1')})" for axis in horizontal)}
        i_d = vertical.direct_current(demand_{vertical}, self.{vertical}.error,
                                      {times(rig.sharing, f"self.{iron}")} * vertical.f4 * {by_quadrature})
        self.feasible = vertical.feasible
        return i_d, {each(horizontal, "i_q_{0}", ", ")}
''')


def pid(rig: Rig) -> str:
    """Text of `controller_fmu/pid_NAME.py`."""
    vertical = rig.vertical.name
    axes, motors, horizontal = rig.axis_names, rig.motor_names, [axis.name for axis in rig.horizontal]
    filterable = f"        if not ({each(axes, 'self.{0}.filterable(self.sample_time)', ' and ')}):"
    return module(f'''
"""PID controller of the {rig.title} (Figs. 4.6, 5.6): one PID for each axis, on the current that drives it."""

from controller_fmu.feedback_linearisation import equilibrium_current
from controller_fmu.linearisation import Linearisation
from controller_fmu.motor_command import MotorCommand
from controller_fmu.pid_axis import PIDAxis
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, NO_EQUILIBRIUM, PREFILTER_TOO_FAST, STEP_MISFIT, STEPPED
from controller_fmu.velocity_observer import ObserverFilter
from pmlsm.motor_geometry import MotorGeometry


class PID{rig.suffix}:
    """Samples positions and references, commands phase currents that hold until the next sample.

    All motors get the direct current of the {vertical}-axis.
    """

    def __init__(self) -> None:
{commented([*constants(rig, "model"),
            (f"self.sample_time = {rig.sample_time!r}", "s, parameter"),
            (f"self.setpoint = {rig.vertical.start!r}", "m, parameter: gap of the design"),
            (f"self.current_limit = {rig.design.pid_current_limit!r}", "A, parameter, 0 = none"),
            ("self.antiwindup = False", "parameter"),
            ("self.trip_error = 0.0", "m, parameter, 0 = never"), *geometry(rig)])}
{chr(10).join(f"        self.{axis.name} = PIDAxis({', '.join(map(repr, (*axis.design.pid, axis.start)))})" for axis in rig.axes)}
        self.observer = ObserverFilter()
        self.linear = Linearisation()
        self.clock = SampleClock()
{each(motors, "        self.{0} = MotorCommand()")}
        self.started = False    # state: a measurement has come in
        self.saturated = False  # output
        self.feasible = True    # output; a current is always commanded
        self.tripped = False    # state and output
        self.start()            # the gains of the design are start values

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        if not self.geometry.prepare():
            return BAD_GEOMETRY
        self.observer.prepare(self.sample_time)
{filterable}
            return PREFILTER_TOO_FAST
        if not self.linear.prepare(self.geometry, {taken(rig)}, self.setpoint):
            return NO_EQUILIBRIUM
        self.{vertical}.design(self.linear.stiffness, self.linear.gain)
{chr(10).join(f"        self.{axis}.design(0.0, -{driven(rig, axis, 'self.linear.f1')})" for axis in horizontal)}
        return STEPPED
{STEP}
    def sample(self) -> None:
        """Run the law once."""
{each(axes, "        {0} = self.{0}")}
        if not self.started:
            if {vertical}.measured <= 0.0:
                return   # an importer that has not exchanged values yet: this is no measurement
            current, found = equilibrium_current(self.geometry, {taken(rig)}, {vertical}.measured)
            {vertical}.start(current)
{each(horizontal, "            {0}.start(0.0)")}
            self.started = True
{each(axes, "        {0}.sample(self.observer, self.sample_time)")}
        if {each(axes, "exceeds({0}.error, self.trip_error)", " or ")}:
            self.tripped = True
{each(motors, "        {0} = self.{0}")}
        if self.tripped:
{each(motors, "            {0}.release()")}
            self.saturated = False
            return
        i_d = {vertical}.current()
{command_lines(rig, "i_d", "{0}.current()")}
        self.saturated = {each(motors, "{0}.limited", " or ")}
        {vertical}.update(self.sample_time, self.antiwindup and {first_motor(rig, vertical)}.excess_d != 0.0)
{chr(10).join(f"        {axis}.update(self.sample_time, self.antiwindup and {first_motor(rig, axis)}.excess_q != 0.0)" for axis in horizontal)}
''')


def commutation(rig: Rig) -> str:
    """Text of `controller_fmu/commutation_NAME.py`."""
    motors, horizontal = rig.motor_names, [axis.name for axis in rig.horizontal]
    return module(f'''
"""Commutation of the motors of the {rig.title} alone (C.1), for currents that somebody else decides."""

from controller_fmu.commutated_motor import CommutatedMotor, MeasuredDisplacement
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, STEP_MISFIT, STEPPED
from pmlsm.motor_geometry import MotorGeometry


class Commutation{rig.suffix}:
    """Samples displacements and current references, commands phase currents that hold until the next sample.

    Each motor commutates with the displacement that it drives.
    """

    def __init__(self) -> None:
{commented([(f"self.sample_time = {rig.sample_time!r}", "s, parameter"),
            ("self.current_limit = 0.0", "A, parameter, 0 = none"), *geometry(rig)])}
{each(horizontal, "        self.{0} = MeasuredDisplacement()")}
{each(motors, "        self.{0} = CommutatedMotor()")}
        self.clock = SampleClock()
        self.saturated = False  # output

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        if not self.geometry.prepare():
            return BAD_GEOMETRY
        return STEPPED
{STEP}
    def sample(self) -> None:
        """Commutate once."""
        geometry = self.geometry
{each(motors, "        {0} = self.{0}")}
{chr(10).join(f"        {motor.name}.commutate(self.current_limit, geometry.electrical_angle(self.{motor.drives}.measured))" for motor in rig.motors)}
        self.saturated = {each(motors, "{0}.saturated", " or ")}
''')
