"""One axis of motion: mass, guide, end stops, flexible mode, and its share of a Runge–Kutta step."""

from plant_fmu.end_stop import EndStop
from plant_fmu.flexible_mode import FlexibleMode
from plant_fmu.guide import GuideFriction
from plant_fmu.ripple import Ripple
from plant_fmu.roughness import Roughness
from pmlsm.saturation import saturate

LARGEST_POSITION = 1.0e3   # m or rad; a mover beyond has run away, and the numbers after that mean nothing
LARGEST_SPEED = 1.0e6      # m/s or rad/s


class Axis:
    """Position and velocity of a mass under motor, gravity, bias, guide, end stops and external force.

    The stage computes the acceleration by the motors, which couples the axes, and hands it to `add_slope` four times
    an integration step: the classical fourth-order Runge–Kutta method. Nominal masses are the thesis's, everything
    else is assumed.

    The constants of the motors, ripple and roughness are accelerations at the nominal mass. With another mass, such as
    under a payload, their forces do not change, and their accelerations are multiplied by `mass_ratio`.

    Positions are against the floor that stops, guides and stators stand on. Where the floor shakes, its acceleration
    acts on every part of the mover the other way round.

    It may be a rotation as well: rad, kg m² and N m instead of m, kg and N.
    """

    def __init__(self, mass: float, bias: float, coulomb: float, presliding: float, viscous: float,
                 lower: float, upper: float, position_start: float):
        self.mass = mass                       # kg, parameter
        self.nominal_mass = mass               # kg
        self.payload = 0.0                     # kg, mass of a payload
        self.bias = bias                       # Δ, m/s², parameter
        self.position_start = position_start   # m, parameter
        self.locked = False                    # parameter: held in place by hardware
        self.friction = GuideFriction(coulomb, presliding, viscous)
        self.ripple = Ripple(0.0, 5.0e-3)
        self.roughness = Roughness()
        self.stop = EndStop(lower, upper)
        self.mode = FlexibleMode()
        self.force = 0.0                       # N, input
        self.floor_acceleration = 0.0          # m/s², input
        self.position = position_start         # m, state and output
        self.velocity = 0.0                    # m/s, state and output
        self.deflection = 0.0                  # w of the guide friction, state
        self.encoder = position_start          # m, output
        self.flexible = False                  # true if there is a mode
        self.swing = 0.0                       # m, how much more than the position the encoder sees, by the mode
        self.acceleration = 0.0                # m/s², at the last integration point
        self.drift = bias                      # m/s², bias less the acceleration of the floor, in this integration step
        self.present_mass = mass               # kg, with the payload, in this integration step
        self.mass_ratio = 1.0                  # nominal over present mass
        self.position_0 = 0.0                  # state at the start of the integration step
        self.velocity_0 = 0.0
        self.deflection_0 = 0.0
        self.position_sum = 0.0                # weighted slopes so far
        self.velocity_sum = 0.0
        self.deflection_sum = 0.0

    def start(self, seed: int, number: int) -> None:
        """Place the mover at rest at its start position, on the track of a seed and of the axis's number."""
        self.friction.start(seed, number)
        self.roughness.start(seed, number)
        self.position = self.position_start
        self.velocity = 0.0
        self.deflection = 0.0
        self.flexible = self.mode.start()
        self.swing = 0.0

    def beyond_stop(self) -> bool:
        """Return True if the mover is beyond an end stop of this axis."""
        return self.stop.touched(self.position)

    def time_to_stop(self, dt: float) -> float:
        """Time (s) in which the mover meets an end stop; dt if not within dt."""
        return self.stop.time_to_meet(self.position, self.velocity, self.acceleration, dt)

    def begin(self) -> None:
        """Begin an integration step."""
        self.present_mass = self.mass + self.payload
        self.mass_ratio = self.nominal_mass / self.present_mass
        self.drift = self.bias - self.floor_acceleration
        if self.flexible:
            self.mode.begin()
        self.stop.engage(self.position)
        self.position_0 = self.position
        self.velocity_0 = self.velocity
        self.deflection_0 = self.deflection
        self.position_sum = 0.0
        self.velocity_sum = 0.0
        self.deflection_sum = 0.0

    def resume(self) -> None:
        """Begin to compute the rates at the present point of a continuous model, by one `add_slope` of weight 1."""
        self.begin()
        self.stop.resume(self.position)
        self.swing = self.mode.encoder_share * self.mode.deflection

    def settle(self) -> bool:
        """Take in an event of a continuous model; return True if the mover is at a stop."""
        return self.stop.settle(self.velocity)

    def contained(self) -> bool:
        """Return True if the mover has not run away."""
        return (-LARGEST_POSITION < self.position < LARGEST_POSITION
                and -LARGEST_SPEED < self.velocity < LARGEST_SPEED)

    def add_slope(self, motors: float, weight: float, ahead: float) -> None:
        """Add the slope at the present point, and go to the next one.

        Parameters
        ----------
        motors : float
            Acceleration by the motors, at the present mass, and gravity, m/s².
        weight : float
            Weight of this slope in the step, s.
        ahead : float
            Time from the start of the step to the next point, s.
        """
        if self.locked:
            return   # at rest since the start: no slope
        velocity = self.velocity
        deflection = self.deflection
        friction, deflection_rate = self.friction.slide(self.position, deflection, velocity)
        external = self.force - friction
        if self.stop.side != 0:
            external += self.stop.force(self.position, velocity)
        acceleration = motors + self.drift + external / self.present_mass
        if self.ripple.amplitude != 0.0:
            acceleration += self.mass_ratio * self.ripple.acceleration(self.position)
        if self.roughness.rms != 0.0:
            acceleration += self.mass_ratio * self.roughness.acceleration(self.position)
        if self.flexible:   # the floor is no force on the mover: it moves both parts of it alike
            floor = self.floor_acceleration
            acceleration = self.mode.add_slope(acceleration + floor, weight, ahead) - floor
        self.acceleration = acceleration
        self.position_sum += weight * velocity
        self.velocity_sum += weight * acceleration
        self.deflection_sum += weight * deflection_rate
        self.position = self.position_0 + ahead * velocity
        self.velocity = self.velocity_0 + ahead * acceleration
        # |w| ≤ 1 holds exactly in the Dahl model, but not for a Runge–Kutta point at more than δ a step.
        self.deflection = saturate(self.deflection_0 + ahead * deflection_rate, 1.0)

    def finish(self) -> bool:
        """Go to the end of the integration step; False where the mover has run away."""
        self.position = self.position_0 + self.position_sum
        self.velocity = self.velocity_0 + self.velocity_sum
        self.deflection = saturate(self.deflection_0 + self.deflection_sum, 1.0)
        if self.flexible:
            self.swing = self.mode.finish()
        return self.contained()
