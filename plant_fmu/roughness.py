"""Roughness of the guides of one axis: a random acceleration along its way. All assumed.

The thesis names "bearing misalignment" (p. 61) and errors with "occasional peaks … at random intervals" (p. 59).
"""

from plant_fmu.track import Track

FIRST_STREAM = 0x1000   # of the random words: measurements have those before it


class Roughness:
    """Acceleration r(q) = σ n(q) on a track n, fixed by a seed. Off where its rms σ is 0."""

    def __init__(self) -> None:
        self.rms = 0.0              # σ, m/s², parameter
        self.correlation = 2.0e-3   # ℓ, m, parameter
        self.track = Track()

    def start(self, seed: int, number: int) -> None:
        """Lay the track of a seed and of the number of an axis."""
        self.track.start(seed, FIRST_STREAM + number, self.correlation)

    def acceleration(self, position: float) -> float:
        """Acceleration (m/s²) at a position (m)."""
        return self.rms * self.track.at(position)
