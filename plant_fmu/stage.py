"""The stage: motors carry a mover, drive it along horizontal axes, and may tilt it."""

from plant_fmu.assembly import axis_of, supplies_of
from plant_fmu.encoder import Encoder
from plant_fmu.integration import LONGEST_COMMUNICATION_STEP, integration_steps
from plant_fmu.level_mover import LevelMover
from plant_fmu.magnetics import Magnetics
from plant_fmu.motor_supply import END, MIDDLE, START
from plant_fmu.tilting_mover import TiltingMover
from pmlsm.stage_description import StageDescription

DONE = 0            # status of all methods; from 1 on the number of the stop that the mover is beyond
RUN_AWAY = 1        # these are counted after the stops
STEP_TOO_LONG = 2
NO_SUCH_MOTOR = 3
NO_SEED = 4


class Stage:
    """Motion of a stage with guides, bias, stops, amplifiers and encoders, from its description.

    Its axes are the air gap g, then the displacements along the horizontal axes, then the tilts of the platform, if it
    tilts. Each moves with its own mass (or inertia) m under gravity G, which acts on the gap alone,

        m q'' = m G + Σ F_motor + F_guide + F_stop + F_external + m (bias − floor),

    and motors follow (4.3) and (5.3), with the shape functions f1 … f4 at their air gap:

        thrust          T = −C_thrust f1 i_q
        normal force    N = −C_iron f4 (i_q² + i_d²) + C_coils f3 i_d − C_attraction f2.

    `Axis` has the forces on one axis and its share of the integration; `MotorSupply` has the currents; `Magnetics` has
    the constants and the electrical angles. `LevelMover` and `TiltingMover` add up the forces of the motors.
    The integration is Runge–Kutta of the fourth order. A step that meets an end stop is divided there.
    """

    def __init__(self, stage: StageDescription):
        described = stage.ordered_axes
        self.axes = [axis_of(axis) for axis in described]
        self.motors = supplies_of(stage)
        self.magnetics = Magnetics(stage)
        self.mover = TiltingMover(stage) if stage.rotations else LevelMover(stage)
        self.encoder = Encoder(stage.resolution)
        self.bus_voltage = 0.0                     # V, parameter: of the amplifiers' supply, 0 = any that is needed
        self.guide_seed = stage.guide_seed         # parameter: a whole number
        self.longest_step = stage.longest_step       # s, of an integration; docs/accuracy.md has the study behind it
        # Numbers of the axes that have an encoder, and of those that have stops; places of all in the description.
        self.measured = [k for k, axis in enumerate(described) if axis in stage.measured]
        self.stopped = [k for k, axis in enumerate(described) if axis.stop is not None]
        self.track_numbers = [stage.axes.index(axis) for axis in described]
        self.stops = len(self.stopped) + len(self.mover.mounts)   # of axes, then of motors
        self.at_stop = False                       # output

    def start(self) -> int:
        """Place the mover at its start position; the status says which axis or motor is beyond a stop."""
        if not self.magnetics.prepare():
            return self.stops + NO_SUCH_MOTOR
        seed = int(self.guide_seed)
        if seed != self.guide_seed:
            return self.stops + NO_SEED
        for axis, track in zip(self.axes, self.track_numbers, strict=True):
            axis.start(seed, track)
        self.mover.start()
        self.place_motors()
        for k, number in enumerate(self.stopped):
            if self.axes[number].beyond_stop():
                return 1 + k
        beyond = self.mover.first_beyond()
        if beyond > 0:
            return len(self.stopped) + beyond
        self.measure()
        return DONE

    def step(self, t: float, dt: float) -> int:
        """Move from t to t + dt (s) with the inputs held."""
        if dt > LONGEST_COMMUNICATION_STEP:
            return self.stops + STEP_TOO_LONG
        steps = integration_steps(dt, self.longest_step)
        part = dt / steps
        self.at_stop = self.beyond_stop()
        for _ in range(steps):
            meeting = self.time_to_stop(part)
            contained = self.integrate(meeting)
            if contained and meeting < part:
                contained = self.integrate(part - meeting)
            if not contained:
                return self.stops + RUN_AWAY
        self.turn_currents(END)
        for motor in self.motors:
            motor.deliver()
        self.mover.deliver(self.axes, self.motors, self.magnetics)
        self.measure()
        return DONE

    def integrate(self, dt: float) -> bool:
        """Move over one integration step dt (s); False where the mover has run away."""
        if self.bus_voltage > 0.0:
            self.mover.induce(self.axes, self.motors, self.magnetics, 0.5 * dt)
        for motor in self.motors:
            motor.advance(dt, self.bus_voltage)
        self.mover.begin(self.axes)
        for axis in self.axes:
            axis.begin()
        self.turn_currents(START)
        self.add_slope(dt / 6.0, dt / 2.0)
        self.turn_currents(MIDDLE)
        self.add_slope(dt / 3.0, dt / 2.0)
        self.turn_currents(MIDDLE)
        self.add_slope(dt / 3.0, dt)
        self.turn_currents(END)
        self.add_slope(dt / 6.0, 0.0)
        contained = True
        for axis in self.axes:
            if contained:
                contained = axis.finish()
        self.place_motors()
        if self.beyond_stop():
            self.at_stop = True
        return contained

    def turn_currents(self, point: int) -> None:
        """Set the currents to START, MIDDLE or END of an integration step, at the angles where the mover is."""
        kinds = self.magnetics.kinds
        groups = self.magnetics.groups
        for group in groups:
            group.angle.follow(kinds[group.kind].geometry, self.mover.displacements[group.axis])
        for motor in self.motors:
            motor.turn(point, groups[motor.group].angle)

    def add_slope(self, weight: float, ahead: float) -> None:
        """Add one Runge–Kutta slope on all axes, and go to the next point; arguments as of `Axis.add_slope`."""
        mover = self.mover
        mover.push(self.axes, self.motors, self.magnetics)
        for k, axis in enumerate(self.axes):
            axis.add_slope(mover.accelerations[k], weight, ahead)
        self.place_motors()

    def place_motors(self) -> None:
        """Put the motors where the mover has them. Linear models ask for this by its name."""
        self.mover.place(self.axes)

    def derive(self) -> int:
        """Compute the rates of the states at the present point of a continuous model, and all that is continuous."""
        magnetics = self.magnetics
        mover = self.mover
        self.place_motors()
        mover.resume(self.axes)
        for axis in self.axes:
            axis.resume()
        for group in magnetics.groups:
            group.angle.turn(magnetics.kinds[group.kind].geometry, mover.displacements[group.axis])
        for motor in self.motors:
            motor.resume(magnetics.groups[motor.group].angle)
        if self.bus_voltage > 0.0:
            mover.induce(self.axes, self.motors, magnetics, 0.0)
        for motor in self.motors:
            motor.derive(self.bus_voltage)
        self.add_slope(1.0, 0.0)
        mover.report()
        for axis in self.axes:
            if not axis.contained():
                return self.stops + RUN_AWAY
        return DONE

    def settle(self) -> bool:
        """Take in an event of a continuous model: stops, clamps, first currents, encoders.

        Return True if a current jumps.
        """
        self.derive()
        self.at_stop = self.mover.settle()
        for number in self.stopped:
            if self.axes[number].settle():
                self.at_stop = True
        self.measure()
        jumps = False
        for motor in self.motors:
            if motor.settle():
                jumps = True
        return jumps

    def time_to_stop(self, dt: float) -> float:
        """Time (s) in which the first axis or motor meets an end stop; dt if none does within dt."""
        for number in self.stopped:
            dt = self.axes[number].time_to_stop(dt)
        return self.mover.time_to_stop(self.axes, dt)

    def beyond_stop(self) -> bool:
        """Return True if any axis or motor is beyond an end stop."""
        for number in self.stopped:
            if self.axes[number].beyond_stop():
                return True
        return self.mover.first_beyond() > 0

    def measure(self) -> None:
        """Set the outputs of the encoders, and the yaw moment of a mover that tilts."""
        for number in self.measured:
            axis = self.axes[number]
            axis.encoder = self.encoder.measure(axis.position + axis.swing)
        self.mover.measure(self.axes, self.encoder)
