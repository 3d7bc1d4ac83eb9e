"""Baseline of a run: samples of a few signals in NAME_ref.csv, and the digest of the whole run in digests.txt.

How far a run may be from the samples, and at which times these are, the scenario says.
"""

import csv
import hashlib
import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from maglev.cosim.master import Recording
from maglev.files.arrays import Array
from maglev.files.errors import BaselineError, nearest, shortened
from maglev.files.regular_file import regular
from maglev.files.table import DataTable, read_table
from maglev.files.time_grid import ON_GRID, whole_steps
from maglev.files.units import refused_as
from maglev.files.whole_file import write_whole
from maglev.scenario.run_plan import RunPlan

LARGEST_FILE = 1_000_000   # bytes: baselines are committed

DIGESTS = "digests.txt"   # in a folder of baselines, a line for each run that has the same bits on every machine
DIGEST_LINE = re.compile(r"([0-9a-f]{64})  (\S+): (\d+) signals at (\d+) samples")


class Digest(NamedTuple):
    """SHA-256 of a recording, its signals, and its samples."""

    sha256: str
    signals: int
    samples: int

    @property
    def extent(self) -> str:
        return f"{self.signals} signals at {self.samples} samples"


def digest_of(time: npt.NDArray[np.float64], columns: Mapping[str, npt.NDArray[Any]]) -> Digest:
    """Return the digest of columns of numbers and Booleans, shape (n,), by name, and of their times (s)."""
    hashed = hashlib.sha256()
    for name, values in [("time", time), *((name, columns[name]) for name in sorted(columns))]:
        hashed.update(name.encode("utf-8") + b"\0")
        numbers = np.array(values, dtype="<f8")
        numbers[np.isnan(numbers)] = np.nan   # whose sign depends on the processor
        hashed.update(numbers.data)
    return Digest(hashed.hexdigest(), len(columns), len(time))


def read_digests(folder: Path) -> dict[str, Digest]:
    """Return the digests of a folder by run; BaselineError names a line that is no digest, or the second of a run."""
    path = folder / DIGESTS
    if not path.exists():
        return {}
    digests: dict[str, Digest] = {}
    lines = regular(path).read_text(encoding="utf-8-sig", errors="replace").splitlines()
    for number, line in enumerate(lines, 1):
        match = DIGEST_LINE.fullmatch(line)
        repeated = match is not None and match[2] in digests
        if match is None or repeated:
            raise BaselineError(f"{path}, line {number}: {shortened(line)}: expected SHA-256, name, signals and "
                                "samples of a run, each run once")
        digests[match[2]] = Digest(match[1], int(match[3]), int(match[4]))
    return digests


def write_digests(folder: Path, changed: Mapping[str, Digest | None]) -> None:
    """Add or replace the digests of runs in a folder; None removes one. Errors as of `read_digests`."""
    digests = read_digests(folder)
    new = {name: digest for name, digest in (digests | dict(changed)).items() if digest is not None}
    if new != digests:
        write_whole(folder / DIGESTS,
                    "".join(f"{new[name].sha256}  {name}: {new[name].extent}\n" for name in sorted(new)))


class Tolerance(NamedTuple):
    """The allowed deviation of a signal from the expected value: absolute (SI) plus relative times the expected value.
    """

    absolute: float
    relative: float

    def at(self, expected: Array) -> Array:
        """Largest difference that is allowed at each expected value."""
        return self.absolute + self.relative * np.abs(expected)


def tolerances_of(plan: RunPlan) -> dict[str, Tolerance]:
    """Return the tolerances of a scenario by signal `fmu.variable`."""
    return {name: Tolerance(allowed.absolute, allowed.relative) for name, allowed in plan.check.signals.items()}


@dataclass(frozen=True)
class Baseline:
    """Expected samples of a run, by signal; Booleans as 0 and 1."""

    name: str                      # of the plan
    time: Array                    # s, of the n samples: ascending, on the grid of communication points
    columns: dict[str, Array]      # expected values, shape (n,), by signal `fmu.variable`, SI
    step: float                    # communication step, s
    digest: Digest | None = None   # of all signals at all samples, where every machine has the same bits

    @property
    def stop_time(self) -> float:
        """Time of the last sample, s."""
        return float(self.time[-1])


def baseline_file(folder: Path, name: str) -> Path:
    return folder / f"{name}_ref.csv"


def from_recording(plan: RunPlan, step: float, recording: Recording, exact: bool = False) -> Baseline:
    """Baseline of a run: the signals of `plan.check`, one sample every `plan.check.interval`.

    It ends before the stage first touches a stop or the controller trips: after a crash one rounding error moves the
    trajectory by tens of micrometres. `plan.check.through_contact` is for runs that do not magnify it so.

    `step` is the communication step of the run, s; an `exact` one has a digest of the whole recording. BaselineError if
    no signal is to be checked, or one was not recorded or is not finite; if the interval is not a whole number of
    steps, or fewer than two samples remain.
    """
    check = plan.check
    if not check.signals:
        raise BaselineError(f"{plan.source}: check.signals: expected at least one signal")
    with refused_as(BaselineError, f"{plan.source}: check.interval = {check.interval} s"):
        every = whole_steps(check.interval, step)
    rows = slice(0, rows_before_contact(plan, recording), every)
    time = recording.time[rows].copy()
    if len(time) < 2:
        raise BaselineError(f"{plan.source}: check.interval = {check.interval} s: {len(time)} samples before a stop "
                            "is touched, the controller trips or the run ends, expected at least 2")
    columns = {name: recorded(recording, name)[rows].astype(np.float64) for name in check.signals}
    for name, values in columns.items():
        if not np.isfinite(values).all():
            raise BaselineError(f"{name} is not finite at t = {time[np.argmin(np.isfinite(values))]:.9g} s, "
                                "expected finite values for a baseline")
    return Baseline(plan.name, time, columns, step, digest_of(recording.time, recording.columns) if exact else None)


def rows_before_contact(plan: RunPlan, recording: Recording) -> int:
    """Number of communication points before the first one with a flag of the plan set, or all: `through_contact`."""
    end = len(recording.time)
    if plan.check.through_contact:
        return end
    for flag in (plan.stop_flag, plan.trip_flag):
        if flag is not None:
            rows_set = np.flatnonzero(recorded(recording, flag))
            end = min([end, *rows_set[:1].tolist()])
    return end


def recorded(recording: Recording, name: str) -> npt.NDArray[Any]:
    """A recorded column; BaselineError with the nearest name if there is none."""
    if name not in recording.columns:
        raise BaselineError(f"{name} was not recorded, expected an output of an FMU or a driven input; "
                            f"{nearest(name, recording.columns)}")
    return recording.columns[name]


def write_baseline(folder: Path, baseline: Baseline) -> None:
    """Write a baseline; BaselineError if the samples are larger than a committed file should be."""
    samples = io.StringIO()
    csv.writer(samples, quoting=csv.QUOTE_ALL, lineterminator="\n").writerow(["time", *baseline.columns])
    for row in zip(baseline.time.tolist(), *(values.tolist() for values in baseline.columns.values()), strict=True):
        samples.write(",".join(map(repr, row)) + "\n")
    file = baseline_file(folder, baseline.name)
    if samples.tell() > LARGEST_FILE:
        raise BaselineError(f"{file} would have {samples.tell()} characters, expected at most {LARGEST_FILE}: "
                            "check fewer signals, or at a longer check.interval")
    write_digests(folder, {baseline.name: baseline.digest})
    write_whole(file, samples.getvalue())


def read_baseline(folder: Path, plan: RunPlan) -> Baseline:
    """Read and check the baseline of a run; raise BaselineError, CsvError or OSError if it cannot be used."""
    file = baseline_file(folder, plan.name)
    if not file.is_file():
        raise BaselineError(f"{file}: there is no such file, expected the baseline of a run; "
                            "`maglev check --update` writes it")
    table = read_table(file)
    if table.said:
        raise BaselineError(f"{table.said}, expected a plain CSV, as `maglev check --update` writes it")
    time, *signals = table.names
    if time != "time":
        raise BaselineError(f"{file}: the first column is {time!r}, expected time")
    times = table.column(time)
    if len(times) < 2:
        raise BaselineError(f"{file}: 1 sample, expected 2 or more")
    check_times(table, times.tolist(), plan.step)
    return Baseline(plan.name, times, {signal: table.column(signal) for signal in signals}, plan.step,
                    read_digests(folder).get(plan.name))


def check_times(table: DataTable, times: Sequence[float], step: float) -> None:
    """Refuse times that do not ascend, or are not whole numbers of communication steps (s)."""
    for k, time in enumerate(times):
        if k > 0 and time <= times[k - 1]:
            raise table.refusal("time", k, f"expected more than {times[k - 1]} s, of the sample before")
        if time < 0.0 or abs(math.remainder(time, step)) > ON_GRID * step:
            raise table.refusal("time", k, f"expected a multiple of the communication step, {step} s")
