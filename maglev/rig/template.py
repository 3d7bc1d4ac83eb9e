"""The controller that a user begins with, written from the description of a rig."""

from maglev.rig.text import each, geometry, module, times, vertical_constants
from pmlsm.rig import Rig


def template(rig: Rig, name: str, file: str) -> str:
    """Text of a controller of a rig: a class of a name, in a file."""
    vertical = rig.vertical.name
    axes, horizontal = rig.axes, [axis.name for axis in rig.horizontal]
    values = {each_constant.name: repr(each_constant.model) for each_constant in rig.constants}
    attraction, coils, iron = (times(rig.carrying, values[each_name]) for each_name in vertical_constants(rig))
    thrusts = {axis: times(rig.sharing * len(rig.motors_of(axis)), values[rig.constants_of(axis)[0]])
               for axis in horizontal}
    squares = " + ".join(f"i_q_{motor.drives} * i_q_{motor.drives}" for motor in rig.motors)
    ports = ('"{0}.reference": "m", "{0}.reference_rate": "m/s", "{0}.measured": "m"')
    outputs = [f'"{motor}.i_{what}_cmd": "A"' for motor in rig.motor_names for what in "abcdq"]
    first = {axis: rig.motors_of(axis)[0].name for axis in horizontal}
    return module(f'''
"""Controller of the {rig.title}: state feedback with an integral on each axis.

    maglev run {rig.name}-setpoints --controller {file} --set controller.{vertical}.bandwidth={rig.vertical.design.bandwidth:g}
    maglev build {file}                   # the same as an FMU; with --native one that needs no Python

Everything from `Axis` on is yours to change. What has to stay: the tables, and a `step` that gives the phase currents.
"""

from controller_fmu.feedback_linearisation import demanded_current
from controller_fmu.motor_command import MotorCommand
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry

# The motor model: accelerations of the stage by all motors of an axis (docs/model.md).
{chr(10).join(f"THRUST_{axis.upper()} = {value}   # m/(s² A), along {axis} by a quadrature current" for axis, value in thrusts.items())}
ATTRACTION = {attraction}   # m/(s² T²), magnets on iron
COILS = {coils}   # m/(s² A T), magnets on coils: the direct current
IRON = {iron}   # m/(s² A²), coils on iron


class Axis:
    """One axis: from reference and measurement to the acceleration that is asked for."""

    def __init__(self, position: float, bandwidth: float):
        self.reference = position       # m, input
        self.reference_rate = 0.0       # m/s, input
        self.measured = position        # m, input
        self.bandwidth = bandwidth      # rad/s, parameter: three poles lie there
        self.velocity = VelocityObserver()
        self.integral = 0.0             # m s, state

    def demand(self, observer: ObserverFilter, dt: float) -> float:
        """Acceleration (m/s²) by which the error has its poles at (s + w)(s² + 1.8 w s + w²)."""
        self.velocity.update(self.measured, observer, dt)
        error = self.measured - self.reference
        rate = self.velocity.velocity - self.reference_rate
        w = self.bandwidth
        return -2.8 * w * rate - 2.8 * w * w * error - w * w * w * self.integral

    def integrate(self, dt: float, limited: bool) -> None:
        """Take the error into the integral, but not while the current is at its limit (antiwindup)."""
        if not limited:
            self.integral += dt * (self.measured - self.reference)


class {name}:
    """State feedback with an integral on each axis, on the feedback-linearised motors of the {rig.title}."""

    # Ports and parameters, and their units. "{vertical}.measured" is self.{vertical}.measured, or self.{vertical}_measured if \
you have no self.{vertical}.
    inputs = {{{each(rig.axis_names, ports.replace("{", "{{").replace("}", "}}").replace("{{0}}", "{0}"), "," + chr(10) + "              ")}}}   # {vertical} is the air gap: larger is lower
    outputs = {{{listed(outputs, 15)}}}
    parameters = {{{each(rig.axis_names, '"{0}.bandwidth": "rad/s"', ", ")}, "limit": "A"}}

    def __init__(self) -> None:
        self.sample_time = {rig.sample_time!r}       # s: step is called this often
        self.limit = 4.0                # A, parameter: of i_d and i_q
{chr(10).join(f"        self.{axis.name} = Axis({axis.start!r}, {axis.design.bandwidth!r})" for axis in axes)}
        self.observer = ObserverFilter()
{chr(10).join(f"        {line}" for line, _ in geometry(rig))}
{each(rig.motor_names, "        self.{0} = MotorCommand()")}   # limits, commutates, and holds the outputs
        self.started = False

    def start(self) -> None:
        """Compute what follows from the parameters, when all are set."""
        self.geometry.prepare()
        self.observer.prepare(self.sample_time)

    def step(self, t: float) -> None:
        """Read the inputs, set the outputs; t is the time (s)."""
{each(rig.axis_names, "        {0} = self.{0}")}
        if not self.started:
            if {vertical}.measured <= 0.0:
                return          # in another tool: nothing has been measured yet
{each(rig.axis_names, "            {0}.velocity.seed({0}.measured)")}
            self.started = True
        f1, f2, f3, f4 = gap_functions(self.geometry, {vertical}.measured)
{chr(10).join(f"        i_q_{axis} = -{axis}.demand(self.observer, self.sample_time) / (THRUST_{axis.upper()} * f1)" for axis in horizontal)}
        by_quadrature = {1.0 / len(rig.motors)!r} * IRON * f4 * ({squares})
        i_d, feasible = demanded_current({vertical}.demand(self.observer, self.sample_time), by_quadrature, ATTRACTION, COILS,
                                         IRON, f2, f3, f4)
{chr(10).join(f"        self.{m.name}.command(i_d, i_q_{m.drives}, self.limit, self.geometry.electrical_angle({m.drives}.measured))" for m in rig.motors)}
        {vertical}.integrate(self.sample_time, self.{rig.motors[0].name}.excess_d != 0.0)
{chr(10).join(f"        {axis}.integrate(self.sample_time, self.{motor}.excess_q != 0.0)" for axis, motor in first.items())}
''')


def listed(items: list[str], indent: int) -> str:
    """Items with commas, in lines of a width."""
    lines = [""]
    for item in items:
        if len(lines[-1]) + len(item) > 100 - indent:
            lines.append("")
        lines[-1] += f"{item}, "
    return ("\n" + " " * indent).join(line.rstrip() for line in lines).removesuffix(",")
