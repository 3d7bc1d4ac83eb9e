"""The guides of a platform against a tilt: how much of it they allow. All assumed."""


class TiltGuide:
    """A spring beyond a play to either side: k (|φ| − s). Off where its stiffness is 0, as without guides."""

    def __init__(self) -> None:
        self.stiffness = 0.0   # k, N m/rad, parameter
        self.play = 0.0        # s, rad, parameter

    def torque(self, tilt: float) -> float:
        """Torque (N m) on the platform at a tilt (rad)."""
        if tilt > self.play:
            return -self.stiffness * (tilt - self.play)
        if tilt < -self.play:
            return -self.stiffness * (tilt + self.play)
        return 0.0
