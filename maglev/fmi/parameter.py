"""Parameters with values from outside: one check of name, value and unit, and one wording of errors."""

from collections.abc import Iterable
from math import inf
from numbers import Real
from typing import NamedTuple, Protocol

from maglev.files.errors import MaglevError, nearest
from maglev.files.units import known_unit, own_number, parse_quantity, refused_as
from maglev.fmi.definition import Variable

REALS = ("Real", "Float64", "Float32")   # types of FMI 2.0 and 3.0
INTEGERS = ("Integer", *(f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)))


class Described(Protocol):
    """A variable as a model description has it; fmpy's ScalarVariable is one."""

    name: str
    causality: str
    variability: str | None
    initial: str | None
    type: str
    unit: str | None
    min: str | None
    max: str | None


class Parameter(NamedTuple):
    """The valid values: true or false, or a number of a unit within a range.

    A unit that is not known here is one that an FMU declares: of it plain numbers are taken, as they are.
    """

    unit: str | None = ""   # None if any value is allowed
    boolean: bool = False
    low: float = -inf
    high: float = inf
    hint: str = ""   # advice for a value that is out of range

    @classmethod
    def of(cls, variable: Variable) -> "Parameter":
        return cls(variable.unit, variable.boolean, variable.low, variable.high, variable.hinted)

    @classmethod
    def described(cls, variable: Described) -> "Parameter":
        return cls(variable.unit or "", variable.type == "Boolean", -inf if variable.min is None else
                   float(variable.min), inf if variable.max is None else float(variable.max))

    @property
    def expected(self) -> str:
        return "true or false" if self.boolean else f"a number{f' of {self.unit}' if self.unit else ''}"

    def read(self, given: object, place: str, error: type[MaglevError]) -> float | bool:
        """Return a given value in SI: a Boolean, a number in SI, or text with a unit.

        An error in one line begins with the place and gives the value and the expected values.
        """
        plain = own_number(given)
        if isinstance(plain, bool) or self.boolean:
            if isinstance(plain, bool) and self.boolean:
                return plain
            raise error(f"{place} = {plain!r}, expected {self.expected}")
        own = self.unit if self.unit is None or self.unit else "1"
        known = known_unit(own)
        if isinstance(plain, str) and own is not None and known is None:
            raise error(f"{place} = {plain!r}, expected a plain number, in {own}")
        with refused_as(error, place):
            value = parse_quantity(float(plain) if isinstance(plain, Real) else plain, own if known else None)
        if not self.low <= value <= self.high and (known is None or known.factor == 1.0):   # a range is in its unit
            unit = f" {self.unit}" if self.unit else ""
            raise error(f"{place} = {value:.9g}{unit}, expected a number from {self.low:g} to {self.high:g}{unit}"
                        f"{self.hint}")
        return value


def expected_of(kind: str, value: object) -> str:
    """Return the values that a variable of a type of FMI expects instead of a value; empty if it fits."""
    boolean = isinstance(value, bool)
    if kind == "Boolean":
        return "" if boolean else "true or false"
    if kind in (*INTEGERS, "Enumeration"):
        low, high = range_of(kind)
        fits = isinstance(value, int) and not boolean and low <= value <= high
        return "" if fits else "a whole number" if not isinstance(value, int) or boolean else (
            f"a whole number from {low} to {high}")
    if kind == "String":
        return "" if isinstance(value, str) and "\0" not in value else "a text"
    if kind not in REALS:
        return "a variable that is Real, Integer, Boolean, String or Enumeration"
    return "" if isinstance(value, int | float) and not boolean else "a number"


def range_of(kind: str) -> tuple[int, int]:
    """Least and largest number of a type of whole numbers; Integer is Int32."""
    bits = {"Integer": 32, "Enumeration": 64}.get(kind) or int(kind.partition("Int")[2])
    return (0, (1 << bits) - 1) if kind.startswith("U") else (-(1 << bits - 1), (1 << bits - 1) - 1)


def require_parameter(name: str, known: Iterable[str], owner: str, error: type[MaglevError]) -> None:
    """Raise if no parameter of the owner has a name; the error has the nearest name."""
    valid = list(known)
    if name not in valid:
        raise error(f"{owner} has no parameter {name!r}; {nearest(name, valid)}")
