"""Units of the variables as FMI defines them: exponents of the SI base units."""

import re
from collections.abc import Mapping
from functools import lru_cache

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

# Exponents of the SI base units by the symbols that a unit can be made of.
SYMBOLS: dict[str, dict[str, int]] = {
    **{base: {base: 1} for base in BASE_UNITS},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "C": {"s": 1, "A": 1},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "S": {"kg": -1, "m": -2, "s": 3, "A": 2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "F": {"kg": -1, "m": -2, "s": 4, "A": 2},
    "Wb": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "T": {"kg": 1, "s": -2, "A": -1},
    "Hz": {"s": -1},
}

WORD = re.compile(r"\s*(?:([./()])|([^\W\d_]+|1)(-?\d+)?)")


class UnknownUnit(ValueError):
    """A unit that is not made of `SYMBOLS`."""


@lru_cache(maxsize=512)
def factors(unit: str) -> tuple[tuple[str, int], ...]:
    """Symbols and powers of a unit: m and 1, s and -2, A and -1 of "m/(s2.A)"; UnknownUnit if it cannot be read."""
    found: list[tuple[str, int]] = []
    signs, next_sign, place, expects_symbol = [1], 1, 0, True
    while place < len(unit.rstrip()):
        match = WORD.match(unit, place)
        if match is None or (match[1] != "(" and match[2] is None) == expects_symbol:
            raise UnknownUnit(unit)
        place = match.end()
        if match[1] == "(":
            signs.append(signs[-1] * next_sign)
            next_sign = 1
        elif match[1] == ")":
            signs.pop()
            if not signs:
                raise UnknownUnit(unit)
        elif match[1] is not None:
            next_sign, expects_symbol = -1 if match[1] == "/" else 1, True
        else:
            if match[2] != "1":
                found.append((match[2], signs[-1] * next_sign * int(match[3] or 1)))
            next_sign, expects_symbol = 1, False
    if expects_symbol or len(signs) > 1:
        raise UnknownUnit(unit)
    return tuple(found)


def exponents(unit: str) -> dict[str, int]:
    """Exponents of the SI base units, in the order of FMI, of a unit made of `SYMBOLS`; UnknownUnit of another."""
    total = dict.fromkeys(BASE_UNITS, 0)
    for symbol, power in factors(unit):
        if symbol not in SYMBOLS:
            raise UnknownUnit(unit)
        for base, exponent in SYMBOLS[symbol].items():
            total[base] += power * exponent
    return {base: exponent for base, exponent in total.items() if exponent}


def unit_text(powers: Mapping[str, int]) -> str:
    """Return a unit with these exponents: a single symbol if there is one, or a product such as "kg/(m.s2)"."""
    found = {base: power for base, power in powers.items() if power}
    for symbol, made_of in SYMBOLS.items():
        if made_of == found and symbol not in ("Hz", "J"):   # 1/s need not be cycles, nor N.m an energy
            return symbol
    above, below = ([f"{base}{abs(power)}".removesuffix("1") for base, power in found.items() if sign * power > 0]
                    for sign in (1, -1))
    divided = f"/({'.'.join(below)})" if len(below) > 1 else f"/{below[0]}" if below else ""
    return f"{'.'.join(above) or '1'}{divided}"


# A second unit for the eye of the importing tool: name and factor from the SI unit.
DISPLAY_UNITS: dict[str, tuple[str, float]] = {"m": ("mm", 1000.0), "rad": ("mrad", 1000.0)}

RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def typeset_unit(unit: str) -> str:
    """A unit as people read it, m/(s²·T²) of "m/(s2.T2)", µm of "um"."""
    raised = re.sub(r"(?<=[A-Za-z])\d+", lambda power: power[0].translate(RAISED), unit)
    return re.sub(r"\bu(?=[A-Za-z])", "µ", raised).replace(".", "·")
