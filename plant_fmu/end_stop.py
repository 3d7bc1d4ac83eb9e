"""End stops of one axis."""


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

    def touched(self, position: float) -> bool:
        """Whether a position (m) is beyond a stop that is there."""
        return (position < self.lower or position > self.upper) and (self.stiffness > 0.0 or self.damping > 0.0)

    def force(self, position: float, velocity: float) -> float:
        """Force (N) on the mover at a position (m) and a velocity (m/s)."""
        if position < self.lower:
            push = self.stiffness * (self.lower - position) - self.damping * velocity
            if push > 0.0:
                return push
        elif position > self.upper:
            push = self.stiffness * (position - self.upper) + self.damping * velocity
            if push > 0.0:
                return -push
        return 0.0
