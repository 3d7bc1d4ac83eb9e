"""The motor of both stages."""

from pmlsm.motor_geometry import MotorGeometry

MOTOR = MotorGeometry()
