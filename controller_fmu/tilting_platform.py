"""A platform that tilts: the places of its motors, and its position from their air gaps."""

from typing import Any

from controller_fmu.motor_place import MotorPlace
from controller_fmu.symmetric3 import Symmetric3
from controller_fmu.tilt_measurement import TiltMeasurement


class TiltingPlatform:
    """Height of the magnets' faces, places of the motors, and JᵀJ of these, see `MotorPlace`.

    With one horizontal axis guides hold the platform level along it, and only the tilt about it is left.
    """

    def __init__(self, height: float, places: list[MotorPlace], horizontal: int):
        self.height = height          # m, parameter: of the magnets' faces below the centre of mass
        self.places = places          # of the motors
        self.horizontal = horizontal  # number of horizontal axes
        self.square = Symmetric3()    # JᵀJ
        self.motors = 1.0 * len(places)
        self.tilts = TiltMeasurement()

    def prepare(self) -> bool:
        """Compute the motors' shares; return True if the motors measure and make every tilt: not all on one line."""
        square = self.square
        square.set_diagonal(0.0, 0.0, 0.0)
        for place in self.places:
            square.add_square(1.0, 1.0, -place.z, place.x)
        square.factorise()
        if not (square.g1 > 0.0 and square.g2 > 0.0 and (square.g3 > 0.0 or self.horizontal == 1)):
            return False
        for place in self.places:
            place.share_y, place.share_roll, place.share_pitch = square.solve(1.0, -place.z, place.x)
        return True

    def measure(self, gap: float) -> bool:
        """Compute the air gap at the centre and the tilts from the gaps at the motors.

        Return True if all gaps were measured.
        """
        tilts = self.tilts
        tilts.clear()
        seen = True
        for place in self.places:
            tilts.add(place, place.gap_measured)
            if place.gap_measured <= 0.0:
                seen = False
        return seen

    def centre(self, gap: float) -> float:
        """Air gap (m) at the centre: by those at the motors."""
        return self.tilts.y

    def gap(self, motor: int, gap: float) -> float:
        """Return the measured air gap (m) at a motor."""
        return self.places[motor].gap_measured

    def observe(self, axes: list[Any]) -> bool:
        """Give the vertical axis and the tilts their measurements; return True if all gaps were measured."""
        tilts = self.tilts
        seen = self.measure(0.0)
        axes[0].measured = tilts.y
        first = self.horizontal + 1
        axes[first].measured = tilts.roll
        if self.horizontal == 2:
            axes[first + 1].measured = tilts.pitch
        return seen

    def along(self, axis: int, displacement: float) -> float:
        """Displacement (m) at the faces of the magnets, with which the motors of a horizontal axis commutate."""
        if self.horizontal == 1:
            return displacement
        if axis == 0:
            return displacement - self.height * self.tilts.pitch
        return displacement + self.height * self.tilts.roll

    def moved(self, motor: int, y: float, roll: float, pitch: float) -> float:
        """Return the displacement (m) at a motor for a displacement (m) and tilts (rad) of the platform."""
        return self.places[motor].moved(y, roll, pitch)

    def spread_x(self) -> float:
        """Σ x² / n of the motors, m²."""
        return self.square.s33 / self.motors

    def spread_z(self) -> float:
        """Σ z² / n of the motors, m²."""
        return self.square.s22 / self.motors
