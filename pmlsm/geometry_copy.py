"""One motor for two models of it, which have each its parameters."""

from pmlsm.magnet_field import MagnetField
from pmlsm.motor_geometry import MotorGeometry


def copy_field(field: MagnetField, other: MagnetField) -> None:
    """Give a field the parameters of another."""
    field.lower = other.lower
    field.upper = other.upper
    field.centre = other.centre
    field.scale = other.scale
    field.B0 = other.B0
    field.B1 = other.B1
    field.B2 = other.B2
    field.B3 = other.B3
    field.B4 = other.B4
    field.B5 = other.B5
    field.B6 = other.B6
    field.B7 = other.B7
    field.B8 = other.B8
    field.B9 = other.B9
    field.B10 = other.B10
    field.B11 = other.B11
    field.B12 = other.B12


def copy_geometry(to: MotorGeometry, of: MotorGeometry) -> None:
    """Give a motor the parameters of another."""
    to.slot_width = of.slot_width
    to.slot_pitch = of.slot_pitch
    to.pole_pitch = of.pole_pitch
    to.magnet_height = of.magnet_height
    to.recoil_permeability = of.recoil_permeability
    copy_field(to.field, of.field)
