"""Linear optical encoder, sections 4.1.2 and 5.1.2."""

from pmlsm.whole_numbers import rounded_down

MOST_COUNTS = 1.0e15   # beyond, a double has no room for the fraction that an encoder drops


class Encoder:
    """Rounds a position to its resolution; without noise, being digital. A resolution of 0 measures exactly."""

    def __init__(self, resolution: float):
        self.resolution = resolution   # m, parameter

    def measure(self, position: float) -> float:
        """Measured position (m) of a true position (m)."""
        if self.resolution <= 0.0:
            return position
        counts = position / self.resolution + 0.5
        if not -MOST_COUNTS < counts < MOST_COUNTS:
            return position
        return rounded_down(counts) * self.resolution
