"""Periodic acceleration of one axis along its way, by the bearings of its guide or by the slots of a stator.

The thesis describes the cogging force along a horizontal axis, F_x^c, as periodic over the slot pitch (section 4.4.3);
as printed, (4.11) has twice that period. Amplitudes, phase and the period of a guide are assumed.
"""

from math import pi, sin

RIPPLE_PHASE = 0.5   # rad


class Ripple:
    """Acceleration r sin(2π d/p + 0.5) at a position d. Off where its amplitude or period is 0."""

    def __init__(self, amplitude: float, period: float):
        self.amplitude = amplitude   # r, m/s², parameter
        self.period = period         # p, m, parameter

    def acceleration(self, position: float) -> float:
        """Acceleration (m/s²) at a position (m)."""
        if self.amplitude == 0.0 or self.period <= 0.0:
            return 0.0
        return self.amplitude * sin(2.0 * pi * position / self.period + RIPPLE_PHASE)
