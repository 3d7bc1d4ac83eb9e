"""Quantities with units: numbers are SI, text such as "25 mm" or "-4 A" is converted to SI."""

import math
import re
import sys
from decimal import Decimal
from typing import NamedTuple

from maglev.errors import QuantityError, nearest

# Unit: the SI unit it converts to, and the factor.
UNITS = {
    "m": ("m", 1.0), "cm": ("m", 1e-2), "mm": ("m", 1e-3), "um": ("m", 1e-6), "µm": ("m", 1e-6), "nm": ("m", 1e-9),
    "s": ("s", 1.0), "ms": ("s", 1e-3), "us": ("s", 1e-6), "µs": ("s", 1e-6), "min": ("s", 60.0),
    "kg": ("kg", 1.0), "g": ("kg", 1e-3),
    "A": ("A", 1.0), "mA": ("A", 1e-3), "uA": ("A", 1e-6), "µA": ("A", 1e-6),
    "N": ("N", 1.0), "mN": ("N", 1e-3), "kN": ("N", 1e3),
    "V": ("V", 1.0), "mV": ("V", 1e-3), "Ohm": ("Ohm", 1.0), "Ω": ("Ohm", 1.0), "H": ("H", 1.0), "mH": ("H", 1e-3),
    "K": ("K", 1.0), "K/W": ("K/W", 1.0), "W": ("W", 1.0),
    "T": ("T", 1.0), "mT": ("T", 1e-3),
    "N/A": ("N/A", 1.0), "A/m": ("A/m", 1.0), "kA/m": ("A/m", 1e3),
    "m/s": ("m/s", 1.0), "mm/s": ("m/s", 1e-3),
    "m/s2": ("m/s2", 1.0), "m/s²": ("m/s2", 1.0), "mm/s2": ("m/s2", 1e-3), "mm/s²": ("m/s2", 1e-3),
    "N/m": ("N/m", 1.0), "kN/m": ("N/m", 1e3), "N/mm": ("N/m", 1e3),
    "N.s/m": ("N.s/m", 1.0), "N s/m": ("N.s/m", 1.0),
    "kg.m2": ("kg.m2", 1.0), "N.m": ("N.m", 1.0), "mN.m": ("N.m", 1e-3), "N.m.s": ("N.m.s", 1.0),
    "N.m/rad": ("N.m/rad", 1.0), "rad/s2": ("rad/s2", 1.0), "mrad": ("rad", 1e-3), "urad": ("rad", 1e-6),
    "µrad": ("rad", 1e-6), "mrad/s": ("rad/s", 1e-3),
    "rad": ("rad", 1.0), "deg": ("rad", math.pi / 180.0), "°": ("rad", math.pi / 180.0),
    "rad/s": ("rad/s", 1.0), "Hz": ("Hz", 1.0), "kHz": ("Hz", 1e3),
    "m.s": ("m.s", 1.0), "m s": ("m.s", 1.0), "mm s": ("m.s", 1e-3), "um s": ("m.s", 1e-6), "µm s": ("m.s", 1e-6),
    "rad.s": ("rad.s", 1.0), "mrad s": ("rad.s", 1e-3), "urad s": ("rad.s", 1e-6), "µrad s": ("rad.s", 1e-6),
    "A2.s": ("A2.s", 1.0), "A² s": ("A2.s", 1.0),
    "1": ("1", 1.0), "%": ("1", 1e-2),
}

LARGEST = sys.float_info.max

WHOLE_NUMBER = re.compile(r"[+-]?\d{1,18}")
NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(pi\b|π)?\s*(.*?)\s*")


class Quantity(NamedTuple):
    """A number in SI and the unit it was written in, None for a plain number."""

    value: float
    unit: str | None


def si_unit(unit: str) -> str:
    """Return the SI unit that `unit` converts to.

    Raises
    ------
    QuantityError
        If the unit is unknown; the message names the nearest known one.
    """
    # Two code points look like µ: the micro sign of the table and the Greek letter.
    spelled = unit.replace("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}")
    if spelled not in UNITS:
        raise QuantityError(f"unknown unit {unit!r}; nearest is {nearest(spelled, UNITS)}")
    return UNITS[spelled][0]


def factor(unit: str) -> float:
    """Return how many SI units one `unit` is."""
    si_unit(unit)
    return UNITS[unit.replace("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}")][1]


def read_quantity(value: object, unit: str | None = None) -> Quantity:
    """Read a quantity of a scenario file.

    Parameters
    ----------
    value : float, int or str
        A plain number is in `unit`. Text carries its own unit, as in "25 mm"; "1.5 pi rad/s" is 1.5 π rad/s.
    unit : str, optional
        The unit of plain numbers, and of the dimension that text must have. Without it plain numbers are
        SI and text may have any dimension.

    Returns
    -------
    Quantity
        The value in SI, and the unit of the text (None for a plain number).

    Raises
    ------
    QuantityError
        If the value is not a finite number, has no or an unknown unit, or is of another dimension than `unit`.
    """
    if isinstance(value, str):
        quantity = read_text(value)
        if unit is not None and si_unit(str(quantity.unit)) != si_unit(unit):
            raise QuantityError(f"{value!r} is in {quantity.unit}, expected a quantity in {unit}")
        return quantity
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise QuantityError(f"{value!r} is not a quantity, expected a number or text such as '25 mm'")
    if not abs(value) <= LARGEST:   # a whole number can be too large for a float, and no float is NaN
        raise QuantityError(f"{value!r} is not a quantity, expected a finite number")
    return Quantity(float(value) if unit is None else scaled(float(value), factor(unit)), None)


def read_text(text: str) -> Quantity:
    """Read a number with its unit."""
    match = NUMBER_AND_UNIT.fullmatch(text)
    if match is None:
        raise QuantityError(f"{text!r} is not a quantity, expected a number and a unit such as '25 mm'")
    digits, pi, unit = match.groups()
    number = float(digits) * math.pi if pi else float(digits)
    if not unit:
        raise QuantityError(f"{text!r} has no unit, expected a number without quotes or a unit such as '25 mm'")
    try:
        value = scaled(number, factor(unit))
    except QuantityError as error:
        raise QuantityError(f"{text!r}: {error}") from None
    if not math.isfinite(value):
        raise QuantityError(f"{text!r} is not a quantity, expected a finite number")
    return Quantity(value, unit)


def scaled(number: float, by: float) -> float:
    """Multiply as on paper: "25 mm" becomes exactly the number that 0.025 is."""
    if not math.isfinite(number):
        return number
    return float(Decimal(repr(number)) * Decimal(repr(by)))


def parse_quantity(value: object, unit: str | None = None) -> float:
    """Return the SI value of a quantity; see `read_quantity`."""
    return read_quantity(value, unit).value


def to_unit(value: float, unit: str) -> float:
    """Convert an SI value to `unit`.

    Raises
    ------
    QuantityError
        If the unit is unknown; the message names the value and the nearest known unit.
    """
    try:
        by = factor(unit)
    except QuantityError as error:
        raise QuantityError(f"cannot convert {value!r}: {error}") from None
    if not math.isfinite(value):
        return value
    return float(Decimal(repr(float(value))) / Decimal(repr(by)))


def number_or_text(text: str) -> float | int | str:
    """Read a plain number where a command line gives one; anything else, such as a number with a unit, stays text."""
    try:
        return int(text) if WHOLE_NUMBER.fullmatch(text) else float(text)
    except ValueError:
        return text
