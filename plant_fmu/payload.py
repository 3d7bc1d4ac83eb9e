"""A payload on a platform that tilts."""

from pmlsm.velocity_rows import GRAVITY


class Payload:
    """A mass that lies at a place of the platform: it moves along every axis, and its weight tilts the platform.

    That the centre of mass is elsewhere with it couples the axes, which is neglected (assumed).
    """

    def __init__(self) -> None:
        self.mass = 0.0   # kg, parameter
        self.x = 0.0      # m, parameter: place on the platform, from its centre of mass
        self.z = 0.0      # m, parameter

    def roll_inertia(self) -> float:
        """Inertia about x that it adds, kg m²."""
        return self.mass * self.z * self.z

    def pitch_inertia(self) -> float:
        """Inertia about z that it adds, kg m²."""
        return self.mass * self.x * self.x

    def roll_torque(self) -> float:
        """Torque of its weight about x, N m."""
        return -self.mass * GRAVITY * self.z

    def pitch_torque(self) -> float:
        """Torque of its weight about z, N m."""
        return self.mass * GRAVITY * self.x
