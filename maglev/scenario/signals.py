"""Reference signals of a scenario, with their analytic time derivatives.

A signal has the same bits on every machine, and in a browser: its sines are those of the blocks, and there is no power.
"""

from abc import abstractmethod
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, PrivateAttr, ValidationInfo, field_validator, model_validator

from maglev.files.arrays import Array
from maglev.files.errors import CsvError, QuantityError, nearest
from maglev.files.table import DataTable, read_table
from maglev.files.table_times import time_column, times_of
from maglev.files.units import (
    Unit,
    exact_product,
    known_unit,
    like,
    measures,
    parse_quantity,
    read_quantity,
    split_text,
    unit_of,
)
from maglev.scenario.layers import items
from maglev.scenario.toml_table import Radians, Seconds, Table, ValueKind, key_refused
from maglev.scenario.waves import sines_cosines

IN_UNIT = ("level", "values", "offset", "terms")   # fields of signals whose numbers are in the unit of the signal

TIME_TOLERANCE = 1e-9   # s; a step at a multiple of the communication step must not be missed by rounding

RadiansPerSecond = Annotated[float, BeforeValidator(lambda value: parse_quantity(value, "rad/s")),
                             ValueKind("angular frequency", "rad/s")]
InUnit = Annotated[float, BeforeValidator(lambda value, info: in_unit(value, info.data.get("unit"))),
                   ValueKind("quantity")]


class SignalTable(Table):
    """The keys that all signals share: the inputs they feed, and a unit for plain numbers; text carries its own."""

    PLACE = "[[signals]]"

    to: str = Field(description="Real input or tunable parameter `fmu.variable` that gets the signal")
    rate_to: str | None = Field(default=None, description="input that gets the time derivative of the signal")
    open_unit: bool = False   # an FMU may declare units that the table lacks: numbers do not change
    unit: str | None = Field(default=None, description="unit of plain numbers, which are otherwise in SI")

    @model_validator(mode="before")
    @classmethod
    def unit_of_text(cls, table: Any) -> Any:
        """Without `unit`, use the SI unit of the first text among the values."""
        if not isinstance(table, dict) or "unit" in table:
            return table
        for value in numbers_in(table):
            if isinstance(value, str):
                try:
                    if table.get("open_unit") and known_unit(split_text(value)[1]) is None:
                        return {**table, "unit": split_text(value)[1]}
                    return {**table, "unit": unit_of(str(read_quantity(value).unit)).si}
                except QuantityError:
                    return table   # refused with its key when the field itself is read
        return table

    @field_validator("unit")
    @classmethod
    def unit_is_known(cls, unit: str | None, info: ValidationInfo) -> str | None:
        """Refuse an unknown unit, unless an FMU may declare it."""
        if unit is not None and not info.data.get("open_unit"):
            unit_of(unit)
        return unit

    def in_si(self, unit: Unit) -> Self:
        """Return the signal in SI."""
        def converted(value: Any) -> Any:
            if isinstance(value, list):
                return [converted(entry) for entry in value]
            if isinstance(value, Term):
                return value.model_copy(update={"amplitude": converted(value.amplitude)})
            return exact_product(value, unit.factor)

        own = [name for name in IN_UNIT if name in type(self).model_fields]
        return self.model_copy(update={"unit": unit.si, **{name: converted(getattr(self, name)) for name in own}})

    @abstractmethod
    def values_at(self, times: Array) -> Array:
        """Return the values at ascending times (s), shape (n,), SI."""

    def rates_at(self, times: Array) -> Array:
        """Return the time derivatives at ascending times (s), shape (n,), SI; 0 at a jump."""
        return np.zeros(len(times))

    def value(self, t: float) -> float:
        """Return the value at time t (s), SI."""
        return float(self.values_at(np.array([t]))[0])


class Constant(SignalTable):
    """One value at all times."""

    PLACE = "[[signals]], constant"

    kind: Literal["constant"] = Field(description="a constant value")
    level: InUnit = Field(alias="value", description="the value")

    def values_at(self, times: Array) -> Array:
        return np.full(len(times), self.level)


class Steps(SignalTable):
    """Piecewise constant: values[i] from times[i] on, values[0] before; true and false for a Boolean input."""

    PLACE = "[[signals]], steps"

    kind: Literal["steps"] = Field(description="each value holds from its time on, the first one also before")
    times: list[Seconds] = Field(min_length=1, description="ascending times")
    values: Annotated[list[bool | float], ValueKind("list of quantities, or of true and false")] = Field(
        description="values, as many as times")

    @field_validator("values", mode="before")
    @classmethod
    def to_si(cls, values: Any, info: ValidationInfo) -> list[bool | float]:
        if not isinstance(values, list):
            raise ValueError("expected a list of values")
        return [value if isinstance(value, bool) else entry_to_si(value, info.data.get("unit"), i)
                for i, value in enumerate(values)]

    @model_validator(mode="after")
    def match_times(self) -> "Steps":
        """Refuse times that do not ascend, and a number of values that differs from that of the times."""
        for i, (earlier, later) in enumerate(pairwise(self.times)):
            if later <= earlier:
                raise key_refused(i + 1, later, f"expected ascending times, the one before is {earlier}", "times")
        if len(self.values) != len(self.times):
            raise key_refused("values", self.values,
                              f"expected as many as times, {len(self.times)}, got {len(self.values)}")
        return self

    def values_at(self, times: Array) -> Array:
        starts = np.searchsorted(times + TIME_TOLERANCE, self.times[1:])
        return np.repeat(np.array(self.values, dtype=np.float64), np.diff([0, *starts, len(times)]))


class Term(Table):
    """One sinusoid: amplitude · sin(omega t + phase)."""

    PLACE = "terms of sinusoids"

    amplitude: Annotated[float, ValueKind("quantity")] = Field(description="amplitude, in the unit of the signal")
    omega: RadiansPerSecond = Field(description="angular frequency")
    phase: Radians = Field(default=0.0, description="angle at t = 0 in amplitude · sin(omega t + phase)")


class Sinusoids(SignalTable):
    """Offset plus a sum of sinusoids, whose amplitude is ramped in by 3 s² − 2 s³, s = t/ramp."""

    PLACE = "[[signals]], sinusoids"

    kind: Literal["sinusoids"] = Field(description="an offset and a sum of sinusoids")
    offset: InUnit = Field(default=0.0, description="mean value")
    terms: list[Term] = Field(min_length=1, description="the sinusoids")
    ramp: Seconds = Field(default=0.0, ge=0.0, description="time in which the amplitude grows smoothly from 0")

    @field_validator("terms", mode="before")
    @classmethod
    def amplitudes_to_si(cls, terms: Any, info: ValidationInfo) -> Any:
        """Convert the amplitudes, whose unit stands outside the terms, to SI."""
        if not isinstance(terms, list):
            raise ValueError("expected a list of terms")
        return [{**terms[i], "amplitude": entry_to_si(terms[i]["amplitude"], info.data.get("unit"), i, "amplitude")}
                if isinstance(terms[i], dict) and "amplitude" in terms[i] else terms[i] for i in range(len(terms))]

    def values_at(self, times: Array) -> Array:
        return self.offset + self.ramped(self.envelope, 1.0, times) * self.oscillation(times)

    def rates_at(self, times: Array) -> Array:
        return (self.ramped(self.envelope_rate, 0.0, times) * self.oscillation(times)
                + self.ramped(self.envelope, 1.0, times) * self.oscillation(times, rate=True))

    def oscillation(self, times: Array, rate: bool = False) -> Array:
        """Return the sum of the terms at times (s), shape (n,), or its time derivative."""
        total = np.zeros(len(times))
        for term in self.terms:
            sines, cosines = sines_cosines(term.omega * times + term.phase)
            total += term.amplitude * term.omega * cosines if rate else term.amplitude * sines
        return total

    def ramped(self, function: Callable[[float], float], after: float, times: Array) -> Array:
        """Return a function of time (s) at times, shape (n,), that is constant after the ramp."""
        values = np.full(len(times), after)
        ramping = times < self.ramp
        values[ramping] = [function(t) for t in times[ramping].tolist()]
        return values

    def envelope(self, t: float) -> float:
        """Return the factor on the amplitude at time t (s) of the ramp, 0 to 1."""
        s = max(t, 0.0) / self.ramp
        return s * s * (3.0 - 2.0 * s)

    def envelope_rate(self, t: float) -> float:
        """Return the time derivative of the envelope at time t (s) of the ramp, 1/s."""
        s = max(t, 0.0) / self.ramp
        return 6.0 * s * (1.0 - s) / self.ramp


class Csv(SignalTable):
    """A column of a table over its time: linear between rows, held beyond both ends."""

    PLACE = "[[signals]], csv"

    kind: Literal["csv"] = Field(description="a column of a table over `time` or the first column, interpolated "
                                             "between rows and constant beyond both ends")
    file: str = Field(description="path of the table, from the folder of the scenario: a CSV file, or a table of a "
                                  "laboratory")
    column: str = Field(description="name of the column; a unit in its header overrides `unit`")
    time_unit: str | None = Field(default=None, description="unit of the time; otherwise that of the header, or s")
    begin: Seconds | None = Field(default=None, description="time of the run at the first row; otherwise the times of "
                                                            "the table are those of the run")
    _times: list[float] = PrivateAttr()
    _values: list[float] = PrivateAttr()
    _told: bool = PrivateAttr()      # the unit of the time
    _said: str = PrivateAttr()       # what reading took for granted, in one line

    @model_validator(mode="after")
    def read(self) -> "Csv":
        try:
            table = read_table(Path(self.file))
            name = time_column(table) or next(filter(None, table.names))
            own = [other for other in table.names if other and other != name]
            column = table.find(self.column)
            if column is None or column == name:
                raise key_refused("column", self.column,
                                  f"no such column in {self.file}, {nearest(self.column, own)}")
            times = times_of(table.renamed({}, {name: self.time_unit} if self.time_unit else {}), name)
            self._values = self.values_of(table, column)
        except CsvError as error:
            raise key_refused("file", self.file, error.problem) from None
        for i, (earlier, later) in enumerate(pairwise(times.seconds.tolist())):
            if later <= earlier:
                raise key_refused("file", self.file, f"row {table.line(i + 1)} has time {later}, expected more than "
                                                     f"{earlier}")
        if times.stamped and self.begin is None:
            raise key_refused("file", self.file, f"column {name} has time stamps, expected the time of the run at "
                                                 "which they begin, such as begin = 0")
        shift = 0.0 if self.begin is None else self.begin - float(times.seconds[0])
        self._times, self._told, self._said = (times.seconds + shift).tolist(), times.told, table.said
        return self

    def values_of(self, table: DataTable, column: str) -> list[float]:
        """Return the values in SI: by the unit of the header, or by `unit`."""
        said = table.unit(column)
        own = known_unit(said) if said else None
        if own is None:
            if said and self.unit is None:
                raise key_refused("column", self.column, f"its unit {said!r} is unknown, needs unit, or another "
                                                         f"header; {like(said)}")
            return [in_unit(value, self.unit) for value in table.column(column).tolist()]
        if self.unit is None:
            object.__setattr__(self, "unit", own.si)   # so that its dimension is checked
        elif not measures(self.unit, said):
            raise key_refused("unit", self.unit, f"column {column} is in {said}, expected a unit that converts to it")
        return list(table.column(column, own.si).tolist())

    def misfit(self, end: float) -> str:
        """Return a reason why a run until its end (s) cannot use the table: no rows, or times of unknown unit; "" if it
        can.
        """
        first, last = self._times[0], self._times[-1]
        if first >= end or last < 0.0 or last == 0.0 < len(self._times) - 1:
            return (f"its rows are from {first:.9g} s to {last:.9g} s, outside the run from 0 s to {end:.9g} s: begin "
                    "= 0 moves the first row to the begin, time_unit sets the unit")
        after = int(np.searchsorted(self._times, end, side="right"))
        if not self._told and 0 < after < len(self._times) and self._times[after - 1] <= 0.0:
            return (f"the run to {end:.9g} s is between its rows at {self._times[after - 1]:.9g} s and "
                    f'{self._times[after]:.9g} s: expected time_unit, such as "ms", or "s" if they are so far apart')
        return ""

    def used(self, end: float) -> str:
        """Return the assumptions of reading, and the part used by a run from 0 to its end (s); "" for all of a plain
        CSV.
        """
        first, last = self._times[0], self._times[-1]
        part = f"rows from {first:.6g} s to {last:.6g} s, used from {max(first, 0.0):.6g} s to {min(last, end):.6g} s"
        cut = first < 0.0 or last > end + TIME_TOLERANCE
        return "; ".join(filter(None, (self._said or (self.file if cut else ""), part if cut else "")))

    def in_si(self, unit: Unit) -> Self:
        """Return the signal in SI."""
        scaled_table = super().in_si(unit)
        scaled_table._values = [exact_product(value, unit.factor) for value in self._values]
        return scaled_table

    def values_at(self, times: Array) -> Array:
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


def numbers_in(table: dict[str, Any]) -> list[Any]:
    """Return all numbers that `unit` applies to in the table of a signal."""
    return [table.get("value"), table.get("offset"), *items(table.get("values")),
            *(term.get("amplitude") for term in items(table.get("terms")) if isinstance(term, dict))]


def in_unit(value: object, unit: str | None) -> float:
    """Return a number in SI, unchanged if the unit is not known here: a text must be in that unit, then."""
    if unit is None or known_unit(unit) is not None:
        return parse_quantity(value, unit)
    if not isinstance(value, str):
        return parse_quantity(value)
    number, own = split_text(value)
    if own != unit:
        raise QuantityError(f"{value!r} is in {own}, expected a quantity in {unit}")
    return number


def entry_to_si(value: object, unit: str | None, *keys: str | int) -> float:
    """Convert an entry of a list to SI; a refusal names the keys below that list."""
    try:
        return in_unit(value, unit)
    except QuantityError as error:
        raise key_refused(keys[-1], value, str(error), *keys[:-1]) from None
