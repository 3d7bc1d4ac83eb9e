"""The block of a stage, written from its description."""

from collections.abc import Mapping, Sequence

from maglev.rig.text import commented, constants, each, geometry, module, thrust_constant, times, vertical_constants
from pmlsm.rig import Rig, RigAxis, Ripple, Stop

NO_STOP = Stop(-10.0, 10.0, 0.0, 0.0)   # of an axis whose stops are at the motors


def stage(rig: Rig) -> str:
    """Text of `plant_fmu/stage_NAME.py`."""
    vertical, first = rig.vertical.name, rig.horizontal[0].name
    axes, motors = rig.axis_names, rig.motor_names
    carried = "one motor carries" if len(motors) == 1 else f"{', '.join(motors)} carry"
    statuses = [f"{axis.upper()}_BEYOND_STOP" for axis in axes] + ["RUN_AWAY", "STEP_TOO_LONG", "NO_SUCH_MOTOR"]
    locals_ = each((*axes, *motors), "        {0} = self.{0}")
    attraction, coils, iron = vertical_constants(rig)
    direct = " + ".join(f"{motor}.i_d" for motor in motors)
    squares = " + ".join(f"{motor}.i_q * {motor}.i_q + {motor}.i_d * {motor}.i_d" for motor in motors)
    places = {motor.name: f"{motor.drives}.position" for motor in rig.motors}
    horizontal = [axis.name for axis in rig.horizontal]
    thrusts = {axis: " + ".join(f"{motor.name}.i_q" for motor in rig.motors_of(axis)) for axis in horizontal}
    return module(f'''
"""The {rig.title}: {carried} the mover vertically ({vertical}, the air gap) and drive{"s" * (len(motors) == 1)} it \
along {" and ".join(horizontal)}."""

from plant_fmu.attraction import attraction_factor
from plant_fmu.axis import Axis
from plant_fmu.encoder import Encoder
from plant_fmu.integration import LONGEST_COMMUNICATION_STEP, integration_steps
from plant_fmu.motor_supply import MotorSupply
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.velocity_rows import normal_acceleration, thrust_acceleration

LONGEST_STEP = {rig.longest_step!r}   # s; docs/accuracy.md has the study behind it

STARTED = 0   # status of `start` and `step`
{chr(10).join(f"{status} = {k}" for k, status in enumerate(statuses, 1))}


class Stage{rig.suffix}:
    """Motion{f" {rig.equation}" if rig.equation else ""} of the {rig.title} with friction, bias, ripple, stops, amplifiers and encoders."""

    def __init__(self) -> None:
{commented([*constants(rig, "stage"), (f"self.attraction_modulation = {rig.modulation!r}", "parameter"), *geometry(rig)])}
{chr(10).join(axis_lines(axis) for axis in rig.axes)}
{chr(10).join(f"        self.{m.name} = MotorSupply({m.amplifier.peak!r}, {m.amplifier.continuous!r})" for m in rig.motors)}
        self.encoder = Encoder({rig.resolution!r})
        self.at_stop = False   # output

    def start(self) -> int:
        """Place the mover at its start position; the status says which axis is beyond a stop."""
        if not self.geometry.prepare():
            return NO_SUCH_MOTOR
{chr(10).join(f"        if not self.{axis}.start():{chr(10)}            return {axis.upper()}_BEYOND_STOP" for axis in axes)}
        self.measure()
        return STARTED

{stepping(motors, places, locals_, each(axes, "        {0}.begin()"), each(axes, "{0}.finish()", " and "))}
    def add_slope(self, weight: float, ahead: float) -> None:
        """Add one Runge–Kutta slope on all axes{f" {rig.equation}" if rig.equation else ""}."""
{locals_}
        f1, f2, f3, f4 = gap_functions(self.geometry, {vertical}.position)
        f2 *= attraction_factor(self.attraction_modulation, {first}.position, self.geometry.slot_pitch)
        share = {vertical}.mass_ratio
        {vertical}_motors = normal_acceleration(
            {times(rig.carrying, "share")} * self.{attraction}, {times(rig.sharing, "share")} * self.{coils}, \
{times(rig.sharing, "share")} * self.{iron}, f2, f3, f4,
            {direct},
            {squares})
{chr(10).join(f"        {axis}_motors = thrust_acceleration({times(rig.sharing, f'{axis}.mass_ratio')} * self.{thrust_constant(rig, axis)}, f1, {current})" for axis, current in thrusts.items())}
{each(axes, "        {0}.add_slope({0}_motors, weight, ahead)")}

    def time_to_stop(self, dt: float) -> float:
        """Time (s) in which the first axis meets an end stop; dt if none does within dt."""
{each(axes[:-1], "        dt = self.{0}.time_to_stop(dt)")}
        return self.{axes[-1]}.time_to_stop(dt)

    def beyond_stop(self) -> bool:
        """Whether any axis is beyond an end stop."""
        return {each(axes, "self.{0}.beyond_stop()", " or ")}

    def measure(self) -> None:
        """Set the encoder outputs."""
{each(axes, "        self.{0}.encoder = self.encoder.measure(self.{0}.position)")}
''')


def stepping(motors: Sequence[str], places: Mapping[str, str], locals_: str, begun: str, finished: str,
             delivered: str = "") -> str:
    """Methods `step` and `integrate` of a stage.

    Parameters
    ----------
    motors : sequence of str
    places : mapping of str to str
        Displacement that each motor commutates with.
    locals_, begun : str
        Lines that name the parts in `integrate`, and that begin an integration step.
    finished : str
        Whether the mover is still within bounds, after what ends an integration step.
    delivered : str
        Lines at the end of a communication step, when the currents have been delivered.
    """
    def angles(when: str) -> str:
        return "\n".join(f"        {motor}.{when}(geometry.electrical_angle({place}))"
                         for motor, place in places.items())

    return f'''    def step(self, t: float, dt: float) -> int:
        """Move from t to t + dt (s) with the inputs held."""
        if dt > LONGEST_COMMUNICATION_STEP:
            return STEP_TOO_LONG
        steps = integration_steps(dt, LONGEST_STEP)
        part = dt / steps
        self.at_stop = self.beyond_stop()
        for _ in range(steps):
            meeting = self.time_to_stop(part)
            contained = self.integrate(meeting)
            if contained and meeting < part:
                contained = self.integrate(part - meeting)
            if not contained:
                return RUN_AWAY
        geometry = self.geometry
{chr(10).join(f"        self.{motor}.deliver(geometry.electrical_angle(self.{place}))" for motor, place in places.items())}
{delivered}        self.measure()
        return STARTED

    def integrate(self, dt: float) -> bool:
        """Move over one integration step dt (s); False where the mover has run away."""
        geometry = self.geometry
{locals_}
{each(motors, "        {0}.advance(dt)")}
{begun}
{angles("at_start")}
        self.add_slope(dt / 6.0, dt / 2.0)
{angles("at_middle")}
        self.add_slope(dt / 3.0, dt / 2.0)
{angles("at_middle")}
        self.add_slope(dt / 3.0, dt)
{angles("at_end")}
        self.add_slope(dt / 6.0, 0.0)
        contained = {finished}
        if self.beyond_stop():
            self.at_stop = True
        return contained
'''


def axis_lines(axis: RigAxis) -> str:
    """An axis with what its constructor does not take."""
    stop = axis.stop or NO_STOP
    lines = [f"self.{axis.name} = Axis({axis.mass!r}, {axis.bias!r}, {axis.friction.coulomb!r}, "
             f"{axis.friction.presliding!r}, {axis.friction.viscous!r}, {stop.lower!r}, {stop.upper!r}, "
             f"{axis.start!r})"]
    for part, values, default in (("ripple", axis.ripple, Ripple()),
                                  ("stop", stop, Stop(stop.lower, stop.upper))):
        lines += [f"self.{axis.name}.{part}.{name} = {value!r}" for name, value in vars(values).items()
                  if value != getattr(default, name)]
    return "\n".join(f"        {line}" for line in lines)
