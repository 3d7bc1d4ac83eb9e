"""The block of the estimator of a stage, written from its description."""

from maglev.rig.controllers import STEP
from maglev.rig.text import commented, each, geometry, module, thrust_constant, unit_words, vertical_constants
from maglev.rig.tilting.controllers import NO_MEASUREMENT, measure, platform, prepare_platform, unmeasured
from pmlsm.rig import Rig

TILTING_IMPORTS = """\
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
"""


def columns(rig: Rig) -> str:
    """Lines that compute the columns of A(y, u), all motors at one gap."""
    motors, vertical = rig.motor_names, rig.vertical.name
    direct = " + ".join(f"{motor}.i_d" for motor in motors)
    squares = " + ".join(f"{motor}.i_q * {motor}.i_q + {motor}.i_d * {motor}.i_d" for motor in motors)
    thrusts = "\n".join(
        f"        thrust_{axis.name} = thrust_acceleration({rig.sharing!r}, f1, "
        f"{' + '.join(f'{motor.name}.i_q' for motor in rig.motors_of(axis.name))})" for axis in rig.horizontal)
    return f'''        if {vertical}.measured <= 0.0:
            {NO_MEASUREMENT}
        f1, f2, f3, f4 = gap_functions(self.geometry, {vertical}.measured)
{thrusts}
        attraction, coils, iron = normal_terms(
            {rig.carrying!r}, {rig.sharing!r}, {rig.sharing!r}, f2, f3, f4,
            {direct},
            {squares})'''


def tilting_columns(rig: Rig) -> str:
    """Lines that compute the columns of A(y, u), each motor at its own gap."""
    added = {axis.name: [f"rows.add(self.geometry, {motor.name}_place.gap_measured, {motor.name})"
                         for motor in rig.motors_of(axis.name)] for axis in rig.horizontal}
    thrusts = "\n".join(f"        thrust_{axis} = ({(chr(10) + ' ' * 20 + '+ ').join(parts)})"
                        if len(parts) > 1 else f"        thrust_{axis} = {parts[0]}" for axis, parts in added.items())
    return f'''{each(rig.motor_names, "        {0}_place = self.{0}_place")}
        if ({unmeasured(rig, 16)}):
            {NO_MEASUREMENT}
        self.measure()
        rows = self.rows
        rows.clear()
{thrusts}
        attraction = rows.attraction
        coils = rows.coils
        iron = rows.iron'''


def estimator(rig: Rig) -> str:
    """Text of `estimator_fmu/estimator_NAME.py`."""
    vertical = rig.vertical.name
    motors, horizontal = rig.motor_names, [axis.name for axis in rig.horizontal]
    axes = [vertical, *horizontal]
    tilting = bool(rig.rotations)
    names = [constant.name for constant in rig.constants]
    terms = ("attraction", "coils", "iron")
    rows = vertical_constants(rig)
    step = STEP.replace("the commands hold", "the estimates hold")
    return module(f'''
"""Estimator of the constants of the {rig.title} while it moves (sections 3.1.3, 4.3, 5.3)."""

{"from controller_fmu.motor_place import MotorPlace" + chr(10) if tilting else ""}\
from controller_fmu.sample_clock import SampleClock
{TILTING_IMPORTS if tilting else ""}\
from controller_fmu.velocity_observer import ObserverFilter
from estimator_fmu.constant_estimate import ConvergenceRule
from estimator_fmu.estimated_axis import NormalAxis, ThrustAxis
from estimator_fmu.motor_current import MotorCurrent
{"from estimator_fmu.motor_rows import MotorRows" + chr(10) if tilting else ""}\
from estimator_fmu.velocity_model import EstimatorLaw
{"" if tilting else "from pmlsm.gap_functions import gap_functions" + chr(10)}\
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.velocity_rows import {"GRAVITY" if tilting else "GRAVITY, normal_terms, thrust_acceleration"}

STEPPED = 0        # status of `start` and `step`
STEP_MISFIT = 1    # the communication step does not fit the sample time
BAD_GEOMETRY = 2   # no motor has such a geometry
{"BAD_PLACES = 3     # the motors stand on one line, and do not feel every tilt" + chr(10) if tilting else ""}\


class Estimator{rig.suffix}:
    """Samples positions and delivered currents, estimates {names[0]} to {names[-1]} by the reduced NPFSI estimator (3.8)."""

    def __init__(self) -> None:
{commented([*((f"self.{c.name}_start = {c.guess!r}", f"{unit_words(c.unit)}, parameter: guess of {c.name}") for c in rig.constants),
            *((f"self.{c.name}_weight = {c.weight!r}", "parameter: diagonal of Q0") for c in rig.constants),
            ("self.epsilon = 0.01", "s, parameter"), ("self.gamma = 1.1", "parameter"),
            ("self.forgetting = 0.0", "1/s, parameter, 0 = off"), ("self.matched_filter = False", "parameter"),
            (f"self.sample_time = {rig.sample_time!r}", "s, parameter"), *geometry(rig)])}
        self.{vertical} = NormalAxis({rig.vertical.start!r})
{each(horizontal, "        self.{0} = ThrustAxis()")}
{each(motors, "        self.{0} = MotorCurrent()")}
{platform(rig) + chr(10) + f"        self.rows = MotorRows({rig.sharing!r})" + chr(10) if tilting else ""}\
        self.observer = ObserverFilter()
        self.convergence = ConvergenceRule()
        self.law = EstimatorLaw()
        self.clock = SampleClock()
        self.started = False         # state: a measurement has come in
{chr(10).join(f"        self.{c.name} = {c.guess!r}   # {unit_words(c.unit)}, output" for c in rig.constants)}
{each(names, "        self.{0}_converged = False    # output")}

    def start(self) -> int:
        """Begin with the start values and their weights."""
        if not self.geometry.prepare():
            return BAD_GEOMETRY
{"        if not self.prepare_platform():" + chr(10) + "            return BAD_PLACES" + chr(10) if tilting else ""}\
        self.observer.prepare(self.sample_time)
{chr(10).join(f"        self.{axis}.begin(self.{thrust_constant(rig, axis)}_start, self.{thrust_constant(rig, axis)}_weight)" for axis in horizontal)}
        self.{vertical}.begin({each(rows, "self.{0}_start", ", ")}, {each(rows, "self.{0}_weight", ", ")})
        self.publish()
        return STEPPED
{prepare_platform(rig) if tilting else ""}\
{step}
    def sample(self) -> None:
        """Take in a sample: the rows of A(y, u), then one step of the estimator on each."""
{each((*axes, *motors), "        {0} = self.{0}")}
{tilting_columns(rig) if tilting else columns(rig)}
        if not self.started:
            self.started = True
            {vertical}.seed(attraction, coils, iron)
{each(horizontal, "            {0}.seed(thrust_{0})")}
        law = self.law
        law.prepare(self.sample_time, self.epsilon, self.gamma, self.forgetting)
        {vertical}.sample(attraction, coils, iron, GRAVITY, self.matched_filter, self.observer, law)
{each(horizontal, "        {0}.sample(thrust_{0}, self.matched_filter, self.observer, law)")}
{each(axes, "        {0}.watch(self.convergence, self.sample_time)")}
        self.publish()
{measure(rig, tilts=False) if tilting else ""}
    def publish(self) -> None:
        """Set the outputs."""
{each(axes, "        {0} = self.{0}")}
{chr(10).join(f"        self.{thrust_constant(rig, axis)} = {axis}.thrust" for axis in horizontal)}
{chr(10).join(f"        self.{name} = {vertical}.{term}" for name, term in zip(rows, terms, strict=True))}
{chr(10).join(f"        self.{thrust_constant(rig, axis)}_converged = {axis}.converged" for axis in horizontal)}
{chr(10).join(f"        self.{name}_converged = {vertical}.converged{k}" for k, name in enumerate(rows, 1))}
''')
