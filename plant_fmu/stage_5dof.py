"""The 5-DOF stage: alpha1, alpha2, beta1, beta2 carry the platform, drive it along x and z, and tilt it."""

from plant_fmu.attraction import attraction_factor
from plant_fmu.axis import Axis
from plant_fmu.encoder import Encoder
from plant_fmu.integration import LONGEST_COMMUNICATION_STEP, integration_steps
from plant_fmu.magnets import magnet_strength
from plant_fmu.motor_mount import MotorMount
from plant_fmu.motor_supply import MotorSupply
from plant_fmu.payload import Payload
from plant_fmu.tilt_guide import TiltGuide
from pmlsm.electrical_angle import ElectricalAngle
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.velocity_rows import GRAVITY

LONGEST_STEP = 0.0002   # s; docs/accuracy.md has the study behind it

STARTED = 0   # status of `start` and `step`
X_BEYOND_STOP = 1
Z_BEYOND_STOP = 2
ALPHA1_BEYOND_STOP = 3
ALPHA2_BEYOND_STOP = 4
BETA1_BEYOND_STOP = 5
BETA2_BEYOND_STOP = 6
RUN_AWAY = 7
STEP_TOO_LONG = 8
NO_SUCH_MOTOR = 9
NO_SEED = 10


class Stage5DOF:
    """Motion of the 5-DOF stage with guides, bias, stops, a payload, amplifiers and encoders.

    Each motor pulls and drives at its own place, with its own air gap and displacement. The platform tilts by small
    angles: roll about x, pitch about z.
    """

    def __init__(self) -> None:
        self.C1 = 0.6135                     # m/(s² A), parameter: thrust along x
        self.C2 = 0.8224                     # m/(s² A), parameter: thrust along z
        self.C3 = 334.52                     # m/(s² T²), parameter: attraction between magnets and iron
        self.C4 = 8.71                       # m/(s² A T), parameter: normal force between magnets and coils
        self.C5 = 0.0045                     # m/(s² A²), parameter: normal force between coils and iron
        self.attraction_modulation = 0.0135  # parameter
        self.roughness_seed = 1.0            # parameter: a whole number
        self.magnet_rise = 0.0               # K, parameter: how warm the magnets are, above the constants' temperature
        self.bus_voltage = 0.0               # V, parameter: of the amplifiers' supply, 0 = any that is needed
        self.height = -0.03                  # m, parameter: of the magnets' faces against the centre of mass, downwards
        self.geometry = MotorGeometry()
        self.y = Axis(6.9, 0.1, 1.0, 0.0005, 2.0, -10.0, 10.0, 0.025)
        self.y.ripple.amplitude = 0.15
        self.y.stop.stiffness = 0.0
        self.y.stop.damping = 0.0
        self.x = Axis(10.6, 0.05, 1.2, 0.0005, 2.0, -0.062, 0.062, 0.0)
        self.x.ripple.period = 0.01905
        self.z = Axis(8.6, 0.05, 1.1, 0.0005, 2.0, -0.062, 0.062, 0.0)
        self.z.ripple.period = 0.01905
        self.roll = Axis(0.2, 0.0, 0.02, 0.001, 0.02, -10.0, 10.0, 0.0)
        self.roll.stop.stiffness = 0.0
        self.roll.stop.damping = 0.0
        self.pitch = Axis(0.2, 0.0, 0.02, 0.001, 0.02, -10.0, 10.0, 0.0)
        self.pitch.stop.stiffness = 0.0
        self.pitch.stop.damping = 0.0
        self.x_angle = ElectricalAngle()
        self.z_angle = ElectricalAngle()
        self.roll_guide = TiltGuide()
        self.pitch_guide = TiltGuide()
        self.payload = Payload()
        self.alpha1 = MotorSupply(5.0, 4.0, 7.0, 0.07)
        self.alpha2 = MotorSupply(5.0, 4.0, 7.0, 0.07)
        self.beta1 = MotorSupply(5.0, 4.0, 7.0, 0.07)
        self.beta2 = MotorSupply(5.0, 4.0, 7.0, 0.07)
        self.alpha1_mount = MotorMount(0.0, 0.2, 0.0185, 0.032, 100000.0, 375.0)
        self.alpha2_mount = MotorMount(0.0, -0.2, 0.0185, 0.032, 100000.0, 375.0)
        self.beta1_mount = MotorMount(0.2, 0.0, 0.0185, 0.032, 100000.0, 375.0)
        self.beta2_mount = MotorMount(-0.2, 0.0, 0.0185, 0.032, 100000.0, 375.0)
        self.encoder = Encoder(1e-05)
        self.yaw_moment = 0.0   # N m, output: about y, of the motors; the guides hold it
        self.at_stop = False    # output

    def start(self) -> int:
        """Place the platform at its start position; the status says which axis or motor is beyond a stop."""
        if not self.geometry.prepare():
            return NO_SUCH_MOTOR
        seed = int(self.roughness_seed)
        if seed != self.roughness_seed:
            return NO_SEED
        self.y.start(seed, 0)
        if not self.x.start(seed, 1):
            return X_BEYOND_STOP
        if not self.z.start(seed, 2):
            return Z_BEYOND_STOP
        self.roll.start(seed, 3)
        self.pitch.start(seed, 4)
        self.place_motors()
        if self.alpha1_mount.beyond_stop():
            return ALPHA1_BEYOND_STOP
        if self.alpha2_mount.beyond_stop():
            return ALPHA2_BEYOND_STOP
        if self.beta1_mount.beyond_stop():
            return BETA1_BEYOND_STOP
        if self.beta2_mount.beyond_stop():
            return BETA2_BEYOND_STOP
        self.x_angle.forget()
        self.z_angle.forget()
        self.measure()
        return STARTED

    def step(self, t: float, dt: float) -> int:
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
        self.x_angle.turn(geometry, self.alpha1_mount.displacement)
        self.z_angle.turn(geometry, self.beta1_mount.displacement)
        self.alpha1.deliver(self.x_angle)
        self.alpha2.deliver(self.x_angle)
        self.beta1.deliver(self.z_angle)
        self.beta2.deliver(self.z_angle)
        self.push_motors()
        self.measure()
        return STARTED

    def integrate(self, dt: float) -> bool:
        """Move over one integration step dt (s); False where the mover has run away."""
        geometry = self.geometry
        y = self.y
        x = self.x
        z = self.z
        roll = self.roll
        pitch = self.pitch
        alpha1 = self.alpha1
        alpha2 = self.alpha2
        beta1 = self.beta1
        beta2 = self.beta2
        x_angle = self.x_angle
        z_angle = self.z_angle
        payload = self.payload
        bus = self.bus_voltage
        if bus > 0.0:
            self.induce(0.5 * dt)
        alpha1.advance(dt, bus)
        alpha2.advance(dt, bus)
        beta1.advance(dt, bus)
        beta2.advance(dt, bus)
        self.y.payload = payload.mass
        self.x.payload = payload.mass
        self.z.payload = payload.mass
        self.roll.payload = payload.roll_inertia()
        self.pitch.payload = payload.pitch_inertia()
        y.begin()
        x.begin()
        z.begin()
        roll.begin()
        pitch.begin()
        self.alpha1_mount.begin()
        self.alpha2_mount.begin()
        self.beta1_mount.begin()
        self.beta2_mount.begin()
        x_angle.follow(geometry, self.alpha1_mount.displacement)
        z_angle.follow(geometry, self.beta1_mount.displacement)
        alpha1.at_start(x_angle)
        alpha2.at_start(x_angle)
        beta1.at_start(z_angle)
        beta2.at_start(z_angle)
        self.add_slope(dt / 6.0, dt / 2.0)
        x_angle.turn(geometry, self.alpha1_mount.displacement)
        z_angle.turn(geometry, self.beta1_mount.displacement)
        alpha1.at_middle(x_angle)
        alpha2.at_middle(x_angle)
        beta1.at_middle(z_angle)
        beta2.at_middle(z_angle)
        self.add_slope(dt / 3.0, dt / 2.0)
        x_angle.turn(geometry, self.alpha1_mount.displacement)
        z_angle.turn(geometry, self.beta1_mount.displacement)
        alpha1.at_middle(x_angle)
        alpha2.at_middle(x_angle)
        beta1.at_middle(z_angle)
        beta2.at_middle(z_angle)
        self.add_slope(dt / 3.0, dt)
        x_angle.turn(geometry, self.alpha1_mount.displacement)
        z_angle.turn(geometry, self.beta1_mount.displacement)
        alpha1.at_end(x_angle)
        alpha2.at_end(x_angle)
        beta1.at_end(z_angle)
        beta2.at_end(z_angle)
        self.add_slope(dt / 6.0, 0.0)
        contained = y.finish() and x.finish() and z.finish() and roll.finish() and pitch.finish()
        self.place_motors()
        if self.beyond_stop():
            self.at_stop = True
        return contained

    def derive(self) -> int:
        """Compute the rates of the states at the present point of a continuous model, and all that is continuous."""
        geometry = self.geometry
        payload = self.payload
        self.y.payload = payload.mass
        self.x.payload = payload.mass
        self.z.payload = payload.mass
        self.roll.payload = payload.roll_inertia()
        self.pitch.payload = payload.pitch_inertia()
        self.place_motors()
        self.alpha1_mount.resume()
        self.alpha2_mount.resume()
        self.beta1_mount.resume()
        self.beta2_mount.resume()
        self.y.resume()
        self.x.resume()
        self.z.resume()
        self.roll.resume()
        self.pitch.resume()
        self.x_angle.turn(geometry, self.alpha1_mount.displacement)
        self.z_angle.turn(geometry, self.beta1_mount.displacement)
        self.alpha1.resume(self.x_angle)
        self.alpha2.resume(self.x_angle)
        self.beta1.resume(self.z_angle)
        self.beta2.resume(self.z_angle)
        bus = self.bus_voltage
        if bus > 0.0:
            self.induce(0.0)
        self.alpha1.derive(bus)
        self.alpha2.derive(bus)
        self.beta1.derive(bus)
        self.beta2.derive(bus)
        self.add_slope(1.0, 0.0)
        self.yaw_moment = self.moment()
        if (self.y.contained() and self.x.contained() and self.z.contained() and self.roll.contained()
                and self.pitch.contained()):
            return STARTED
        return RUN_AWAY

    def settle(self) -> bool:
        """Take in an event of a continuous model: stops, clamps, first currents, encoders; whether a current jumps."""
        self.derive()
        x_stopped = self.x.settle()
        z_stopped = self.z.settle()
        alpha1_stopped = self.alpha1_mount.settle()
        alpha2_stopped = self.alpha2_mount.settle()
        beta1_stopped = self.beta1_mount.settle()
        beta2_stopped = self.beta2_mount.settle()
        self.at_stop = x_stopped or z_stopped or alpha1_stopped or alpha2_stopped or beta1_stopped or beta2_stopped
        self.measure()
        alpha1_jumps = self.alpha1.settle()
        alpha2_jumps = self.alpha2.settle()
        beta1_jumps = self.beta1.settle()
        beta2_jumps = self.beta2.settle()
        return alpha1_jumps or alpha2_jumps or beta1_jumps or beta2_jumps

    def add_slope(self, weight: float, ahead: float) -> None:
        """Add one Runge–Kutta slope on all axes, and go to the next point."""
        self.push_motors()
        roll = self.roll
        pitch = self.pitch
        alpha1_mount = self.alpha1_mount
        alpha2_mount = self.alpha2_mount
        beta1_mount = self.beta1_mount
        beta2_mount = self.beta2_mount
        normal = alpha1_mount.normal + alpha2_mount.normal + beta1_mount.normal + beta2_mount.normal
        x_thrust = alpha1_mount.thrust + alpha2_mount.thrust
        z_thrust = beta1_mount.thrust + beta2_mount.thrust
        roll_torque = (self.height * z_thrust + alpha1_mount.roll_torque() + alpha2_mount.roll_torque()
                       + beta1_mount.roll_torque() + beta2_mount.roll_torque() + self.payload.roll_torque()
                       + self.roll_guide.torque(roll.position))
        pitch_torque = (-self.height * x_thrust + alpha1_mount.pitch_torque() + alpha2_mount.pitch_torque()
                        + beta1_mount.pitch_torque() + beta2_mount.pitch_torque() + self.payload.pitch_torque()
                        + self.pitch_guide.torque(pitch.position))
        self.y.add_slope(GRAVITY + normal / self.y.present_mass, weight, ahead)
        self.x.add_slope(x_thrust / self.x.present_mass, weight, ahead)
        self.z.add_slope(z_thrust / self.z.present_mass, weight, ahead)
        roll.add_slope(roll_torque / roll.present_mass, weight, ahead)
        pitch.add_slope(pitch_torque / pitch.present_mass, weight, ahead)
        self.place_motors()

    def push_motors(self) -> None:
        """Compute the forces of all motors at the present point; the constants are accelerations at nominal masses."""
        geometry = self.geometry
        modulation = self.attraction_modulation
        strength = magnet_strength(self.magnet_rise)
        x_thrust = self.x.nominal_mass * self.C1 * strength         # N/A
        z_thrust = self.z.nominal_mass * self.C2 * strength         # N/A
        pull = self.y.nominal_mass * self.C3 * strength * strength  # N/T²
        coils = self.y.nominal_mass * self.C4 * strength            # N/(A T)
        iron = self.y.nominal_mass * self.C5                        # N/A²
        x_pull = pull * attraction_factor(modulation, self.alpha1_mount.displacement, geometry.slot_pitch)
        z_pull = pull * attraction_factor(modulation, self.beta1_mount.displacement, geometry.slot_pitch)
        self.alpha1_mount.push(geometry, self.alpha1.i_d, self.alpha1.i_q, x_thrust, x_pull, coils, iron)
        self.alpha2_mount.push(geometry, self.alpha2.i_d, self.alpha2.i_q, x_thrust, x_pull, coils, iron)
        self.beta1_mount.push(geometry, self.beta1.i_d, self.beta1.i_q, z_thrust, z_pull, coils, iron)
        self.beta2_mount.push(geometry, self.beta2.i_d, self.beta2.i_q, z_thrust, z_pull, coils, iron)

    def induce(self, ahead: float) -> None:
        """Compute the voltages that the motion induces in the windings a time ahead (s)."""
        y = self.y
        x = self.x
        z = self.z
        roll = self.roll
        pitch = self.pitch
        height = self.height
        strength = magnet_strength(self.magnet_rise)
        x_thrust = x.nominal_mass * self.C1 * strength  # N/A
        z_thrust = z.nominal_mass * self.C2 * strength  # N/A
        coils = y.nominal_mass * self.C4 * strength     # N/(A T)
        iron = y.nominal_mass * self.C5                 # N/A²
        rate_x = x.velocity - height * pitch.velocity
        rate_z = z.velocity + height * roll.velocity
        change_x = x.acceleration - height * pitch.acceleration
        change_z = z.acceleration + height * roll.acceleration
        self.induce_in(self.alpha1, self.alpha1_mount, self.geometry, ahead, rate_x, change_x, x_thrust, coils, iron)
        self.induce_in(self.alpha2, self.alpha2_mount, self.geometry, ahead, rate_x, change_x, x_thrust, coils, iron)
        self.induce_in(self.beta1, self.beta1_mount, self.geometry, ahead, rate_z, change_z, z_thrust, coils, iron)
        self.induce_in(self.beta2, self.beta2_mount, self.geometry, ahead, rate_z, change_z, z_thrust, coils, iron)

    def induce_in(self, motor: MotorSupply, mount: MotorMount, geometry: MotorGeometry, ahead: float, rate: float,
                  change: float, thrust: float, coils: float, iron: float) -> None:
        """Compute the voltages in the windings of a motor.

        Parameters
        ----------
        motor, mount, geometry : MotorSupply, MotorMount, MotorGeometry
            Of the motor.
        ahead : float
            s.
        rate, change : float
            First and second derivative of its displacement, m/s, m/s².
        thrust, coils, iron : float
            Constants of its rows as forces: N/A, N/(A T), N/A².
        """
        f1, f2, f3, f4 = gap_functions(geometry, mount.gap + ahead * mount.gap_rate)
        motor.induce(geometry.electrical_angle(mount.displacement + ahead * rate),
                     mount.gap_rate + ahead * mount.gap_change(self.y, self.roll, self.pitch),
                     rate + ahead * change, thrust * f1, coils * f3, iron * f4)

    def place_motors(self) -> None:
        """Put the motors where the platform has them."""
        y = self.y
        roll = self.roll
        pitch = self.pitch
        along_x = self.x.position - self.height * pitch.position
        along_z = self.z.position + self.height * roll.position
        self.alpha1_mount.place(y, roll, pitch, along_x)
        self.alpha2_mount.place(y, roll, pitch, along_x)
        self.beta1_mount.place(y, roll, pitch, along_z)
        self.beta2_mount.place(y, roll, pitch, along_z)

    def time_to_stop(self, dt: float) -> float:
        """Time (s) in which the first axis or motor meets an end stop; dt if none does within dt."""
        y = self.y
        roll = self.roll
        pitch = self.pitch
        dt = self.x.time_to_stop(dt)
        dt = self.z.time_to_stop(dt)
        dt = self.alpha1_mount.time_to_stop(y, roll, pitch, dt)
        dt = self.alpha2_mount.time_to_stop(y, roll, pitch, dt)
        dt = self.beta1_mount.time_to_stop(y, roll, pitch, dt)
        return self.beta2_mount.time_to_stop(y, roll, pitch, dt)

    def beyond_stop(self) -> bool:
        """Whether any axis or motor is beyond an end stop."""
        return (self.x.beyond_stop() or self.z.beyond_stop() or self.alpha1_mount.beyond_stop()
                or self.alpha2_mount.beyond_stop() or self.beta1_mount.beyond_stop() or self.beta2_mount.beyond_stop())

    def moment(self) -> float:
        """Moment (N m) of the motors about y."""
        return (self.alpha1_mount.z * self.alpha1_mount.thrust + self.alpha2_mount.z * self.alpha2_mount.thrust
                - self.beta1_mount.x * self.beta1_mount.thrust - self.beta2_mount.x * self.beta2_mount.thrust)

    def measure(self) -> None:
        """Set the outputs of the encoders, and the yaw moment."""
        self.x.encoder = self.encoder.measure(self.x.position + self.x.swing)
        self.z.encoder = self.encoder.measure(self.z.position + self.z.swing)
        self.alpha1_mount.gap_encoder = self.encoder.measure(self.alpha1_mount.seen_gap(self.y, self.roll, self.pitch))
        self.alpha2_mount.gap_encoder = self.encoder.measure(self.alpha2_mount.seen_gap(self.y, self.roll, self.pitch))
        self.beta1_mount.gap_encoder = self.encoder.measure(self.beta1_mount.seen_gap(self.y, self.roll, self.pitch))
        self.beta2_mount.gap_encoder = self.encoder.measure(self.beta2_mount.seen_gap(self.y, self.roll, self.pitch))
        self.yaw_moment = self.moment()
