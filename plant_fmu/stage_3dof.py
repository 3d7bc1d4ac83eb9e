"""The 3-DOF stage: alpha, beta carry the mover vertically (y, the air gap) and drive it along x and z."""

from plant_fmu.attraction import attraction_factor
from plant_fmu.axis import Axis
from plant_fmu.encoder import Encoder
from plant_fmu.integration import LONGEST_COMMUNICATION_STEP, integration_steps
from plant_fmu.magnets import magnet_strength
from plant_fmu.motor_supply import MotorSupply
from pmlsm.electrical_angle import ElectricalAngle
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.velocity_rows import normal_acceleration, thrust_acceleration

LONGEST_STEP = 0.0002   # s; docs/accuracy.md has the study behind it

STARTED = 0   # status of `start` and `step`
Y_BEYOND_STOP = 1
X_BEYOND_STOP = 2
Z_BEYOND_STOP = 3
RUN_AWAY = 4
STEP_TOO_LONG = 5
NO_SUCH_MOTOR = 6
NO_SEED = 7


class Stage3DOF:
    """Motion (5.3) of the 3-DOF stage with guides, bias, stops, amplifiers and encoders."""

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
        self.geometry = MotorGeometry()
        self.y = Axis(6.9, 0.1, 1.0, 0.0005, 2.0, 0.0185, 0.032, 0.025)
        self.y.ripple.amplitude = 0.15
        self.x = Axis(10.6, 0.05, 1.2, 0.0005, 2.0, -0.062, 0.062, 0.0)
        self.x.ripple.period = 0.01905
        self.z = Axis(8.6, 0.05, 1.1, 0.0005, 2.0, -0.062, 0.062, 0.0)
        self.z.ripple.period = 0.01905
        self.x_angle = ElectricalAngle()
        self.z_angle = ElectricalAngle()
        self.alpha = MotorSupply(5.0, 4.0, 3.5, 0.035)
        self.beta = MotorSupply(5.0, 4.0, 3.5, 0.035)
        self.encoder = Encoder(1e-05)
        self.at_stop = False   # output

    def start(self) -> int:
        """Place the mover at its start position; the status says which axis is beyond a stop."""
        if not self.geometry.prepare():
            return NO_SUCH_MOTOR
        seed = int(self.roughness_seed)
        if seed != self.roughness_seed:
            return NO_SEED
        if not self.y.start(seed, 0):
            return Y_BEYOND_STOP
        if not self.x.start(seed, 1):
            return X_BEYOND_STOP
        if not self.z.start(seed, 2):
            return Z_BEYOND_STOP
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
        self.x_angle.turn(geometry, self.x.position)
        self.z_angle.turn(geometry, self.z.position)
        self.alpha.deliver(self.x_angle)
        self.beta.deliver(self.z_angle)
        self.measure()
        return STARTED

    def integrate(self, dt: float) -> bool:
        """Move over one integration step dt (s); False where the mover has run away."""
        geometry = self.geometry
        y = self.y
        x = self.x
        z = self.z
        alpha = self.alpha
        beta = self.beta
        x_angle = self.x_angle
        z_angle = self.z_angle
        bus = self.bus_voltage
        if bus > 0.0:
            self.induce(0.5 * dt)
        alpha.advance(dt, bus)
        beta.advance(dt, bus)
        y.begin()
        x.begin()
        z.begin()
        x_angle.follow(geometry, self.x.position)
        z_angle.follow(geometry, self.z.position)
        alpha.at_start(x_angle)
        beta.at_start(z_angle)
        self.add_slope(dt / 6.0, dt / 2.0)
        x_angle.turn(geometry, self.x.position)
        z_angle.turn(geometry, self.z.position)
        alpha.at_middle(x_angle)
        beta.at_middle(z_angle)
        self.add_slope(dt / 3.0, dt / 2.0)
        x_angle.turn(geometry, self.x.position)
        z_angle.turn(geometry, self.z.position)
        alpha.at_middle(x_angle)
        beta.at_middle(z_angle)
        self.add_slope(dt / 3.0, dt)
        x_angle.turn(geometry, self.x.position)
        z_angle.turn(geometry, self.z.position)
        alpha.at_end(x_angle)
        beta.at_end(z_angle)
        self.add_slope(dt / 6.0, 0.0)
        contained = y.finish() and x.finish() and z.finish()
        if self.beyond_stop():
            self.at_stop = True
        return contained

    def derive(self) -> int:
        """Compute the rates of the states at the present point of a continuous model, and all that is continuous."""
        geometry = self.geometry
        self.y.resume()
        self.x.resume()
        self.z.resume()
        self.x_angle.turn(geometry, self.x.position)
        self.z_angle.turn(geometry, self.z.position)
        self.alpha.resume(self.x_angle)
        self.beta.resume(self.z_angle)
        bus = self.bus_voltage
        if bus > 0.0:
            self.induce(0.0)
        self.alpha.derive(bus)
        self.beta.derive(bus)
        self.add_slope(1.0, 0.0)
        if self.y.contained() and self.x.contained() and self.z.contained():
            return STARTED
        return RUN_AWAY

    def settle(self) -> bool:
        """Take in an event of a continuous model: stops, clamps, first currents, encoders; whether a current jumps."""
        self.derive()
        y_stopped = self.y.settle()
        x_stopped = self.x.settle()
        z_stopped = self.z.settle()
        self.at_stop = y_stopped or x_stopped or z_stopped
        self.measure()
        alpha_jumps = self.alpha.settle()
        beta_jumps = self.beta.settle()
        return alpha_jumps or beta_jumps

    def add_slope(self, weight: float, ahead: float) -> None:
        """Add one Runge–Kutta slope on all axes (5.3)."""
        y = self.y
        x = self.x
        z = self.z
        alpha = self.alpha
        beta = self.beta
        f1, f2, f3, f4 = gap_functions(self.geometry, y.position)
        f2 *= attraction_factor(self.attraction_modulation, x.position, self.geometry.slot_pitch)
        if self.magnet_rise != 0.0:
            strength = magnet_strength(self.magnet_rise)
            f1 *= strength
            f2 *= strength * strength
            f3 *= strength
        share = y.mass_ratio
        y_motors = normal_acceleration(
            4.0 * share * self.C3, 2.0 * share * self.C4, 2.0 * share * self.C5, f2, f3, f4,
            alpha.i_d + beta.i_d,
            alpha.i_q * alpha.i_q + alpha.i_d * alpha.i_d + beta.i_q * beta.i_q + beta.i_d * beta.i_d)
        x_motors = thrust_acceleration(2.0 * x.mass_ratio * self.C1, f1, alpha.i_q)
        z_motors = thrust_acceleration(2.0 * z.mass_ratio * self.C2, f1, beta.i_q)
        y.add_slope(y_motors, weight, ahead)
        x.add_slope(x_motors, weight, ahead)
        z.add_slope(z_motors, weight, ahead)

    def induce(self, ahead: float) -> None:
        """Compute the voltages that the motion induces in the windings a time ahead (s)."""
        geometry = self.geometry
        y = self.y
        x = self.x
        z = self.z
        f1, f2, f3, f4 = gap_functions(geometry, y.position + ahead * y.velocity)
        strength = magnet_strength(self.magnet_rise)
        gap_rate = y.velocity + ahead * y.acceleration
        coils = 2.0 * y.nominal_mass * self.C4 * strength * f3
        iron = 2.0 * y.nominal_mass * self.C5 * f4
        self.alpha.induce(
            geometry.electrical_angle(x.position + ahead * x.velocity), gap_rate,
            x.velocity + ahead * x.acceleration, 2.0 * x.nominal_mass * self.C1 * strength * f1, coils, iron)
        self.beta.induce(
            geometry.electrical_angle(z.position + ahead * z.velocity), gap_rate,
            z.velocity + ahead * z.acceleration, 2.0 * z.nominal_mass * self.C2 * strength * f1, coils, iron)

    def time_to_stop(self, dt: float) -> float:
        """Time (s) in which the first axis meets an end stop; dt if none does within dt."""
        dt = self.y.time_to_stop(dt)
        dt = self.x.time_to_stop(dt)
        return self.z.time_to_stop(dt)

    def beyond_stop(self) -> bool:
        """Whether any axis is beyond an end stop."""
        return self.y.beyond_stop() or self.x.beyond_stop() or self.z.beyond_stop()

    def measure(self) -> None:
        """Set the encoder outputs."""
        self.y.encoder = self.encoder.measure(self.y.position + self.y.swing)
        self.x.encoder = self.encoder.measure(self.x.position + self.x.swing)
        self.z.encoder = self.encoder.measure(self.z.position + self.z.swing)
