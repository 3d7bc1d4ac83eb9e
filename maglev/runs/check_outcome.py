"""Outcome of a check or an update of baselines, in words and as JUnit XML, which CI servers show.

A check has the first deviation of a run from its baseline, and the largest one of each signal.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple
from xml.etree import ElementTree

import numpy as np

from maglev.cosim.master import Recording
from maglev.files.arrays import Array
from maglev.files.errors import BaselineError
from maglev.files.time_grid import ON_GRID
from maglev.files.whole_file import whole_file
from maglev.fmi.escapes import xml_text
from maglev.runs.baseline_file import Baseline, Tolerance, recorded

ELEMENTS = {"deviated": "failure", "error": "error"}


@dataclass(frozen=True)
class DeviatingSample:
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
                    tolerances: Mapping[str, Tolerance]) -> DeviatingSample | None:
    """Return the earliest deviating sample: |got - expected| > absolute + relative |expected|, or got is not finite.

    Samples are by signal, at the times (s) of the expected columns. Of several at the same time, it is the one with the
    largest ratio of difference to allowance.
    """
    first: DeviatingSample | None = None
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
            first = DeviatingSample(name, time, float(expected[i]), float(got[i]), float(allowed[i]))
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


@dataclass(frozen=True)
class CheckResult:
    """Outcome of one run; "deviated" is a difference beyond its tolerance, "error" a run that could not be compared."""

    name: str                                                  # of the plan
    status: Literal["passed", "deviated", "error"]
    message: str                                               # one line, without the name
    deviation: DeviatingSample | None                          # the first, if there is one
    worst: dict[str, WorstDifference]                          # largest difference of each signal; empty after an error
    elapsed: float                                             # wall time, s
    units: dict[str, str] = field(default_factory=dict)        # of each signal, empty text where the FMU gives none
    ends: Mapping[str, float] = field(default_factory=dict)    # every output at the end; empty if it ended early
    notes: tuple[str, ...] = ()                                # as of `Recording`

    def __repr__(self) -> str:
        return f"<CheckResult {self.name}: {self.message}>"


@dataclass(frozen=True)
class UpdateResult:
    """Outcome of the update of one baseline.

    "new": there was none; "replaced": the old one could not be read or compared; "error": nothing was written.
    """

    name: str                                                  # of the plan
    status: Literal["new", "unchanged", "updated", "replaced", "error"]
    message: str                                               # one line, without the name
    moved: dict[str, WorstDifference]                          # largest change of each signal that both baselines have
    elapsed: float                                             # wall time, s
    ends: Mapping[str, float] = field(default_factory=dict)    # every output at the end; empty after an error
    notes: tuple[str, ...] = ()                                # as of `Recording`
    baseline: Baseline | None = None                           # the new one; None after an error

    def __repr__(self) -> str:
        return f"<UpdateResult {self.name}: {self.message}>"


def describe(result: CheckResult | UpdateResult) -> str:
    """Return one line about a result, the name of the plan first."""
    return f"{result.name}: {'error: ' if result.status == 'error' else ''}{result.message}"


def exit_code(results: Sequence[CheckResult | UpdateResult]) -> int:
    """Return 0 if all passed, 1 if some deviated, 2 if anything could not be checked, or nothing was."""
    statuses = {result.status for result in results}
    if "error" in statuses or not statuses:
        return 2
    return 1 if "deviated" in statuses else 0


def write_junit(path: Path, results: Sequence[CheckResult]) -> None:
    """Write a test case for each run: a deviation is a failure, and a run that could not be checked an error."""
    statuses = [result.status for result in results]
    suite = ElementTree.Element("testsuite", {
        "name": "maglev check", "tests": str(len(results)), "failures": str(statuses.count("deviated")),
        "errors": str(statuses.count("error")), "time": f"{sum(result.elapsed for result in results):.3f}"})
    for result in results:
        case = ElementTree.SubElement(suite, "testcase", {
            "classname": "maglev.check", "name": xml_text(result.name), "time": f"{result.elapsed:.3f}"})
        if result.status in ELEMENTS:
            message = xml_text(result.message)
            reason = ElementTree.SubElement(case, ELEMENTS[result.status], {"message": message, "type": result.status})
            reason.text = message
        if result.notes:
            ElementTree.SubElement(case, "system-out").text = xml_text("\n".join(result.notes))
    ElementTree.indent(suite)
    with whole_file(path) as unfinished:
        ElementTree.ElementTree(suite).write(unfinished, encoding="utf-8", xml_declaration=True)
