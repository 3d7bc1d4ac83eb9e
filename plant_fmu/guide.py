"""Linear guide of one axis: presliding and viscous friction, and the ripple of its bearings. All assumed."""

from math import pi, sin

RIPPLE_PHASE = 0.5   # rad


class GuideFriction:
    """Dahl friction with a viscous part, F = Fc w + b v, w' = v/δ (1 − w sgn v). Off where Fc or δ is 0."""

    def __init__(self, coulomb: float, presliding: float, viscous: float):
        self.coulomb = coulomb         # Fc, N, parameter
        self.presliding = presliding   # δ, m, parameter
        self.viscous = viscous         # b, N s/m, parameter

    def force(self, deflection: float, velocity: float) -> float:
        """Force against the motion (N) at a relative deflection w and a velocity (m/s)."""
        return self.coulomb * deflection + self.viscous * velocity

    def deflection_rate(self, deflection: float, velocity: float) -> float:
        """Rate w' (1/s) of the relative deflection of the contact."""
        if self.presliding <= 0.0 or self.coulomb <= 0.0:
            return 0.0
        if velocity < 0.0:
            return velocity / self.presliding * (1.0 + deflection)
        return velocity / self.presliding * (1.0 - deflection)


class GuideRipple:
    """Periodic acceleration that a guide gives to the mover. Off where its amplitude or period is 0."""

    def __init__(self, amplitude: float, period: float):
        self.amplitude = amplitude   # m/s², parameter
        self.period = period         # m, parameter

    def acceleration(self, position: float) -> float:
        """Acceleration (m/s²) at a position (m)."""
        if self.amplitude == 0.0 or self.period <= 0.0:
            return 0.0
        return self.amplitude * sin(2.0 * pi * position / self.period + RIPPLE_PHASE)
