"""Conversion of one value for each motor, such as its air gap, to values of the vertical axis and of the tilts."""

from controller_fmu.motor_place import MotorPlace


class TiltMeasurement:
    """y, roll and pitch by least squares, S = (JᵀJ)⁻¹Jᵀ times the values of the motors.

    From the measured gaps it computes the air gap at the centre (m) and the tilts (rad). From the direct currents (A)
    that the limits have cut off, it computes the inputs of the antiwindup (5.13). These are a current that all motors
    have in common (A) and its slopes over the platform (A/m). S is the transpose of the allocation of the forces, and a
    left inverse of J. A current that is short by the same amount in all motors affects y alone, as on a stage without
    tilts.
    """

    def __init__(self) -> None:
        self.y = 0.0       # output
        self.roll = 0.0    # output
        self.pitch = 0.0   # output

    def clear(self) -> None:
        """Begin with no motor."""
        self.y = 0.0
        self.roll = 0.0
        self.pitch = 0.0

    def add(self, place: MotorPlace, value: float) -> None:
        """Take in the value of a motor."""
        self.y += place.share_y * value
        self.roll += place.share_roll * value
        self.pitch += place.share_pitch * value
