"""The motor of both rigs."""

from pmlsm.motor_geometry import MotorGeometry

MOTOR = MotorGeometry()
