"""Error of an encoder that interpolates between the lines of its scale: periodic along the way. Assumed."""

from pmlsm.sine_cosine import sine_of_turns

SHORTEST = 1.0e-9   # m


class InterpolationError:
    """A sin(2π q/p) at a position q. Off where its amplitude is 0 or its period below 1 nm."""

    def __init__(self) -> None:
        self.amplitude = 0.0   # A, m, parameter
        self.period = 0.0      # p, m, parameter

    def at(self, position: float) -> float:
        """Error (m) at a position (m)."""
        if self.amplitude == 0.0 or self.period < SHORTEST:
            return 0.0
        return self.amplitude * sine_of_turns(position / self.period)
