"""Units of the variables as FMI defines them: exponents of the SI base units."""

import re

UNITS: dict[str, dict[str, int]] = {
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "s": {"s": 1},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "A": {"A": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "kg": {"kg": 1},
    "kg.m2": {"kg": 1, "m": 2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "N.m.s": {"kg": 1, "m": 2, "s": -1},
    "N.m/rad": {"kg": 1, "m": 2, "s": -2, "rad": -1},
    "N/m": {"kg": 1, "s": -2},
    "N.s/m": {"kg": 1, "s": -1},
    "m/(s2.A)": {"m": 1, "s": -2, "A": -1},
    "m/(s2.A2)": {"m": 1, "s": -2, "A": -2},
    "m/(s2.T2)": {"kg": -2, "m": 1, "s": 2, "A": 2},
    "m/(s2.A.T)": {"kg": -1, "m": 1},
    "1/s": {"s": -1},
    "1/s2": {"s": -2},
    "1/s3": {"s": -3},
    "1/s4": {"s": -4},
    "1/s5": {"s": -5},
    "m.s2/A": {"m": 1, "s": 2, "A": -1},
    "m.s/A": {"m": 1, "s": 1, "A": -1},
    "m/A": {"m": 1, "A": -1},
    "rad.m.s2/A": {"m": 1, "s": 2, "A": -1, "rad": 1},
    "rad.m.s/A": {"m": 1, "s": 1, "A": -1, "rad": 1},
    "rad.m/A": {"m": 1, "A": -1, "rad": 1},
    "A/m": {"m": -1, "A": 1},
    "A/(m.s)": {"m": -1, "s": -1, "A": 1},
    "A.s/m": {"m": -1, "s": 1, "A": 1},
    "A/(m.rad)": {"m": -1, "A": 1, "rad": -1},
    "A/(m.rad.s)": {"m": -1, "s": -1, "A": 1, "rad": -1},
    "A.s/(m.rad)": {"m": -1, "s": 1, "A": 1, "rad": -1},
    "A2.s": {"s": 1, "A": 2},
    "A4.s": {"s": 1, "A": 4},
    "A2.T2.s": {"kg": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "K": {"K": 1},
    "K/W": {"kg": -1, "m": -2, "s": 3, "K": 1},
    "T": {"kg": 1, "s": -2, "A": -1},
    "T4.s": {"kg": 4, "s": -7, "A": -4},
}

# A second unit for the eye of the importing tool: name and factor from the SI unit.
DISPLAY_UNITS: dict[str, tuple[str, float]] = {"m": ("mm", 1000.0), "rad": ("mrad", 1000.0)}

RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def typeset_unit(unit: str) -> str:
    """A unit as people read it, m/(s²·T²) of "m/(s2.T2)"."""
    return re.sub(r"(?<=[A-Za-z])\d+", lambda power: power[0].translate(RAISED), unit).replace(".", "·")
