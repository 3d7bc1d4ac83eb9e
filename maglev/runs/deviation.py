"""The first deviation of a run from its baseline, and the largest one."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from maglev.cosim.master import Recording
from maglev.files.arrays import Array
from maglev.files.errors import BaselineError
from maglev.files.time_grid import ON_GRID
from maglev.runs.baseline_file import Baseline, Tolerance, recorded


@dataclass(frozen=True)
class Deviation:
    """A sample that differs from the expected one by more than its tolerance."""

    signal: str       # `fmu.variable`
    time: float       # s
    expected: float   # value of the baseline, SI
    got: float        # value of the run, SI
    allowed: float    # largest difference that the tolerance allows at this sample, SI


class WorstDifference(NamedTuple):
    """Largest absolute difference of a signal (SI; infinite if a value is not finite), and its first time (s)."""

    difference: float
    time: float


def first_deviation(times: Array, columns: Mapping[str, Array], samples: Mapping[str, Array],
                    tolerances: Mapping[str, Tolerance]) -> Deviation | None:
    """Return the earliest deviating sample: |got - expected| > absolute + relative |expected|, or got is not finite.

    Samples are by signal, at the times (s) of the expected columns. Of several at the same time, it is the one with the
    largest ratio of difference to allowance.
    """
    first: Deviation | None = None
    largest_excess = 0.0
    for name, got in samples.items():
        expected, differing = columns[name], absolute_difference(columns[name], got)
        allowed = tolerances[name].at(expected)
        deviating = (differing > allowed) | ~np.isfinite(got)
        if not deviating.any():
            continue
        i = int(np.argmax(deviating))
        excess = float(differing[i] / allowed[i]) if allowed[i] > 0.0 else np.inf
        time = float(times[i])
        if first is None or time < first.time or (time == first.time and excess > largest_excess):
            first = Deviation(name, time, float(expected[i]), float(got[i]), float(allowed[i]))
            largest_excess = excess
    return first


def worst(times: Array, columns: Mapping[str, Array], samples: Mapping[str, Array]) -> dict[str, WorstDifference]:
    """Return the largest difference of each signal; see `first_deviation` for the arguments."""
    largest = {}
    for name, got in samples.items():
        differing = absolute_difference(columns[name], got)
        i = int(np.argmax(differing))
        largest[name] = WorstDifference(float(differing[i]), float(times[i]))
    return largest


def closest(baseline: Baseline, samples: Mapping[str, Array],
            tolerances: Mapping[str, Tolerance]) -> tuple[str, float, float] | None:
    """Signal, difference and allowance (SI) of the sample closest to its tolerance; None where all are as expected."""
    nearest, largest_share = None, 0.0
    for name, got in samples.items():
        differing = absolute_difference(baseline.columns[name], got)
        allowed = tolerances[name].at(baseline.columns[name])
        shares = np.divide(differing, allowed, out=np.where(differing > 0.0, np.inf, 0.0), where=allowed > 0.0)
        i = int(np.argmax(shares))
        if shares[i] > largest_share:
            nearest, largest_share = (name, float(differing[i]), float(allowed[i])), float(shares[i])
    return nearest


def changes(old: Baseline, new: Baseline) -> dict[str, WorstDifference]:
    """Largest changes of signals that two baselines of one step share; BaselineError if no point is shared."""
    _, was, now = np.intersect1d(communication_points(old), communication_points(new), return_indices=True)
    if not len(was):
        raise BaselineError("no sample is at the same time as before")
    return worst(new.time[now], {name: values[was] for name, values in old.columns.items()},
                 {name: values[now] for name, values in new.columns.items() if name in old.columns})


def communication_points(baseline: Baseline) -> Array:
    return np.rint(baseline.time / baseline.step)


def samples_of(baseline: Baseline, recording: Recording) -> dict[str, Array]:
    """Values of the recording at the samples of the baseline, by signal; BaselineError if it has none there."""
    points = communication_points(baseline)
    if points[-1] >= len(recording.time):
        raise BaselineError(f"{baseline.name}: the run ended at t = {recording.time[-1]:.9g} s, expected "
                            f"{baseline.time[-1]:.9g} s, the end of the baseline")
    rows = points.astype(np.int64)
    off_grid = np.abs(recording.time[rows] - baseline.time) > ON_GRID * baseline.step
    if off_grid.any():
        i = int(np.argmax(off_grid))
        raise BaselineError(f"{baseline.name}: communication point {rows[i]} of the run is at "
                            f"t = {recording.time[rows[i]]:.9g} s, expected {baseline.time[i]:.9g} s: the "
                            "communication step differs from that of the baseline")
    return {name: recorded(recording, name)[rows].astype(np.float64) for name in baseline.columns}


def absolute_difference(expected: Array, got: Array) -> Array:
    """Absolute difference of finite expected values from others; infinite where these are not finite."""
    with np.errstate(invalid="ignore", over="ignore"):
        return np.where(np.isfinite(got), np.abs(got - expected), np.inf)
