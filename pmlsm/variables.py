"""Variables that everything with a model of the motor has."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from maglev.fmi.definition import Variable, parameter
from pmlsm.stage_description import StageDescription

STATED = "stated, Tables 4.1 and 5.1"

BOUNDS = ("slot_width", "slot_pitch", "field.lower", "field.upper")   # of a geometry that can be wrong

RATIOS = {"thrust": "constant of the thrust", "attraction": "constant of the attraction",
          "coils": "constant of the normal force of the coils", "iron": "constant of the normal force of the iron",
          "limit": "largest current"}   # of `pmlsm.motor_ratio`
CONSTANTS = tuple(RATIOS)[:4]


# Parameters of the geometry of a motor: unit, meaning, source, lowest and highest value.
GEOMETRY = {
    "slot_width": ("m", "width b0 of the slots", STATED, 1e-5, 0.1),
    "slot_pitch": ("m", "pitch t1 of the slots", STATED, 1e-4, 1.0),
    "pole_pitch": ("m", "pole pitch τ", STATED, 1e-3, 1.0),
    "magnet_height": ("m", "height hm of the magnets", STATED, 1e-5, 0.1),
    "recoil_permeability": ("", "relative recoil permeability µrec of the magnets", "assumed", 0.1, 100.0),
    "field.lower": ("m", "smallest air gap of the field's polynomial, also used for smaller gaps", "assumed", 1e-4,
                    0.1),
    "field.upper": ("m", "largest air gap of the field's polynomial, also used for larger gaps", "assumed", 1e-4,
                    0.1),
    "field.centre": ("m", "air gap at which s = 0 in the field's polynomial, the sum of B_k s^k", "assumed", 0.0, 0.1),
    "field.scale": ("m", "distance from the centre to s = 1", "assumed", 1e-4, 1.0),
    **{f"field.B{k}": ("T", f"coefficient of s^{k} in the polynomial of the field B",
                       "assumed: fitted to the thesis's figures", -10.0, 10.0) for k in range(13)}}


def motor_geometry(stage: StageDescription, *ratios: str) -> tuple[Variable, ...]:
    """Geometry of the motors, and the field of their magnets over the air gap.

    Of a motor that is unlike the others its own, and some of the ratios of its constants to theirs.
    """
    collected = [*geometry("", "", stage.geometry, stage)]
    for motor in stage.unlike:
        name, of = motor.name, motor.kind.geometry if motor.kind is not None else {}
        collected += [replace(parameter(f"{name}.{ratio}_ratio", "", f"ratio of the {RATIOS[ratio]} of {name} to "
                                        "that of the ordinary motors", stage.source(f"motors.{name}"),
                                        1e-6, 1e6, 1.0),
                              path=f"{name}_ratio.{ratio}") for ratio in ratios]
        collected += geometry(f"{name}.", f"{name}_", of, stage)
    return tuple(collected)


def geometry(owner: str, path: str, given: Mapping[str, float], stage: StageDescription) -> Iterator[Variable]:
    """Parameters of a geometry with a word before their names, and before their paths in the block."""
    place = f"motors.{owner}geometry" if owner else "geometry"
    for name, (unit, text, source, low, high) in GEOMETRY.items():
        variable = parameter(f"{owner}geometry.{name}", unit, text,
                             stage.source(f"{place}.{name}") if name in given else source, low, high, 1e-2, fixed=True)
        yield replace(variable, path=f"{path}geometry.{name}" if path else "")


def bad_geometry(stage: StageDescription) -> str:
    """Refusal of an impossible motor geometry."""
    owners = ["", *(f"{motor.name}." for motor in stage.unlike)]
    given = ", ".join(f"{owner}geometry.{name} = {{{owner}geometry.{name}}} m" for owner in owners for name in BOUNDS)
    return f"{given}, expected slots narrower than their pitch, and gaps from a lower to an upper one"
