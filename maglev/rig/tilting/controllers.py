"""The blocks of the controllers of a stage whose platform tilts, written from its description."""

from collections.abc import Iterable

from maglev.rig.controllers import STEP, driven, taken
from maglev.rig.text import commented, constants, each, geometry, module
from pmlsm.rig import Rig

NO_MEASUREMENT = "return   # an importer that has not exchanged values yet: this is no measurement"


def platform(rig: Rig) -> str:
    """Construction of the platform with its motors."""
    return (f"        self.platform = TiltingPlatform({rig.height!r})\n"
            "        self.tilts = TiltMeasurement()\n" + places(rig))


def allocation(rig: Rig) -> str:
    """Construction of the allocation of the forces, with the masses and the inertias."""
    inertias = ", ".join(repr(axis.mass) for axis in (rig.vertical, *rig.horizontal, *rig.rotations))
    return f"        self.allocation = ForceAllocation({inertias})"


def places(rig: Rig) -> str:
    """Construction of the places of the motors."""
    return "\n".join(f"        self.{motor.name}_place = MotorPlace({motor.x!r}, {motor.z!r}, {rig.vertical.start!r})"
                     for motor in rig.motors)


def unmeasured(rig: Rig, indent: int) -> str:
    """Condition that a gap has not been measured yet, in lines of an indent."""
    return each(rig.motor_names, "{0}_place.gap_measured <= 0.0", " or ")


def displacements(rig: Rig, roll: str, pitch: str) -> str:
    """The displacements at the faces of the magnets, which the tilts move."""
    first, second = (axis.name for axis in rig.horizontal)
    return (f"        along_{first} = platform.along_x({first}.measured, {pitch})\n"
            f"        along_{second} = platform.along_z({second}.measured, {roll})")


PREPARE_PLATFORM = '''
    def prepare_platform(self) -> bool:
        """Compute each motor's share; whether the motors feel and make every tilt."""
        platform = self.platform
        platform.begin()
{added}
        if not platform.solvable():
            return False
{shared}
        return True
'''


def prepare_platform(rig: Rig) -> str:
    """Method that computes the shares of the motors."""
    return PREPARE_PLATFORM.format(added=each(rig.motor_names, "        platform.add(self.{0}_place)"),
                                   shared=each(rig.motor_names, "        platform.share(self.{0}_place)"))


ADD_GAP = "        tilts.add(self.{0}_place, self.{0}_place.gap_measured)"

MEASURE = '''
    def measure(self) -> None:
        """Compute {what} from the gaps at the motors."""
        tilts = self.tilts
        tilts.clear()
{added}
{taken}
'''


def measure(rig: Rig, tilts: bool = True) -> str:
    """Method that computes the air gap at the centre, and the tilts if they are axes of the block."""
    values = zip((rig.vertical, *rig.rotations) if tilts else (rig.vertical,), ("y", "roll", "pitch"), strict=False)
    return MEASURE.format(what="the air gap at the centre" + " and the tilts" * tilts, added=each(rig.motor_names, ADD_GAP),
                          taken="\n".join(f"        self.{axis.name}.measured = tilts.{value}" for axis, value in values))


def trips(rig: Rig) -> str:
    """Condition that an error trips the controller."""
    return " or ".join(
        f"exceeds({axis.name}.error, self.{'trip_tilt' if axis.rotation else 'trip_error'})" for axis in rig.axes)


def mean_excess(rig: Rig, axis: str) -> str:
    """What the limits have taken from the quadrature currents that drive an axis, on average."""
    terms = [f"{motor.name}.excess_q" for motor in rig.motors_of(axis)]
    return terms[0] if len(terms) == 1 else f"{1.0 / len(terms)!r} * ({' + '.join(terms)})"


def regulator(rig: Rig) -> str:
    """Text of `controller_fmu/regulator_NAME.py`."""
    vertical = rig.vertical.name
    axes, motors, horizontal = rig.axis_names, rig.motor_names, [axis.name for axis in rig.horizontal]
    roll, pitch = (axis.name for axis in rig.rotations)
    level = [axis for axis in axes if axis != vertical]
    drives = "\n".join(
        f"        self.drive({m.name}, {m.name}_place, {m.name}_law, {m.drives}_demand, {driven(rig, m.drives, '').removesuffix(' * ')}, along_{m.drives})"
        for m in rig.motors)
    return module(f'''
"""Regulators of the {rig.title} (4.15), (4.16), (5.13): output regulation, feedback-linearised or linearised."""

from math import pi

from controller_fmu.force_allocation import ForceAllocation
from controller_fmu.internal_model import OscillatorStep
from controller_fmu.motor_command import MotorCommand
from controller_fmu.motor_place import MotorPlace
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, BAD_PLACES, LINEAR, NO_EQUILIBRIUM, NONLINEAR, STEP_MISFIT, STEPPED
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
from controller_fmu.velocity_observer import ObserverFilter
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.motor_geometry import MotorGeometry


class Regulator{rig.suffix}:
    """Samples positions, gaps and references, commands phase currents that hold until the next sample.

    The law is NONLINEAR: each motor is feedback-linearised at its own gap (4.12), (5.7). Or LINEAR: the motors are
    linearised about the set-point without tilt such that the closed loop has the same poles there (sections 4.6.1,
    5.6.3). {vertical}, {roll} and {pitch} follow from the gaps at the motors; what they demand is split evenly over the motors.
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
            ("self.trip_error = 0.0", "m, parameter, 0 = never"),
            ("self.trip_tilt = 0.0", "rad, parameter, 0 = never"), *geometry(rig)])}
{chr(10).join(f"        self.{axis.name} = OutputRegulator({', '.join(map(repr, (*axis.design.gains, axis.design.antiwindup_gain, axis.start)))})" for axis in rig.axes)}
        self.observer = ObserverFilter()
        self.oscillator = OscillatorStep()
{platform(rig)}
{allocation(rig)}
        self.short = TiltMeasurement()   # of the direct currents
        self.clock = SampleClock()
{each(motors, "        self.{0} = MotorCommand()")}
{each(motors, "        self.{0}_law = VerticalLaw(law)")}
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
        if not self.prepare_platform():
            return BAD_PLACES
        self.take_constants()
        if self.law == LINEAR:
            self.allocation.weight = 0.0   # the demands are about the equilibrium
            if not ({each(motors, "self.{0}_law.linearise(self.geometry, self.setpoint)", " and ")}):
                return NO_EQUILIBRIUM
        return STEPPED
{prepare_platform(rig)}
    def take_constants(self) -> None:
        """Hand the constants to the law of each motor, as though all motors were like it."""
{each(motors, f"        self.{{0}}_law.take_constants({taken(rig)})")}
{STEP}
    def sample(self) -> None:
        """Run the law once."""
{each(axes, "        {0} = self.{0}")}
        platform = self.platform
{each(motors, "        {0}_place = self.{0}_place")}
        if not self.started and ({unmeasured(rig, 33)}):
            {NO_MEASUREMENT}
        self.take_constants()
        self.measure()
        if not self.started:
            # Not bumpless, it begins as though the platform rested at the set-point.
            {vertical}.start(self.holding_demand(), {vertical}.measured - {vertical}.reference if self.bumpless else 0.0)
{each(level, "            {0}.start(0.0, {0}.measured - {0}.reference if self.bumpless else 0.0)")}
            self.started = True
{each(axes, "        {0}.sample(self.observer, self.sample_time)")}
        if {trips(rig)}:
            self.tripped = True
{each(motors, "        {0} = self.{0}")}
        if self.tripped:
{each(motors, "            {0}.release()")}
            self.saturated = False
            self.feasible = True   # nothing is demanded any more
            return
{each(horizontal, "        {0}_demand = {0}.demand()")}
        self.allocation.demand(platform, {vertical}.demand(), {each(horizontal, "{0}_demand", ", ")}, {roll}.demand(), {pitch}.demand())
{displacements(rig, f"{roll}.measured", f"{pitch}.measured")}
{each(motors, "        {0}_law = self.{0}_law")}
{drives}
        self.feasible = {each(motors, "{0}_law.feasible", " and ")}
        self.saturated = {each(motors, "{0}.limited", " or ")}
        short = self.short
        short.clear()
{each(motors, "        short.add({0}_place, {0}.excess_d)")}
        antiwindup_time = self.sample_time if self.antiwindup else 0.0
        {vertical}.update(self.oscillator, antiwindup_time * short.y)
{chr(10).join(f"        {axis}.update(self.oscillator, antiwindup_time * {mean_excess(rig, axis)})" for axis in horizontal)}
        {roll}.update(self.oscillator, antiwindup_time * short.roll)
        {pitch}.update(self.oscillator, antiwindup_time * short.pitch)
{measure(rig)}
    def holding_demand(self) -> float:
        """Demand of {vertical} (m/s²) by which the currents hold the platform where it is, or without tilt at the set-point."""
        tilts = self.tilts
        tilts.clear()
{chr(10).join(f"        tilts.add(self.{m}_place, self.held(self.{m}_place, self.{m}_law))" for m in motors)}
        return tilts.y

    def held(self, place: MotorPlace, law: VerticalLaw) -> float:
        """Demand (m/s²) of a motor by which it carries its part."""
        if not self.bumpless:
            return law.holding_demand(self.geometry, self.setpoint, 0.0)
        return law.holding_demand(self.geometry, place.gap_measured, self.gap_error(place))

    def gap_error(self, place: MotorPlace) -> float:
        """Error of the gap at a motor, m."""
        return place.gap_measured - place.moved(self.{vertical}.reference, self.{roll}.reference, self.{pitch}.reference)

    def drive(self, motor: MotorCommand, place: MotorPlace, law: VerticalLaw, demand: float, thrust: float,
              displacement: float) -> None:
        """Command a motor.

        Parameters
        ----------
        motor, place, law : MotorCommand, MotorPlace, VerticalLaw
            Of the motor.
        demand : float
            Acceleration of the axis that it drives, m/s².
        thrust : float
            Constant of all motors that drive it, m/(s² A).
        displacement : float
            At the faces of the magnets, m.
        """
        law.look(self.geometry, place.gap_measured)
        i_q = -demand / (thrust * law.f1)
        i_d = law.direct_current(self.allocation.demand_at(place), self.gap_error(place), law.iron * law.f4 * i_q * i_q)
        motor.command(i_d, i_q, self.current_limit, self.geometry.electrical_angle(displacement))
''')



def any_excess(motors: Iterable[str], component: str) -> str:
    """Condition that a current of one of the motors is limited."""
    return each(motors, f"{{0}}.excess_{component} != 0.0", " or ")


def pid(rig: Rig) -> str:
    """Text of `controller_fmu/pid_NAME.py`."""
    vertical = rig.vertical.name
    axes, motors, horizontal = rig.axis_names, rig.motor_names, [axis.name for axis in rig.horizontal]
    roll, pitch = (axis.name for axis in rig.rotations)
    filterable = each(axes, "self.{0}.filterable(self.sample_time)", " and ")
    drives = "\n".join(f"        self.drive({motor.name}, {motor.name}_place, {motor.drives}.current(), along_{motor.drives})"
                       for motor in rig.motors)
    updates = "\n".join(
        f"        {axis}.update(self.sample_time, self.antiwindup and {'(' + any_excess([m.name for m in rig.motors_of(axis)], 'q') + ')' if axis in horizontal else 'held'})"
        for axis in axes)
    return module(f'''
"""PID controller of the {rig.title} (Figs. 4.6, 5.6): one PID for each axis, on the currents that move it."""

from controller_fmu.feedback_linearisation import equilibrium_current
from controller_fmu.force_allocation import ForceAllocation
from controller_fmu.linearisation import Linearisation
from controller_fmu.motor_command import MotorCommand
from controller_fmu.motor_place import MotorPlace
from controller_fmu.pid_axis import PIDAxis
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, BAD_PLACES, NO_EQUILIBRIUM, PREFILTER_TOO_FAST, STEP_MISFIT, STEPPED
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
from controller_fmu.velocity_observer import ObserverFilter
from pmlsm.motor_geometry import MotorGeometry


class PID{rig.suffix}:
    """Samples positions, gaps and references, commands phase currents that hold until the next sample.

    {vertical}, {roll} and {pitch} follow from the gaps at the motors. The PID of {vertical} commands a direct current that
    all motors get, those of {roll} and {pitch} how it changes over the platform, in A/m.
    """

    def __init__(self) -> None:
{commented([*constants(rig, "model"),
            (f"self.sample_time = {rig.sample_time!r}", "s, parameter"),
            (f"self.setpoint = {rig.vertical.start!r}", "m, parameter: gap of the design"),
            (f"self.current_limit = {rig.design.pid_current_limit!r}", "A, parameter, 0 = none"),
            ("self.antiwindup = False", "parameter"),
            ("self.trip_error = 0.0", "m, parameter, 0 = never"),
            ("self.trip_tilt = 0.0", "rad, parameter, 0 = never"), *geometry(rig)])}
{chr(10).join(f"        self.{axis.name} = PIDAxis({', '.join(map(repr, (*axis.design.pid, axis.start)))})" for axis in rig.axes)}
        self.observer = ObserverFilter()
        self.linear = Linearisation()
{platform(rig)}
{allocation(rig)}
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
        if not self.prepare_platform():
            return BAD_PLACES
        if not ({filterable}):
            return PREFILTER_TOO_FAST
        if not self.linear.prepare(self.geometry, {taken(rig)}, self.setpoint):
            return NO_EQUILIBRIUM
        stiffness = self.linear.stiffness
        gain = self.linear.gain
        roll_ratio = self.allocation.roll_ratio(self.platform)
        pitch_ratio = self.allocation.pitch_ratio(self.platform)
        self.{vertical}.design(stiffness, gain)
{chr(10).join(f"        self.{axis}.design(0.0, -{driven(rig, axis, 'self.linear.f1')})" for axis in horizontal)}
        self.{roll}.design(roll_ratio * stiffness, roll_ratio * gain)
        self.{pitch}.design(pitch_ratio * stiffness, pitch_ratio * gain)
        return STEPPED
{prepare_platform(rig)}{STEP}
    def sample(self) -> None:
        """Run the law once."""
{each(axes, "        {0} = self.{0}")}
        platform = self.platform
{each(motors, "        {0}_place = self.{0}_place")}
        if not self.started and ({unmeasured(rig, 33)}):
            {NO_MEASUREMENT}
        self.measure()
        if not self.started:
            tilts = self.tilts
            tilts.clear()
{each(motors, "            tilts.add({0}_place, self.holding_current({0}_place))")}
            {vertical}.start(tilts.y)
{each(horizontal, "            {0}.start(0.0)")}
            {roll}.start(tilts.roll)
            {pitch}.start(tilts.pitch)
            self.started = True
{each(axes, "        {0}.sample(self.observer, self.sample_time)")}
        if {trips(rig)}:
            self.tripped = True
{each(motors, "        {0} = self.{0}")}
        if self.tripped:
{each(motors, "            {0}.release()")}
            self.saturated = False
            return
{displacements(rig, f"{roll}.measured", f"{pitch}.measured")}
{drives}
        self.saturated = {each(motors, "{0}.limited", " or ")}
        held = {any_excess(motors, "d")}
{updates}
{measure(rig)}
    def holding_current(self, place: MotorPlace) -> float:
        """Direct current (A) by which a motor carries its part at its gap."""
        current, found = equilibrium_current(self.geometry, {taken(rig)},
                                             place.gap_measured)
        return current

    def drive(self, motor: MotorCommand, place: MotorPlace, i_q: float, displacement: float) -> None:
        """Command a motor its direct current, a quadrature current (A) and a displacement (m) at the magnets' faces."""
        i_d = place.moved(self.{vertical}.current(), self.{roll}.current(), self.{pitch}.current())
        motor.command(i_d, i_q, self.current_limit, self.geometry.electrical_angle(displacement))
''')


def commutation(rig: Rig) -> str:
    """Text of `controller_fmu/commutation_NAME.py`."""
    motors, horizontal = rig.motor_names, [axis.name for axis in rig.horizontal]
    return module(f'''
"""Commutation of the motors of the {rig.title} alone (C.1), for currents that somebody else decides."""

from controller_fmu.commutated_motor import CommutatedMotor, MeasuredDisplacement
from controller_fmu.motor_place import MotorPlace
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, BAD_PLACES, STEP_MISFIT, STEPPED
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
from pmlsm.motor_geometry import MotorGeometry


class Commutation{rig.suffix}:
    """Samples displacements, gaps and current references, commands phase currents that hold until the next sample.

    Each motor commutates with the displacement at its magnets, which the tilts move; they follow from the gaps.
    """

    def __init__(self) -> None:
{commented([(f"self.sample_time = {rig.sample_time!r}", "s, parameter"),
            ("self.current_limit = 0.0", "A, parameter, 0 = none"), *geometry(rig)])}
{each(horizontal, "        self.{0} = MeasuredDisplacement()")}
{each(motors, "        self.{0} = CommutatedMotor()")}
{platform(rig)}
        self.clock = SampleClock()
        self.saturated = False  # output

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        if not self.geometry.prepare():
            return BAD_GEOMETRY
        if not self.prepare_platform():
            return BAD_PLACES
        return STEPPED
{prepare_platform(rig)}{STEP}
    def sample(self) -> None:
        """Commutate once."""
        geometry = self.geometry
        platform = self.platform
        tilts = self.tilts
{each((*horizontal, *motors), "        {0} = self.{0}")}
        tilts.clear()
{each(motors, ADD_GAP)}
{displacements(rig, "tilts.roll", "tilts.pitch")}
{chr(10).join(f"        {motor.name}.commutate(self.current_limit, geometry.electrical_angle(along_{motor.drives}))" for motor in rig.motors)}
        self.saturated = {each(motors, "{0}.saturated", " or ")}
''')
