"""Reference signals of a scenario, with their analytic time derivatives.

Sines and powers are those of `math`, so that a signal is the same on every machine with the same C library: NumPy has
others on some processors. That goes for sums, too: the bare `sum` has compensated the rounding of floats since
Python 3.12, and did not before.
"""

import math
from abc import abstractmethod
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, PrivateAttr, ValidationInfo, field_validator, model_validator

from maglev.csv_table import read_csv
from maglev.errors import CsvError, QuantityError, nearest
from maglev.schema.toml_table import Radians, Seconds, Table, key_refused
from maglev.units import parse_quantity, read_quantity, si_unit

Array = NDArray[np.float64]

TIME_TOLERANCE = 1e-9   # s; a step at a multiple of the communication step must not be missed by rounding

RadiansPerSecond = Annotated[float, BeforeValidator(lambda value: parse_quantity(value, "rad/s"))]


class SignalTable(Table):
    """What all signals have: the inputs they feed, and a unit for plain numbers.

    Text carries its own unit, of the same dimension. Without `unit` plain numbers are SI, and the first text
    decides the dimension.
    """

    to: str
    rate_to: str | None = None
    unit: str | None = None

    @model_validator(mode="before")
    @classmethod
    def unit_of_text(cls, table: Any) -> Any:
        """Without `unit`, use the SI unit of the first text among the values."""
        if not isinstance(table, dict) or "unit" in table:
            return table
        for value in values_of(table):
            if isinstance(value, str):
                try:
                    return {**table, "unit": si_unit(str(read_quantity(value).unit))}
                except QuantityError:
                    return table   # refused with its key when the field itself is read
        return table

    @field_validator("unit")
    @classmethod
    def known_unit(cls, unit: str | None) -> str | None:
        """Refuse an unknown unit."""
        if unit is not None:
            si_unit(unit)
        return unit

    @abstractmethod
    def values_at(self, times: Array) -> Array:
        """Return the values at times (s), shape (n,), SI."""

    def rates_at(self, times: Array) -> Array:
        """Return the time derivatives at times (s), shape (n,), SI; at a jump none."""
        return np.zeros(len(times))

    def value(self, t: float) -> float:
        """Return the value at time t (s), SI."""
        return float(self.values_at(np.array([t]))[0])

    def rate(self, t: float) -> float:
        """Return the time derivative at time t (s), SI."""
        return float(self.rates_at(np.array([t]))[0])


class Constant(SignalTable):
    """One value at all times."""

    kind: Literal["constant"]
    level: float = Field(alias="value")

    @field_validator("level", mode="before")
    @classmethod
    def to_si(cls, value: Any, info: ValidationInfo) -> float:
        """Convert to SI."""
        return parse_quantity(value, info.data.get("unit"))

    def values_at(self, times: Array) -> Array:
        """Return the values at times (s), shape (n,), SI."""
        return np.full(len(times), self.level)


class Steps(SignalTable):
    """Piecewise constant: values[i] from times[i] on, values[0] before; true and false for what is Boolean."""

    kind: Literal["steps"]
    times: list[Seconds] = Field(min_length=1)
    values: list[bool | float]

    @field_validator("values", mode="before")
    @classmethod
    def to_si(cls, values: Any, info: ValidationInfo) -> list[bool | float]:
        """Convert to SI."""
        if not isinstance(values, list):
            raise ValueError("expected a list of values")
        return [value if isinstance(value, bool) else entry_to_si(value, info.data.get("unit"), i)
                for i, value in enumerate(values)]

    @model_validator(mode="after")
    def match_times(self) -> "Steps":
        """Refuse times that do not ascend, and values that are not one for each time."""
        for i, (earlier, later) in enumerate(pairwise(self.times)):
            if later <= earlier:
                raise key_refused(i + 1, later, f"expected ascending times, the one before is {earlier}", "times")
        if len(self.values) != len(self.times):
            raise key_refused("values", self.values,
                              f"expected as many as times, {len(self.times)}, got {len(self.values)}")
        return self

    def values_at(self, times: Array) -> Array:
        """Return the values at times (s), shape (n,), SI."""
        after = np.searchsorted(self.times, times + TIME_TOLERANCE, side="right")
        return np.array(self.values, dtype=np.float64)[np.maximum(after - 1, 0)]


class Term(Table):
    """One sinusoid: amplitude · sin(omega t + phase)."""

    amplitude: float
    omega: RadiansPerSecond
    phase: Radians = 0.0


class Sinusoids(SignalTable):
    """Offset plus a sum of sinusoids, whose amplitude is ramped in by 3 s² − 2 s³, s = t/ramp."""

    kind: Literal["sinusoids"]
    offset: float = 0.0
    terms: list[Term] = Field(min_length=1)
    ramp: Annotated[Seconds, Field(ge=0.0)] = 0.0

    @field_validator("offset", mode="before")
    @classmethod
    def offset_to_si(cls, value: Any, info: ValidationInfo) -> float:
        """Convert to SI."""
        return parse_quantity(value, info.data.get("unit"))

    @field_validator("terms", mode="before")
    @classmethod
    def amplitudes_to_si(cls, terms: Any, info: ValidationInfo) -> Any:
        """Convert the amplitudes, whose unit stands outside the terms, to SI."""
        if not isinstance(terms, list):
            raise ValueError("expected a list of terms")
        return [{**terms[i], "amplitude": entry_to_si(terms[i]["amplitude"], info.data.get("unit"), i, "amplitude")}
                if isinstance(terms[i], dict) and "amplitude" in terms[i] else terms[i] for i in range(len(terms))]

    def values_at(self, times: Array) -> Array:
        """Return the values at times (s), shape (n,), SI."""
        return self.offset + self.ramped(self.envelope, 1.0, times) * self.oscillation(math.sin, times)

    def rates_at(self, times: Array) -> Array:
        """Return the time derivatives at times (s), shape (n,), SI."""
        return (self.ramped(self.envelope_rate, 0.0, times) * self.oscillation(math.sin, times)
                + self.ramped(self.envelope, 1.0, times) * self.oscillation(math.cos, times))

    def oscillation(self, function: Callable[[float], float], times: Array) -> Array:
        """Return the sum of the terms at times (s), shape (n,): of sines, or of cosines for its time derivative."""
        terms = []
        for term in self.terms:
            waves = np.array(list(map(function, (term.omega * times + term.phase).tolist())))
            terms.append((term.amplitude if function is math.sin else term.amplitude * term.omega) * waves)
        if len(terms) == 1:
            return terms[0] + 0.0   # as fsum, without negative zeros
        return np.array(list(map(math.fsum, zip(*(values.tolist() for values in terms), strict=True))))

    def ramped(self, function: Callable[[float], float], after: float, times: Array) -> Array:
        """Return a function of time (s) at times, shape (n,), that is constant after the ramp."""
        found = np.full(len(times), after)
        ramping = times < self.ramp
        found[ramping] = [function(t) for t in times[ramping].tolist()]
        return found

    def envelope(self, t: float) -> float:
        """Return the factor on the amplitude at time t (s) of the ramp, 0 to 1."""
        s = max(t, 0.0) / self.ramp
        return 3.0 * s**2 - 2.0 * s**3

    def envelope_rate(self, t: float) -> float:
        """Return the time derivative of the envelope at time t (s) of the ramp, 1/s."""
        s = max(t, 0.0) / self.ramp
        return (6.0 * s - 6.0 * s**2) / self.ramp


class Csv(SignalTable):
    """A column of a CSV file over its first column, time in s: linear between rows, held beyond both ends."""

    kind: Literal["csv"]
    file: str
    column: str
    _times: list[float] = PrivateAttr()
    _values: list[float] = PrivateAttr()

    @model_validator(mode="after")
    def read(self) -> "Csv":
        """Read the file."""
        try:
            table = read_csv(Path(self.file))
            if self.column not in table.names[1:]:
                raise key_refused("column", self.column,
                                  f"no such column in {self.file}, nearest is {nearest(self.column, table.names[1:])}")
            self._times = table.column(table.names[0]).tolist()
            self._values = [parse_quantity(value, self.unit) for value in table.column(self.column).tolist()]
        except CsvError as error:
            raise key_refused("file", self.file, error.problem) from None
        for i, (earlier, later) in enumerate(pairwise(self._times)):
            if later <= earlier:
                raise key_refused("file", self.file, f"row {i + 3} has time {later}, expected more than {earlier}")
        return self

    def values_at(self, times: Array) -> Array:
        """Return the values at times (s), shape (n,), SI."""
        known, values = np.array(self._times), np.array(self._values)
        row = self.rows_at(times)
        inside = values[row] + self.rates_at(times) * (times - known[row])
        return np.asarray(np.where(times <= known[0], values[0], np.where(times >= known[-1], values[-1], inside)))

    def rates_at(self, times: Array) -> Array:
        """Return the slopes at times (s), shape (n,), SI; at a row that of the segment after it."""
        slopes = np.append(np.diff(self._values) / np.diff(self._times), 0.0)
        return np.asarray(np.where(times < self._times[0], 0.0, slopes[self.rows_at(times)]))

    def rows_at(self, times: Array) -> NDArray[np.intp]:
        """Return the latest row at each time (s), shape (n,); the first before it."""
        return np.maximum(np.searchsorted(self._times, times, side="right") - 1, 0)


Signal = Annotated[Constant | Steps | Sinusoids | Csv, Field(discriminator="kind")]


def values_of(table: dict[str, Any]) -> list[Any]:
    """Return all that `unit` applies to in the table of a signal."""
    values = table.get("values")
    terms = table.get("terms")
    return [table.get("value"), table.get("offset"), *(values if isinstance(values, list) else []),
            *(term.get("amplitude") for term in (terms if isinstance(terms, list) else []) if isinstance(term, dict))]


def entry_to_si(value: object, unit: str | None, *keys: str | int) -> float:
    """Convert an entry of a list to SI; a refusal names the keys below that list."""
    try:
        return parse_quantity(value, unit)
    except QuantityError as error:
        raise key_refused(keys[-1], value, str(error), *keys[:-1]) from None
