"""Linear guide of one axis: presliding and viscous friction. All assumed."""


class GuideFriction:
    """Dahl friction with a viscous part, F = Fc w + b v, w' = v/δ (1 − w sgn v). Off where Fc or δ is 0."""

    def __init__(self, coulomb: float, presliding: float, viscous: float):
        self.coulomb = coulomb         # Fc, N, parameter
        self.presliding = presliding   # δ, m, parameter
        self.viscous = viscous         # b, N s/m, parameter

    def slide(self, deflection: float, velocity: float) -> tuple[float, float]:
        """Force against the motion F (N), and the rate w' (1/s), at a relative deflection w and a velocity (m/s)."""
        force = self.coulomb * deflection + self.viscous * velocity
        if self.presliding <= 0.0 or self.coulomb <= 0.0:
            return force, 0.0
        if velocity < 0.0:
            return force, velocity / self.presliding * (1.0 + deflection)
        return force, velocity / self.presliding * (1.0 - deflection)
