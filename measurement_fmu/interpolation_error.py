"""Error of an encoder that interpolates between the lines of its scale: periodic along the way. Assumed."""

from math import pi, sin

SHORTEST = 1.0e-9   # m


class InterpolationError:
    """A sin(2π q/p) at a position q. Off where its amplitude or period is 0."""

    def __init__(self) -> None:
        self.amplitude = 0.0   # A, m, parameter
        self.period = 0.0      # p, m, parameter

    def at(self, position: float) -> float:
        """Error (m) at a position (m)."""
        if self.amplitude == 0.0 or self.period < SHORTEST:
            return 0.0
        return self.amplitude * sin(2.0 * pi * position / self.period)
