"""The block of a stage whose platform tilts, written from its description."""

from maglev.rig.stage import axis_lines, stepping
from maglev.rig.text import commented, constants, each, geometry, module, thrust_constant, times, vertical_constants
from pmlsm.rig import Rig, RigMotor, Stop


def tilting_stage(rig: Rig) -> str:
    """Text of `plant_fmu/stage_NAME.py`."""
    vertical, (along_x, along_z), (about_x, about_z) = rig.vertical.name, rig.horizontal, rig.rotations
    x, z, roll, pitch = along_x.name, along_z.name, about_x.name, about_z.name
    axes, motors, stop = rig.axis_names, rig.motor_names, rig.motor_stop
    assert stop is not None, "of a platform that tilts"
    stopped = [axis.name for axis in rig.axes if axis.stop is not None]
    statuses = [*(f"{name.upper()}_BEYOND_STOP" for name in (*stopped, *motors)), "RUN_AWAY", "STEP_TOO_LONG",
                "NO_SUCH_MOTOR"]
    attraction, coils, iron = vertical_constants(rig)
    axis_locals, mount_locals = each(axes, "        {0} = self.{0}"), each(motors, "        {0}_mount = self.{0}_mount")
    locals_ = "\n".join([axis_locals, each(motors, "        {0} = self.{0}"), mount_locals])
    thrusts = {axis: " + ".join(f"{motor.name}_mount.thrust" for motor in rig.motors_of(axis)) for axis in (x, z)}
    forces = [(f"{name} = {times(rig.sharing, f'self.{axis}.nominal_mass')} * self.{constant}", unit)
              for name, axis, constant, unit in (
                  (f"{x}_thrust", x, thrust_constant(rig, x), "N/A"), (f"{z}_thrust", z, thrust_constant(rig, z), "N/A"),
                  ("attraction", vertical, attraction, "N/T²"), ("coils", vertical, coils, "N/(A T)"),
                  ("iron", vertical, iron, "N/A²"))]
    yaw = (each([motor.name for motor in rig.motors_of(x)], "{0}_mount.z * {0}_mount.thrust", " + ")
           + each([motor.name for motor in rig.motors_of(z)], " - {0}_mount.x * {0}_mount.thrust", ""))
    begun = f'''        {vertical}.payload = payload.mass
        {x}.payload = payload.mass
        {z}.payload = payload.mass
        {roll}.payload = payload.roll_inertia()
        {pitch}.payload = payload.pitch_inertia()
{each(axes, "        {0}.begin()")}
{each(motors, "        {0}_mount.begin()")}'''
    return module(f'''
"""The {rig.title}: {", ".join(motors)} carry the platform, drive it along {x} and {z}, and tilt it."""

from plant_fmu.axis import Axis
from plant_fmu.encoder import Encoder
from plant_fmu.integration import LONGEST_COMMUNICATION_STEP, integration_steps
from plant_fmu.motor_mount import MotorMount
from plant_fmu.motor_supply import MotorSupply
from plant_fmu.payload import Payload
from plant_fmu.tilt_guide import TiltGuide
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.velocity_rows import GRAVITY

LONGEST_STEP = {rig.longest_step!r}   # s; docs/accuracy.md has the study behind it

STARTED = 0   # status of `start` and `step`
{chr(10).join(f"{status} = {k}" for k, status in enumerate(statuses, 1))}


class Stage{rig.suffix}:
    """Motion of the {rig.title} with friction, bias, ripple, stops, a payload, amplifiers and encoders.

    Each motor pulls and drives at its own place, with its own air gap and displacement. The platform tilts by small
    angles: {roll} about {x}, {pitch} about {z}.
    """

    def __init__(self) -> None:
{commented([*constants(rig, "stage"), (f"self.attraction_modulation = {rig.modulation!r}", "parameter"),
            (f"self.height = {rig.height!r}", "m, parameter: of the magnets' faces against the centre of mass, downwards"),
            *geometry(rig)])}
{chr(10).join(axis_lines(axis) for axis in rig.axes)}
{each((roll, pitch), "        self.{0}_guide = TiltGuide()")}
        self.payload = Payload()
{chr(10).join(f"        self.{m.name} = MotorSupply({m.amplifier.peak!r}, {m.amplifier.continuous!r})" for m in rig.motors)}
{chr(10).join(f"        self.{m.name}_mount = {mount(m, stop)}" for m in rig.motors)}
        self.encoder = Encoder({rig.resolution!r})
        self.yaw_moment = 0.0   # N m, output: about {vertical}, of the motors; the guides hold it
        self.at_stop = False    # output

    def start(self) -> int:
        """Place the platform at its start position; the status says which axis or motor is beyond a stop."""
        if not self.geometry.prepare():
            return NO_SUCH_MOTOR
{chr(10).join(started(axis, axis in stopped) for axis in axes)}
        self.place_motors()
{chr(10).join(f"        if self.{motor}_mount.beyond_stop():{chr(10)}            return {motor.upper()}_BEYOND_STOP" for motor in motors)}
        self.measure()
        return STARTED

{stepping(motors, {motor: f"{motor}_mount.displacement" for motor in motors}, locals_ + chr(10) + "        payload = self.payload", begun,
          each(axes, "{0}.finish()", " and ") + chr(10) + "        self.place_motors()", "        self.push_motors()" + chr(10))}
    def add_slope(self, weight: float, ahead: float) -> None:
        """Add one Runge–Kutta slope on all axes, and go to the next point."""
        self.push_motors()
{axis_locals}
{mount_locals}
        payload = self.payload
        height = self.height
        normal = {each(motors, "{0}_mount.normal", " + ")}
        {x}_thrust = {thrusts[x]}
        {z}_thrust = {thrusts[z]}
        {roll}_torque = (height * {z}_thrust{plus(roll)}{each(motors, "{0}_mount.roll_torque()", plus(roll))} + payload.roll_torque() + self.{roll}_guide.torque({roll}.position))
        {pitch}_torque = (-height * {x}_thrust{plus(pitch)}{each(motors, "{0}_mount.pitch_torque()", plus(pitch))} + payload.pitch_torque() + self.{pitch}_guide.torque({pitch}.position))
        {vertical}.add_slope(GRAVITY + normal / {vertical}.present_mass, weight, ahead)
        {x}.add_slope({x}_thrust / {x}.present_mass, weight, ahead)
        {z}.add_slope({z}_thrust / {z}.present_mass, weight, ahead)
        {roll}.add_slope({roll}_torque / {roll}.present_mass, weight, ahead)
        {pitch}.add_slope({pitch}_torque / {pitch}.present_mass, weight, ahead)
        self.place_motors()

    def push_motors(self) -> None:
        """Compute the forces of all motors at the present point; the constants are accelerations at nominal masses."""
        geometry = self.geometry
        modulation = self.attraction_modulation
{commented(forces)}
{each(motors, "        {0} = self.{0}")}
{chr(10).join(f"        self.{m.name}_mount.push(geometry, {m.name}.i_d, {m.name}.i_q, {m.drives}_thrust, attraction, coils, iron, modulation)" for m in rig.motors)}

    def place_motors(self) -> None:
        """Put the motors where the platform has them."""
        {vertical} = self.{vertical}
        {roll} = self.{roll}
        {pitch} = self.{pitch}
        along_{x} = self.{x}.position - self.height * {pitch}.position
        along_{z} = self.{z}.position + self.height * {roll}.position
{chr(10).join(f"        self.{m.name}_mount.place({vertical}, {roll}, {pitch}, along_{m.drives})" for m in rig.motors)}

    def time_to_stop(self, dt: float) -> float:
        """Time (s) in which the first axis or motor meets an end stop; dt if none does within dt."""
        {vertical} = self.{vertical}
        {roll} = self.{roll}
        {pitch} = self.{pitch}
{each(stopped, "        dt = self.{0}.time_to_stop(dt)")}
{each(motors[:-1], "        dt = self.{0}_mount.time_to_stop(" + f"{vertical}, {roll}, {pitch}, dt)")}
        return self.{motors[-1]}_mount.time_to_stop({vertical}, {roll}, {pitch}, dt)

    def beyond_stop(self) -> bool:
        """Whether any axis or motor is beyond an end stop."""
        return ({each([*stopped, *(f"{motor}_mount" for motor in motors)], "self.{0}.beyond_stop()", " or ")})

    def measure(self) -> None:
        """Set the outputs of the encoders, and the yaw moment."""
{each((x, z), "        self.{0}.encoder = self.encoder.measure(self.{0}.position)")}
{mount_locals}
{each(motors, "        {0}_mount.gap_encoder = self.encoder.measure({0}_mount.gap)")}
        self.yaw_moment = ({yaw})
''')


def plus(tilt: str) -> str:
    """Between the terms of a torque, which are in lines of their own."""
    return " + "


def mount(motor: RigMotor, stop: Stop) -> str:
    """A motor at its place."""
    values = motor.x, motor.z, stop.lower, stop.upper, stop.stiffness, stop.damping
    return f"MotorMount({', '.join(map(repr, values))})"


def started(axis: str, stopped: bool) -> str:
    """Start of an axis, which may be beyond its stop, if it has one."""
    if not stopped:
        return f"        self.{axis}.start()"
    return f"        if not self.{axis}.start():\n            return {axis.upper()}_BEYOND_STOP"
