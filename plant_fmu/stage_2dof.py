"""The 2-DOF stage: one motor carries the mover vertically (v, the air gap) and drives it along h."""

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

LONGEST_STEP = 0.00025   # s; docs/accuracy.md has the study behind it

STARTED = 0   # status of `start` and `step`
V_BEYOND_STOP = 1
H_BEYOND_STOP = 2
RUN_AWAY = 3
STEP_TOO_LONG = 4
NO_SUCH_MOTOR = 5
NO_SEED = 6


class Stage2DOF:
    """Motion (4.3) of the 2-DOF stage with guides, bias, stops, amplifiers and encoders."""

    def __init__(self) -> None:
        self.C1 = 14.2                      # m/(s² A), parameter: thrust along h
        self.C2 = 791.0                     # m/(s² T²), parameter: attraction between magnets and iron
        self.C3 = 30.9                      # m/(s² A T), parameter: normal force between magnets and coils
        self.C4 = 0.12                      # m/(s² A²), parameter: normal force between coils and iron
        self.attraction_modulation = 0.027  # parameter
        self.roughness_seed = 1.0           # parameter: a whole number
        self.magnet_rise = 0.0              # K, parameter: how warm the magnets are, above the constants' temperature
        self.bus_voltage = 0.0              # V, parameter: of the amplifiers' supply, 0 = any that is needed
        self.geometry = MotorGeometry()
        self.v = Axis(4.35, 0.2, 2.0, 0.0003, 2.0, 0.008, 0.028, 0.02)
        self.h = Axis(1.594, 0.1, 0.25, 0.0003, 1.0, -0.07, 0.07, 0.0)
        self.h.ripple.period = 0.01905
        self.h_angle = ElectricalAngle()
        self.motor = MotorSupply(9.0, 7.0, 7.0, 0.07)
        self.encoder = Encoder(1e-05)
        self.at_stop = False   # output

    def start(self) -> int:
        """Place the mover at its start position; the status says which axis is beyond a stop."""
        if not self.geometry.prepare():
            return NO_SUCH_MOTOR
        seed = int(self.roughness_seed)
        if seed != self.roughness_seed:
            return NO_SEED
        if not self.v.start(seed, 0):
            return V_BEYOND_STOP
        if not self.h.start(seed, 1):
            return H_BEYOND_STOP
        self.h_angle.forget()
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
        self.h_angle.turn(geometry, self.h.position)
        self.motor.deliver(self.h_angle)
        self.measure()
        return STARTED

    def integrate(self, dt: float) -> bool:
        """Move over one integration step dt (s); False where the mover has run away."""
        geometry = self.geometry
        v = self.v
        h = self.h
        motor = self.motor
        h_angle = self.h_angle
        bus = self.bus_voltage
        if bus > 0.0:
            self.induce(0.5 * dt)
        motor.advance(dt, bus)
        v.begin()
        h.begin()
        h_angle.follow(geometry, self.h.position)
        motor.at_start(h_angle)
        self.add_slope(dt / 6.0, dt / 2.0)
        h_angle.turn(geometry, self.h.position)
        motor.at_middle(h_angle)
        self.add_slope(dt / 3.0, dt / 2.0)
        h_angle.turn(geometry, self.h.position)
        motor.at_middle(h_angle)
        self.add_slope(dt / 3.0, dt)
        h_angle.turn(geometry, self.h.position)
        motor.at_end(h_angle)
        self.add_slope(dt / 6.0, 0.0)
        contained = v.finish() and h.finish()
        if self.beyond_stop():
            self.at_stop = True
        return contained

    def derive(self) -> int:
        """Compute the rates of the states at the present point of a continuous model, and all that is continuous."""
        geometry = self.geometry
        self.v.resume()
        self.h.resume()
        self.h_angle.turn(geometry, self.h.position)
        self.motor.resume(self.h_angle)
        bus = self.bus_voltage
        if bus > 0.0:
            self.induce(0.0)
        self.motor.derive(bus)
        self.add_slope(1.0, 0.0)
        if self.v.contained() and self.h.contained():
            return STARTED
        return RUN_AWAY

    def settle(self) -> bool:
        """Take in an event of a continuous model: stops, clamps, first currents, encoders; whether a current jumps."""
        self.derive()
        v_stopped = self.v.settle()
        h_stopped = self.h.settle()
        self.at_stop = v_stopped or h_stopped
        self.measure()
        return self.motor.settle()

    def add_slope(self, weight: float, ahead: float) -> None:
        """Add one Runge–Kutta slope on all axes (4.3)."""
        v = self.v
        h = self.h
        motor = self.motor
        f1, f2, f3, f4 = gap_functions(self.geometry, v.position)
        f2 *= attraction_factor(self.attraction_modulation, h.position, self.geometry.slot_pitch)
        if self.magnet_rise != 0.0:
            strength = magnet_strength(self.magnet_rise)
            f1 *= strength
            f2 *= strength * strength
            f3 *= strength
        share = v.mass_ratio
        v_motors = normal_acceleration(
            share * self.C2, share * self.C3, share * self.C4, f2, f3, f4,
            motor.i_d,
            motor.i_q * motor.i_q + motor.i_d * motor.i_d)
        h_motors = thrust_acceleration(h.mass_ratio * self.C1, f1, motor.i_q)
        v.add_slope(v_motors, weight, ahead)
        h.add_slope(h_motors, weight, ahead)

    def induce(self, ahead: float) -> None:
        """Compute the voltages that the motion induces in the windings a time ahead (s)."""
        geometry = self.geometry
        v = self.v
        h = self.h
        f1, f2, f3, f4 = gap_functions(geometry, v.position + ahead * v.velocity)
        strength = magnet_strength(self.magnet_rise)
        gap_rate = v.velocity + ahead * v.acceleration
        coils = v.nominal_mass * self.C3 * strength * f3
        iron = v.nominal_mass * self.C4 * f4
        self.motor.induce(
            geometry.electrical_angle(h.position + ahead * h.velocity), gap_rate,
            h.velocity + ahead * h.acceleration, h.nominal_mass * self.C1 * strength * f1, coils, iron)

    def time_to_stop(self, dt: float) -> float:
        """Time (s) in which the first axis meets an end stop; dt if none does within dt."""
        dt = self.v.time_to_stop(dt)
        return self.h.time_to_stop(dt)

    def beyond_stop(self) -> bool:
        """Whether any axis is beyond an end stop."""
        return self.v.beyond_stop() or self.h.beyond_stop()

    def measure(self) -> None:
        """Set the encoder outputs."""
        self.v.encoder = self.encoder.measure(self.v.position + self.v.swing)
        self.h.encoder = self.encoder.measure(self.h.position + self.h.swing)
