"""Times of the rows of a table in seconds: whatever their unit, time stamps, uneven ones, and gaps."""

import re
from collections.abc import Callable
from datetime import UTC, datetime
from itertools import pairwise
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from maglev.files.arrays import Array
from maglev.files.errors import CsvError, MaglevError, one_of, option
from maglev.files.table import DataTable, scaled
from maglev.files.table_columns import TIME_OF_DAY, is_time_stamp
from maglev.files.units import unit_of

Gaps = Literal["refuse", "fill", "longest"]   # treatment of uneven times

NAMES = ("time", "t", "timestamp", "time stamp", "datetime", "date time", "zeit")
STAMP = re.compile(r"([^.,]*?\d)(?:[.,](\d+))?(Z|[+-]\d\d(?::?\d\d)?)?")   # whole seconds, their fraction, zone
UNITS = ("s", "ms", "µs", "ns")   # that times without a unit may have
LONGEST, SHORTEST = 5e-3, 1e-5   # s, sample times of recordings
EPOCH = 1e8       # s; no run is as long
UNEVEN = 0.01     # of the sample time, from which on times are resampled
JITTER = 0.05     # of the sample time, from which on that is left to the user


class Times(NamedTuple):
    """Times of the rows, s, and a flag, true if the table states their unit: in its header, or as time stamps."""

    name: str
    seconds: Array
    stamped: bool   # they count from the first row
    told: bool


def time_column(table: DataTable) -> str | None:
    """Name of the column of the time."""
    return table.find(*NAMES)


def times_of(table: DataTable, name: str, guess: bool = False) -> Times:
    """Times of a table; of time stamps, and if they count from an epoch on request, from the first row on.

    With `guess`, times without a unit that cannot be in s get the unit that makes a recording of them. CsvError if a
    value is no time.
    """
    raw = table.given.get(name)
    if raw is not None and raw.dtype.kind in "mM":
        return Times(name, seconds_since_first(raw), True, True)
    if raw is not None and raw.dtype.kind == "O" and table.layout is None and len(raw) and hasattr(raw[0], "isoformat"):
        moments = [moment.replace(tzinfo=None) - (moment.utcoffset() or moment - moment) for moment in raw]
        return Times(name, seconds_since_first(np.array(moments, "datetime64[us]")), True, True)
    first = next(table.rows()).fields[table.names.index(name)] if table.layout is not None else ""
    if is_time_stamp(first):
        return Times(name, stamps(table, name, first), True, True)
    numbers, unit = table.plain_numbers(name), table.unit(name)
    told = bool(unit)
    if guess:
        step = float(np.median(np.diff(numbers))) if len(numbers) > 1 else 0.0
        if not told and not SHORTEST <= step <= LONGEST:
            unit = next((unit for unit in UNITS if SHORTEST <= step * unit_of(unit).factor <= LONGEST), "")
            if unit:
                table.assume(f"assumed {name} in {unit}, because it has a row every {step:.6g}")
        if numbers[0] * unit_of(unit or "s").factor >= EPOCH:
            table.assume(f"{name} starts at {numbers[0]:.15g}, the first row")
            numbers = numbers - numbers[0]
    if told and unit != "s":
        numbers = table.converted(numbers, name, unit, "s")
    elif unit:
        numbers = scaled(numbers, unit_of(unit), unit_of("s"))
    return Times(name, numbers, False, told)


def seconds_since_first(moments: NDArray[np.datetime64]) -> Array:
    return np.asarray((moments - moments[0]) / np.timedelta64(1, "ns") / 1e9, dtype=np.float64)


def stamps(table: DataTable, name: str, first: str) -> Array:
    """Seconds since the first of time stamps by ISO 8601, or of times of a day; CsvError if one is no time stamp."""
    times = []
    for k, text in enumerate(table.texts(name)):
        try:
            times.append(nanoseconds(text))
        except ValueError:
            raise CsvError(table.path, f"row {table.line(k)}, column {name} is {text!r}, expected a time stamp, such "
                                       "as 2024-05-01T12:00:00.0005") from None
    table.assume(f"{name} has time stamps, from {first} on")
    return np.array([time - times[0] for time in times], dtype=np.float64) / 1e9


def nanoseconds(text: str) -> int:
    """Time of a time stamp since 1970, UTC if it names no zone, or of a time of day since midnight, ns.

    ValueError if a text is neither.
    """
    match = STAMP.fullmatch(text)
    if match is None:
        raise ValueError(text)
    whole, fraction, zone = match.groups(default="")
    if TIME_OF_DAY.fullmatch(text):
        hours, minutes, seconds = map(int, whole.split(":"))
        since = 3600 * hours + 60 * minutes + seconds
    else:
        moment = datetime.fromisoformat(whole + zone)
        since = round((moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp())
    return 10**9 * since + int(fraction[:9].ljust(9, "0"))


class Even(NamedTuple):
    """Evenly spaced times, s, and the way to resample a column at these times."""

    time: Array
    resample: Callable[[Array], Array]


def even(table: DataTable, times: Times, gaps: Gaps = "refuse") -> Even:
    """Return even times: unchanged up to 1 % of the sample time, resampled up to 5 %; beyond, `gaps` decides.

    "fill" resamples whatever is there by straight lines, "longest" takes the longest part without a gap, "refuse" names
    the first. A shorter last step is left out, as results of this project may have one. CsvError if times do not
    ascend.
    """
    time = times.seconds
    if gaps not in get_args(Gaps):
        raise MaglevError(f"{option('gaps', gaps)}: expected {one_of(gaps, get_args(Gaps))}")
    step = np.diff(time)
    backwards = np.flatnonzero(step <= 0.0)
    if len(backwards):
        k = int(backwards[0]) + 1
        raise refusal(table, times, k, f"expected more than {time[k - 1]:.9g}, the time of the row before: sort the "
                                       "rows and leave out duplicates")
    dt = float(np.median(step)) if len(step) else 0.0
    dt = float(np.mean(step[np.abs(step - dt) < 0.5 * dt])) if dt else dt
    begin, end = 0, len(time)
    if len(step) > 1 and step[-1] < (1.0 - JITTER) * dt:
        end -= 1
    uneven = np.flatnonzero(np.abs(step[:end - 1] - dt) > JITTER * dt) + 1
    if len(uneven) and gaps == "longest":
        edges = [0, *uneven.tolist(), end]
        begin, end = max(pairwise(edges), key=lambda part: part[1] - part[0])
        table.assume(f"{end - begin} of {len(time)} rows are used, the longest part without a gap, from "
                     f"{time[begin]:.9g} s to {time[end - 1]:.9g} s")
    elif len(uneven) and gaps == "refuse":
        raise refusal(table, times, int(uneven[0]), f"expected {time[uneven[0] - 1] + dt:.9g} ± {JITTER:.0%} of the "
                      f"sample time {dt:.6g} s; {gap_words(time, step, uneven)}: {option('gaps', 'fill')} fills "
                      f"them with straight lines, {option('gaps', 'longest')} takes the longest part without one")
    elif len(uneven):
        table.assume(f"{gap_words(time, step, uneven)}: filled with straight lines")
    part, kept = time[begin:end], slice(begin, end)
    apart = np.abs(np.diff(part) - dt)
    if len(part) < 3 or float(apart.max()) <= UNEVEN * dt:
        return Even(part, lambda column: column[kept])
    count = 1 + round(float(part[-1] - part[0]) / dt)
    resampled = np.linspace(part[0], part[-1], count)
    if not len(uneven) or gaps == "longest":
        table.assume(f"times are uneven by up to {float(apart.max()) / dt:.1%} of {dt:.6g} s, columns are resampled")
    return Even(resampled, lambda column: np.interp(resampled, part, column[kept]))


def gap_words(time: Array, step: Array, uneven: NDArray[np.intp]) -> str:
    """Return the number of uneven places and the longest gap, in words."""
    k = int(uneven[np.argmax(step[uneven - 1])])
    places = f"{len(uneven)} place{'' if len(uneven) == 1 else 's'}"
    return f"{places} with uneven times, the longest step is {step[k - 1]:.6g} s after {time[k - 1]:.9g} s"


def refusal(table: DataTable, times: Times, k: int, expectation: str) -> CsvError:
    return CsvError(table.path, f"row {table.line(k)}, column {times.name} is {times.seconds[k]:.9g}, {expectation}")


def require_time(table: DataTable) -> str:
    """Name of the column of the time; CsvError if there is none."""
    return time_column(table) or table.missing("no column time, expected time or t", "time")

