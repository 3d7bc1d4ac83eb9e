"""Variables that everything with a model of the motor has."""

from fmi_export.definition import Variable, parameter
from pmlsm.rig import Rig

STATED = "stated, Tables 4.1 and 5.1"

BAD_GEOMETRY = ("geometry.slot_width = {geometry.slot_width} m, geometry.slot_pitch = {geometry.slot_pitch} m, "
                "geometry.field.lower = {geometry.field.lower} m, geometry.field.upper = {geometry.field.upper} m, "
                "expected slots narrower than their pitch, and gaps from a lower to an upper one")


# Parameters of the geometry of a motor: unit, meaning, source, lowest and highest value.
GEOMETRY = {
    "slot_width": ("m", "width b0 of the slots", STATED, 1e-5, 0.1),
    "slot_pitch": ("m", "pitch t1 of the slots", STATED, 1e-4, 1.0),
    "pole_pitch": ("m", "pole pitch τ", STATED, 1e-3, 1.0),
    "magnet_height": ("m", "height hm of the magnets", STATED, 1e-5, 0.1),
    "recoil_permeability": ("", "recoil permeability µrec of the magnets, relative", "assumed", 0.1, 100.0),
    "field.lower": ("m", "smallest air gap of the field's polynomial; smaller ones count as this", "assumed", 1e-4,
                    0.1),
    "field.upper": ("m", "largest air gap of the field's polynomial; larger ones count as this", "assumed", 1e-4,
                    0.1),
    "field.centre": ("m", "air gap at which s = 0 in the field's polynomial, the sum of B_k s^k", "assumed", 0.0, 0.1),
    "field.scale": ("m", "distance from the centre to s = 1", "assumed", 1e-4, 1.0),
    **{f"field.B{k}": ("T", f"coefficient of s^{k} in the field B over the air gap",
                       "assumed: fitted to the thesis's figures", -10.0, 10.0) for k in range(13)}}


def motor_geometry(rig: Rig) -> tuple[Variable, ...]:
    """Geometry of the motors, and the field of their magnets over the air gap."""
    return tuple(
        parameter(f"geometry.{name}", unit, text, rig.source(f"geometry.{name}") if name in rig.geometry else source,
                  low, high, 1e-2, fixed=True) for name, (unit, text, source, low, high) in GEOMETRY.items())
