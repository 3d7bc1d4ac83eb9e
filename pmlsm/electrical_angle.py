"""The electrical angle of a motor (4.4), by its sine and cosine, as the rotations of vectors use it."""

from math import nan

from pmlsm.motor_geometry import MotorGeometry
from pmlsm.sine_cosine import sine_cosine


class ElectricalAngle:
    """Sine and cosine of θ = π/τ (d − τ/2) at the displacement d of the motors along one axis."""

    def __init__(self) -> None:
        self.sine = 0.0
        self.cosine = 0.0
        self.place = nan   # d, m, to which they belong

    def turn(self, geometry: MotorGeometry, displacement: float) -> None:
        """Go to a displacement (m)."""
        self.sine, self.cosine = sine_cosine(geometry.electrical_angle(displacement))
        self.place = displacement

    def follow(self, geometry: MotorGeometry, displacement: float) -> None:
        """Go to a displacement (m), where it may be already: a step begins where the one before has ended."""
        if displacement != self.place:
            self.turn(geometry, displacement)

    def forget(self) -> None:
        """Start again, with a geometry that may have changed."""
        self.place = nan
