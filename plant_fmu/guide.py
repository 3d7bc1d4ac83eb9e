"""Linear guide of one axis: presliding and viscous friction. All assumed."""

from plant_fmu.track import Track

FIRST_STREAM = 0x1100   # of the random words: the roughness has those before it


class GuideFriction:
    """Dahl friction with a viscous part, F = Fc w + b v, w' = v/δ (1 − w sgn v). Off where Fc or δ is 0.

    Along the way q the level of Coulomb friction varies, Fc max(0, 1 + s n(q)) on a track n, fixed by a seed.
    """

    def __init__(self, coulomb: float, presliding: float, viscous: float):
        self.coulomb = coulomb         # Fc, N, parameter
        self.presliding = presliding   # δ, m, parameter
        self.viscous = viscous         # b, N s/m, parameter
        self.variation = 0.0           # s, parameter; 0 = the same level everywhere
        self.correlation = 4.0e-3      # ℓ, m, parameter
        self.track = Track()

    def start(self, seed: int, number: int) -> None:
        """Lay the track of a seed and of the number of an axis."""
        self.track.start(seed, FIRST_STREAM + number, self.correlation)

    def level(self, position: float) -> float:
        """Level of Coulomb friction (N) at a position (m)."""
        if self.variation == 0.0:
            return self.coulomb
        share = 1.0 + self.variation * self.track.at(position)
        return self.coulomb * share if share > 0.0 else 0.0

    def slide(self, position: float, deflection: float, velocity: float) -> tuple[float, float]:
        """Force against the motion F (N), and the rate w' (1/s).

        Parameters
        ----------
        position : float
            Position, m.
        deflection : float
            Relative deflection w.
        velocity : float
            Velocity, m/s.
        """
        force = self.level(position) * deflection + self.viscous * velocity
        if self.presliding <= 0.0 or self.coulomb <= 0.0:
            return force, 0.0
        if velocity < 0.0:
            return force, velocity / self.presliding * (1.0 + deflection)
        return force, velocity / self.presliding * (1.0 - deflection)
