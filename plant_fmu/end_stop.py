"""End stops of one axis."""

TOUCH = 1.0e-8   # m; so near a stop the mover meets it in the integration step that begins there
SHORTEST_PART = 1.0e-3   # of an integration step; a stop that is met earlier is met at its start


class EndStop:
    """Unilateral spring and damper at both ends of the travel, never pulling.

    The thesis describes adjustable stops (sections 4.1.2 and 5.1.2); their stiffness, damping and places are
    assumed. Off where stiffness and damping are both 0.
    """

    def __init__(self, lower: float, upper: float):
        self.lower = lower         # m, parameter
        self.upper = upper         # m, parameter
        self.stiffness = 4.0e5     # N/m, parameter
        self.damping = 1500.0      # N s/m, parameter
        self.side = 0              # stop that the mover is at in an integration step: -1 lower, 1 upper, 0 none
        self.contact = 0           # the same between two events of a continuous model
        self.to_lower = 1.0        # m, way to the stop, 1 if there is none: its sign changes at an event
        self.to_upper = 1.0

    def touched(self, position: float) -> bool:
        """Return True if a position (m) is beyond a stop that is there."""
        return (position < self.lower or position > self.upper) and (self.stiffness > 0.0 or self.damping > 0.0)

    def time_to_meet(self, position: float, velocity: float, acceleration: float, dt: float) -> float:
        """Time (s) in which a mover meets a stop, from its position, velocity and acceleration; dt if not within dt.

        An integration step has to end there: the next one has the stop engaged.
        """
        if velocity > 0.0 and position < self.upper:
            distance = self.upper - position
        elif velocity < 0.0 and position > self.lower:
            distance = self.lower - position
        else:
            return dt
        meeting = distance / velocity
        if meeting >= 2.0 * dt:
            return dt
        speed = velocity + 0.5 * acceleration * meeting   # mean one on the way
        if distance * speed <= 0.0:
            return dt
        meeting = distance / speed
        if SHORTEST_PART * dt < meeting < dt:
            return meeting
        return dt

    def engage(self, position: float) -> None:
        """Set the stop that a mover at a position (m) is at for one integration step.

        It stays the same within the step: the force of the damper begins with a jump, which a Runge–Kutta step must not
        have inside.
        """
        self.side = 0
        if position < self.lower + TOUCH:
            self.side = -1
        elif position > self.upper - TOUCH:
            self.side = 1

    def resume(self, position: float) -> None:
        """Take the stop that the last event has left, in a continuous model, and the ways to both (m)."""
        self.side = self.contact
        if self.stiffness > 0.0 or self.damping > 0.0:
            self.to_lower = position - self.lower
            self.to_upper = self.upper - position
        else:
            self.to_lower = 1.0
            self.to_upper = 1.0

    def settle(self, velocity: float) -> bool:
        """Decide, at an event, which stop a mover is at until the next one; return True if it is at one.

        At a stop, where the event has been found except for rounding, the velocity (m/s) tells which way it goes.
        """
        self.contact = 0
        if self.to_lower < -TOUCH or (self.to_lower <= TOUCH and velocity <= 0.0):
            self.contact = -1
        elif self.to_upper < -TOUCH or (self.to_upper <= TOUCH and velocity >= 0.0):
            self.contact = 1
        return self.contact != 0

    def force(self, position: float, velocity: float) -> float:
        """Force (N) on the mover at a position (m) and a velocity (m/s)."""
        if self.side == 0:
            return 0.0
        if self.side < 0:
            push = self.stiffness * (self.lower - position) - self.damping * velocity
        else:
            push = self.stiffness * (position - self.upper) + self.damping * velocity
        if push < 0.0:
            return 0.0   # it does not pull
        return -self.side * push
