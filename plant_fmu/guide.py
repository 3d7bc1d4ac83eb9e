"""Linear guide of one axis: presliding and viscous friction. All assumed."""


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
