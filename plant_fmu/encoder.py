"""Linear optical encoder, sections 4.1.2 and 5.1.2."""

from math import floor


class Encoder:
    """Rounds a position to its resolution; without noise, being digital. A resolution of 0 measures exactly."""

    def __init__(self, resolution: float):
        self.resolution = resolution   # m, parameter

    def measure(self, position: float) -> float:
        """Measured position (m) of a true position (m)."""
        if self.resolution <= 0.0:
            return position
        return floor(position / self.resolution + 0.5) * self.resolution
