"""Recorded signals made small enough for a page: rows left out where a straight line replaces them, then compressed.

The browser draws straight lines between the rows that are kept; no sample is further from these lines than the
tolerance of its signal.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.files.arrays import Array
from maglev.pages.shell import packed_text

Rows = NDArray[np.intp]

QUANTA = 4             # of a value per tolerance, so that rounding adds an eighth of it
FIRST_ROWS = 33        # evenly spaced, before rows are added where they are needed
LARGEST_COUNT = 2**30 - 1   # quanta; keeps values and their differences in 32 bits
MICROSECOND = 1e-6     # s, quantum of times that are no multiples of the output interval


def thin(time: Array, values: Array, tolerance: float, most: int) -> tuple[Rows, float]:
    """Choose the rows to keep: the first, the last, the largest, the smallest, and all that the tolerance needs.

    Times (s) are ascending and samples finite, shape (n,), n > 0. The tolerance, > 0 in the unit of the values, is
    doubled until `most` rows are enough; ends and extremes are kept in any case. Return the ascending indices of the
    rows, shape (k,), and that tolerance: no sample is farther from the line between its kept neighbours.
    """
    evenly = np.linspace(0, len(time) - 1, FIRST_ROWS).astype(np.intp)
    extremes = [int(np.argmin(values)), int(np.argmax(values))]
    first = np.unique(np.concatenate([evenly, np.array(extremes, dtype=np.intp)]))
    while True:
        rows = refine(time, values, tolerance, first, max(most, len(first)))
        if rows is not None:
            return rows, tolerance
        tolerance *= 2.0


def refine(time: Array, values: Array, tolerance: float, first: Rows, most: int) -> Rows | None:
    """Add to each stretch between two kept rows the worst sample, as long as one is beyond the tolerance.

    Returns None when this takes more than `most` rows.
    """
    rows = [first]
    starts, ends = first[:-1], first[1:]   # of the stretches that are not within the tolerance yet
    samples = np.arange(len(time) - 1)     # in them; a start is one, an end is not
    while sum(map(len, rows)) <= most:
        lengths = ends - starts
        slopes = np.repeat((values[ends] - values[starts]) / (time[ends] - time[starts]), lengths)
        lines = slopes * (time[samples] - np.repeat(time[starts], lengths)) + np.repeat(values[starts], lengths)
        distance = np.abs(values[samples] - lines)
        begins = np.cumsum(lengths) - lengths
        largest = np.maximum.reduceat(distance, begins)
        beyond = largest > tolerance
        if not beyond.any():
            return np.sort(np.concatenate(rows))
        # Of equally bad samples in a stretch one is enough.
        worst = np.flatnonzero(distance == np.repeat(largest, lengths))
        rows.append(samples[worst[np.searchsorted(worst, begins[beyond])]])
        samples = samples[np.repeat(beyond, lengths)]
        starts, ends = (np.column_stack(pair).ravel() for pair in ((starts[beyond], rows[-1]),
                                                                   (rows[-1], ends[beyond])))
    return None


def encode(integers: NDArray[np.int64]) -> bytes:
    """Write integers, shape (k,), as differences of 32 bits: all lowest bytes first, then all second ones, and so on.

    Differences of a smooth signal are small, so their upper bytes are alike and compress to nearly nothing. The lowest
    bit is the sign, so that this holds for both signs: 0, −1, 1, −2, … are 0, 1, 2, 3, …
    """
    differences = np.diff(integers, prepend=0)
    return (differences << 1 ^ differences >> 63).astype("<u4").view(np.uint8).reshape(-1, 4).T.tobytes()


def pack(time: Array, columns: Mapping[str, NDArray[Any]], interval: float,
         tolerances: Mapping[str, float], most: int) -> dict[str, Any]:
    """Return the recorded signals of a run with a tolerance, for the page, with at most so many rows of each.

    Columns, SI, and ascending times (s) have shape (n,); values that are not finite are left out. The result has
    "time", the quantum of the times, s, by the output interval (s). "signals" has by name the number of rows, the
    quantum and the tolerance in SI. "data" is the Base64 of the gzipped times and values of the signals, one after the
    other.
    """
    counts = time / interval
    quantum = interval if np.allclose(counts, np.rint(counts), rtol=0.0, atol=1e-6) else MICROSECOND
    signals: dict[str, dict[str, float]] = {}
    data = []
    for name, tolerance in tolerances.items():
        values = np.asarray(columns.get(name, ()), dtype=np.float64)
        finite = np.flatnonzero(np.isfinite(values))
        if not len(finite):
            continue
        values = values[finite]
        rows, within = thin(time[finite], values, tolerance, most)
        step = max(within / QUANTA, float(np.abs(values).max()) / LARGEST_COUNT)
        data += [encode(np.rint(counted).astype(np.int64)) for counted in (time[finite][rows] / quantum,
                                                                           values[rows] / step)]
        signals[name] = {"rows": len(rows), "quantum": step, "tolerance": within}
    return {"time": quantum, "signals": signals, "data": packed_text(b"".join(data))}
