"""Periodic acceleration of one axis along its way, by the bearings of its guide or by the slots of a stator.

The thesis describes the cogging force along a horizontal axis, F_x^c, as periodic over the slot pitch (section 4.4.3);
as printed, (4.11) has twice that period. Amplitudes, phase and the period of a guide are assumed.
"""

from math import pi

from pmlsm.sine_cosine import sine_of_turns

RIPPLE_PHASE = 0.5   # rad
RIPPLE_TURNS = RIPPLE_PHASE / (2.0 * pi)
SHORTEST_RIPPLE = 1.0e-9    # m


class Ripple:
    """Acceleration r sin(2π d/p + 0.5) at a position d. Off where its amplitude is 0 or its period below 1 nm."""

    def __init__(self, amplitude: float, period: float):
        self.amplitude = amplitude   # r, m/s², parameter
        self.period = period         # p, m, parameter

    def acceleration(self, position: float) -> float:
        """Acceleration (m/s²) at a position (m)."""
        if self.amplitude == 0.0 or self.period < SHORTEST_RIPPLE:
            return 0.0
        return self.amplitude * sine_of_turns(position / self.period + RIPPLE_TURNS)
