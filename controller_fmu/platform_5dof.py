"""The motors of the 5-DOF stage at their places on the platform, as controllers and estimators take them."""

from controller_fmu.motor_place import MotorPlace
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform


def prepare_platform(platform: TiltingPlatform, alpha1: MotorPlace, alpha2: MotorPlace, beta1: MotorPlace,
                     beta2: MotorPlace) -> bool:
    """Compute each motor's share; whether the motors feel and make every tilt."""
    platform.begin()
    platform.add(alpha1)
    platform.add(alpha2)
    platform.add(beta1)
    platform.add(beta2)
    if not platform.solvable():
        return False
    platform.share(alpha1)
    platform.share(alpha2)
    platform.share(beta1)
    platform.share(beta2)
    return True


def measure_tilts(tilts: TiltMeasurement, alpha1: MotorPlace, alpha2: MotorPlace, beta1: MotorPlace,
                  beta2: MotorPlace) -> bool:
    """Compute the air gap at the centre and the tilts from the gaps at the motors; whether all were measured."""
    tilts.clear()
    tilts.add(alpha1, alpha1.gap_measured)
    tilts.add(alpha2, alpha2.gap_measured)
    tilts.add(beta1, beta1.gap_measured)
    tilts.add(beta2, beta2.gap_measured)
    return not (alpha1.gap_measured <= 0.0 or alpha2.gap_measured <= 0.0 or beta1.gap_measured <= 0.0
                or beta2.gap_measured <= 0.0)
