"""Quantities with units: numbers are SI, text such as "25 mm", "-4 A" or "3 V/s" is converted to SI.

A unit is one of `UNITS`, or is made of these: "mV.s/rad", "kg.m2", "1/s3", "m/(s2.A)". A point, a blank or · stands
between factors, a slash before each divisor. Powers are written as "m2", "m²", "m^2" or "s-1".
"""

import math
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from decimal import Decimal
from difflib import get_close_matches
from functools import lru_cache
from typing import Any, NamedTuple

from maglev.files.errors import MaglevError, QuantityError, shortened
from maglev.files.fmi_units import UnknownUnit, exponents, factors, unit_text

PREFIXES = {"n": 1e-9, "u": 1e-6, "µ": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6}

# Unit: the SI unit it converts to, and the factor.
UNITS = {
    "m": ("m", 1.0), "cm": ("m", 1e-2), "mm": ("m", 1e-3), "um": ("m", 1e-6), "µm": ("m", 1e-6), "nm": ("m", 1e-9),
    "s": ("s", 1.0), "ms": ("s", 1e-3), "us": ("s", 1e-6), "µs": ("s", 1e-6), "ns": ("s", 1e-9),
    "min": ("s", 60.0), "h": ("s", 3600.0),
    "kg": ("kg", 1.0), "g": ("kg", 1e-3),
    "rad": ("rad", 1.0), "mrad": ("rad", 1e-3), "urad": ("rad", 1e-6), "µrad": ("rad", 1e-6),
    "deg": ("rad", math.pi / 180.0), "°": ("rad", math.pi / 180.0), "rpm": ("rad/s", math.pi / 30.0),
    "Hz": ("Hz", 1.0), "kHz": ("Hz", 1e3), "MHz": ("Hz", 1e6),
    **{f"{prefix}{symbol}": (symbol, by) for symbol in ("A", "V", "N", "T", "W", "J", "Wb", "H", "F", "Ohm", "C", "Pa")
       for prefix, by in {"": 1.0, **PREFIXES}.items()},
    **{f"{prefix}{symbol}": ("Ohm", by) for symbol in ("ohm", "Ω") for prefix, by in {"": 1.0, **PREFIXES}.items()},
    "K": ("K", 1.0), "bar": ("Pa", 1e5), "Wh": ("J", 3600.0), "Nm": ("N.m", 1.0), "mNm": ("N.m", 1e-3),
    "1": ("1", 1.0), "%": ("1", 1e-2),
}

# Names that are written out, in the singular; and prefixes of them.
WRITTEN_OUT = {"kilo": "kg", "kilogram": "kg", "kilogramme": "kg", "gram": "g", "gramme": "g", "metre": "m",
               "meter": "m", "micron": "um", "second": "s", "sec": "s", "minute": "min", "hour": "h", "ampere": "A",
               "amp": "A", "volt": "V", "newton": "N", "degree": "deg", "radian": "rad", "hertz": "Hz", "tesla": "T",
               "watt": "W", "joule": "J", "kelvin": "K", "weber": "Wb", "henry": "H", "farad": "F", "coulomb": "C",
               "pascal": "Pa", "percent": "%"}
WRITTEN_PREFIXES = {"milli": "m", "micro": "u", "nano": "n", "centi": "c", "kilo": "k", "mega": "M"}

LIKE = 0.5   # least similarity of the nearest unit that is worth a word

LARGEST = sys.float_info.max

MISWRITTEN = re.compile(r"[02-9.,;:'_+\-=<>~|]|/\s*\d")   # that no unit begins with, as 1/s does
DECIMAL_COMMA = re.compile(r"\s*([+-]?\d+),(\d+(?:[eE][+-]?\d+)?(?:\s*[^\W\d_].*?)?)\s*")
WHOLE_NUMBER = re.compile(r"[+-]?\d{1,18}")
FLAGS = ("on", "off", "yes", "no", "true", "false")   # by which people mean a Boolean
NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(pi\b|π)?\s*(.*?)\s*")


class Quantity(NamedTuple):
    """A number in SI and the unit it was written in, None for a plain number."""

    value: float
    unit: str | None


class Unit(NamedTuple):
    """The SI unit that a unit converts to, the factor, and the dimension: exponents of SI base units, and cycles."""

    si: str
    factor: float
    dimension: tuple[tuple[str, int], ...]


@lru_cache(maxsize=512)
def unit_of(unit: str) -> Unit:
    """Return a unit; QuantityError, with the nearest unit of the table, if there is no unit of this name."""
    spelled = spelling(unit)
    if spelled in UNITS:
        si, by = UNITS[spelled]
        return Unit(si, by, dimension_of(si))
    try:
        parts = [(UNITS.get(symbol, (symbol, 1.0)), power) for symbol, power in factors(spelled)]
        si = re.sub(r"[^\W\d_]+", lambda match: in_parentheses(UNITS.get(match[0], (match[0],))[0]), spelled)
        dimension = dimension_of(si)
    except (UnknownUnit, KeyError):
        raise QuantityError(f"unknown unit {unit!r}; {like(spelled)}") from None
    return Unit(si, float(math.prod(Decimal(repr(by)) ** power for (_, by), power in parts)), dimension)


def like(unit: str, units: Iterable[str] = UNITS) -> str:
    """Return suggestions for an unknown unit: the symbol of a name written out, the nearest one, or examples."""
    if unit.startswith("/"):
        return f"nearest is '1{unit}'"
    if (symbol := written_out(unit)) is not None:
        return f"nearest is {symbol!r}"
    known = list(units)
    found = [each for each in known if each.lower() == unit.lower()] or get_close_matches(unit, known, 1, LIKE)
    return f"nearest is {found[0]!r}" if found else "expected one such as 'kg', 'mm', 'N', 'A', 's', 'rad'"


def written_out(name: str) -> str | None:
    """Symbol of a unit that is written out, such as mm of "Millimetres"; None of any other word."""
    word = name.lower().removesuffix("s")
    return WRITTEN_OUT.get(word) or next(
        (prefix + WRITTEN_OUT[word.removeprefix(name)] for name, prefix in WRITTEN_PREFIXES.items()
         if word.startswith(name) and word.removeprefix(name) in WRITTEN_OUT), None)


def in_parentheses(si: str) -> str:
    """Return an SI unit in a form that can follow a division."""
    return f"({si})" if re.search(r"[./]", si) else si


def measures(unit: str, expected: str) -> bool:
    """Return True if a unit has the dimension of another; an unknown one only has that of its own name."""
    one, other = known_unit(unit), known_unit(expected)
    return unit == expected or (one is not None and other is not None and one.dimension == other.dimension)


@lru_cache(maxsize=512)
def known_unit(unit: str | None) -> Unit | None:
    """The same; None of no unit, and of an unknown one."""
    try:
        return None if unit is None else unit_of(unit)
    except QuantityError:
        return None


def spelling(unit: str) -> str:
    """A unit with points between factors, plain powers, and the micro sign of the table, of two that look like it."""
    spelled = unit.strip().replace("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}").translate(POWERS)
    spelled = re.sub(r"\^|\*\*(?=[-\d])", "", spelled)
    return re.sub(r"\s*[·*⋅]\s*|(?<=[\w)])\s+(?=[\w(])", ".", spelled)


POWERS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def unit_of_powers(powers: Mapping[str, int], by: float) -> Unit:
    """Return the unit with these exponents of the SI base units, and how many of that unit they make."""
    si = unit_text(powers)
    return Unit(si, by, dimension_of(si))


def dimension_of(si: str) -> tuple[tuple[str, int], ...]:
    """Dimension of an SI unit. A frequency in Hz counts cycles: it is no rate in 1/s or rad/s, which differ by 2 π."""
    cycles = sum(power for symbol, power in factors(si) if symbol == "Hz")
    return (*exponents(si).items(), *([("cycle", cycles)] if cycles else []))


def own_number(value: object) -> Any:
    """Return a NumPy number, or an array without dimensions, as a Python number; anything else unchanged."""
    return value.item() if getattr(value, "shape", None) == () else value   # type: ignore[attr-defined]


def read_quantity(value: object, unit: str | None = None) -> Quantity:
    """Read a quantity of a scenario file: its value in SI, and the unit of the text (None for a plain number).

    A plain number is in `unit`; without one it is SI. Text carries its own unit, as in "25 mm", of the dimension of
    `unit`, if there is one; "1.5 pi rad/s" is 1.5 π rad/s. QuantityError if the value is not a finite number, has no or
    an unknown unit, or is of another dimension than `unit`.
    """
    value = own_number(value)
    if isinstance(value, str):
        quantity = read_text(value)
        if unit is not None and unit_of(str(quantity.unit)).dimension != unit_of(unit).dimension:
            raise QuantityError(f"{value!r} is in {quantity.unit}, expected a quantity in {unit}")
        return quantity
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise QuantityError(f"{value!r} is not a quantity, expected a number or text such as '25 mm'")
    if not abs(value) <= LARGEST:   # a whole number can be too large for a float, and no float is NaN
        raise QuantityError(f"{value!r} is not a quantity, expected a finite number")
    return Quantity(float(value) if unit is None else exact_product(float(value), unit_of(unit).factor), None)


def read_text(text: str) -> Quantity:
    """Read a number with its unit."""
    number, unit = split_text(text)
    with refused_as(QuantityError, repr(text)):
        value = exact_product(number, unit_of(unit).factor)
    if not math.isfinite(value):
        raise QuantityError(f"{text!r} is not a quantity, expected a finite number")
    return Quantity(value, unit)


def split_text(text: str) -> tuple[float, str]:
    """Number of a text, and its unit, known or not; QuantityError if it has none."""
    match = NUMBER_AND_UNIT.fullmatch(with_hyphen(text))
    if match is None:
        flag = "; of a Boolean true or false" if text.strip().lower() in FLAGS else ""
        raise QuantityError(f"{text!r} is not a quantity, expected a number and a unit such as '25 mm'{flag}")
    digits, pi, unit = match.groups()
    if MISWRITTEN.match(unit) and not pi:
        raise QuantityError(f"{text!r} is not a quantity, expected {well_written(text)}")
    if not unit:
        raise QuantityError(f"{text!r} has no unit, expected a number without quotes or a unit such as '25 mm'")
    return float(digits) * math.pi if pi else float(digits), unit


def with_hyphen(text: str) -> str:
    """A text with a hyphen for each minus sign U+2212, as typeset pages and spreadsheets have it."""
    return text.replace("\N{MINUS SIGN}", "-")


def well_written(text: str) -> str:
    """Return the expected form for a text whose number is followed by text that is no unit."""
    comma = DECIMAL_COMMA.fullmatch(text)
    if comma is not None:
        return f"a decimal point: '{comma[1]}.{comma[2]}'"
    return "one number, such as 3.5, or with a unit, such as '25 mm'"


def exact_product(number: float, by: float) -> float:
    """Multiply as on paper: "25 mm" becomes exactly the number that 0.025 is."""
    if not math.isfinite(number):
        return number
    return float(Decimal(repr(number)) * Decimal(repr(by)))


def exact_quotient(number: float, by: float) -> float:
    """Divide as on paper."""
    return float(Decimal(repr(number)) / Decimal(repr(by))) if math.isfinite(number) else number


def parse_quantity(value: object, unit: str | None = None) -> float:
    """Return the SI value of a quantity; see `read_quantity`."""
    return read_quantity(value, unit).value


@contextmanager
def refused_as(error: type[MaglevError], place: str) -> Iterator[None]:
    """Turn errors about quantities in a block into an error that begins with their place."""
    try:
        yield
    except QuantityError as wrong:
        raise error(f"{place}: {wrong}") from None


def positive_time(value: object, error: type[MaglevError], place: str) -> float:
    """A time above 0 (s) as an option has it, also as text without a unit; an error that begins with its place."""
    with refused_as(error, place):
        found = parse_quantity(number_or_text(value) if isinstance(value, str) else value, "s")
    if found <= 0.0:
        raise error(f"{place}: expected a time above 0 s")
    return found


def whole_number(value: object, error: type[MaglevError], name: str, least: int = 1, most: int | None = None) -> int:
    """A whole number, Python's or NumPy's, from the least to the most; an error that begins with its name."""
    number = own_number(value)
    if type(number) is not int or number < least or (most is not None and number > most):
        wanted = f"from {least} on" if most is None else f"from {least} to {most}"
        raise error(f"{name} = {shortened(value)}, expected a whole number {wanted}")
    return number


def to_unit(value: float, unit: str) -> float:
    """Convert an SI value to `unit`.

    QuantityError if the unit is unknown; the message names the value and the nearest known unit.
    """
    with refused_as(QuantityError, f"cannot convert {value!r}"):
        by = unit_of(unit).factor
    return exact_quotient(float(value), by)


def is_finite(text: str) -> bool:
    """Return True if a text is a finite number, as Python writes it."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def number_or_text(text: str) -> float | int | str:
    """Read a plain number where a command line gives one; anything else, such as a number with a unit, stays text."""
    number = with_hyphen(text)
    try:
        return int(number) if WHOLE_NUMBER.fullmatch(number) else float(number)
    except ValueError:
        return text
