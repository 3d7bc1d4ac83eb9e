"""Baseline of a run, as in the FMI cross-check: NAME_ref.csv has the samples, NAME_ref.opt times and tolerances.

Where every machine has the same bits, NAME_ref.sha256 has the digest of every signal at every sample.
"""

import csv
import hashlib
import io
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from maglev.arrays import Array
from maglev.cosim.master import Recording
from maglev.errors import BaselineError, nearest, shortened
from maglev.schema.run_plan import RunPlan
from maglev.tables.table import DataTable, read_table
from maglev.time_grid import ON_GRID, whole_steps
from maglev.units import is_finite, refused_as
from maglev_files.regular_file import regular
from maglev_files.whole_file import whole_file, write_whole

LARGEST_FILE = 1_000_000   # bytes: baselines are committed

RUN_KEYS = ("StartTime", "StopTime", "StepSize", "OutputInterval", "RelTol")
SIGNAL_KEYS = ("AbsTol", "RelTol")
OPTION_FORM = "expected KEY,NUMBER or AbsTol,SIGNAL,NUMBER or RelTol,SIGNAL,NUMBER"


class Tolerance(NamedTuple):
    """What a signal may differ from the expected value: absolute (SI) plus relative times the expected value."""

    absolute: float
    relative: float

    def at(self, expected: Array) -> Array:
        """Largest difference that is allowed at each expected value."""
        return self.absolute + self.relative * np.abs(expected)


FORM = re.compile(r"([0-9a-f]{64})  (\d+) signals at (\d+) samples\n")


class Digest(NamedTuple):
    """SHA-256 of a recording, its signals, and its samples."""

    sha256: str
    signals: int
    samples: int


def digest_of(time: npt.NDArray[np.float64], columns: Mapping[str, npt.NDArray[Any]]) -> Digest:
    """Digest of columns of numbers and Booleans, shape (n,), by name, and of their times (s)."""
    hashed = hashlib.sha256()
    for name, values in [("time", time), *((name, columns[name]) for name in sorted(columns))]:
        hashed.update(name.encode("utf-8") + b"\0")
        numbers = np.array(values, dtype="<f8")
        numbers[np.isnan(numbers)] = np.nan   # of which processors choose the sign
        hashed.update(numbers.data)
    return Digest(hashed.hexdigest(), len(columns), len(time))


def digest_file(folder: Path, name: str) -> Path:
    return folder / f"{name}_ref.sha256"


def write_digest(folder: Path, name: str, digest: Digest | None) -> None:
    """Write the digest of a run; None takes away what is there."""
    path = digest_file(folder, name)
    if digest is None:
        path.unlink(missing_ok=True)
        return
    write_whole(path, f"{digest.sha256}  {digest.signals} signals at {digest.samples} samples\n")


def read_digest(folder: Path, name: str) -> Digest | None:
    """Digest of a run; None if there is none, BaselineError if the file is not one."""
    path = digest_file(folder, name)
    if not path.is_file():
        return None
    match = FORM.fullmatch(regular(path).read_text(encoding="utf-8-sig", errors="replace"))
    if match is None:
        raise BaselineError(f"{path}: not a digest, expected a line with SHA-256, signals and samples; "
                            "`maglev check --update` writes it")
    return Digest(match[1], int(match[2]), int(match[3]))


@dataclass(frozen=True)
class Baseline:
    """Expected samples of a run, by signal; Booleans as 0 and 1."""

    name: str                          # of the plan
    time: Array                        # s, of the n samples: ascending, on the grid of communication points
    columns: dict[str, Array]          # expected values, shape (n,), by signal `fmu.variable`, SI
    step: float                        # communication step, s
    stop_time: float                   # of the last sample, s
    tolerances: dict[str, Tolerance]   # by signal
    interval: float                    # s between two samples when it was made; for the reader of the file
    digest: Digest | None = None       # of all signals at all samples, where every machine has the same bits


class Option(NamedTuple):
    """A value of an options file, its key, the signal of a tolerance, and the number of its line."""

    line: int
    key: str
    signal: str | None
    value: float

    @property
    def label(self) -> str:
        return self.key if self.signal is None else f"{self.key},{self.signal}"


Options: TypeAlias = dict[tuple[str, str | None], Option]   # by key and signal, None for keys of the run


def baseline_files(folder: Path, name: str) -> tuple[Path, Path]:
    return folder / f"{name}_ref.csv", folder / f"{name}_ref.opt"


def from_recording(plan: RunPlan, step: float, recording: Recording, exact: bool = False) -> Baseline:
    """Baseline of a run: the signals of `plan.check`, one sample every `plan.check.interval`.

    It ends before the stage first touches a stop or the controller trips: after a crash one rounding error moves the
    trajectory by tens of micrometres. `plan.check.through_contact` is for runs that do not magnify it so.

    `step` is the communication step of the run, s; an `exact` one has a digest of the whole recording. BaselineError if
    no signal is to be checked, a signal was not recorded or is not finite, the interval is not a whole number of steps,
    or fewer than two samples remain.
    """
    check = plan.check
    if not check.signals:
        raise BaselineError(f"{plan.path}: check.signals: expected at least one signal")
    with refused_as(BaselineError, f"{plan.path}: check.interval = {check.interval} s"):
        every = whole_steps(check.interval, step)
    rows = slice(0, rows_before_contact(plan, recording), every)
    time = recording.time[rows].copy()
    if len(time) < 2:
        raise BaselineError(f"{plan.path}: check.interval = {check.interval} s: {len(time)} samples before a stop "
                            "is touched, the controller trips or the run ends, expected at least 2")
    columns = {name: recorded(recording, name)[rows].astype(np.float64) for name in check.signals}
    for name, values in columns.items():
        if not np.isfinite(values).all():
            raise BaselineError(f"{name} is not finite at t = {time[np.argmin(np.isfinite(values))]:.9g} s, "
                                "expected finite values for a baseline")
    tolerances = {name: Tolerance(allowed.absolute, allowed.relative) for name, allowed in check.signals.items()}
    digest = digest_of(recording.time, recording.columns) if exact else None
    return Baseline(plan.name, time, columns, step, float(time[-1]), tolerances, check.interval, digest)


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
        raise BaselineError(f"{name} was not recorded, expected an output of an FMU or a driven input; nearest is "
                            f"{nearest(name, recording.columns)}")
    return recording.columns[name]


def write_baseline(folder: Path, baseline: Baseline) -> None:
    """Write the files of a baseline; BaselineError if the samples are larger than a committed file should be."""
    samples = io.StringIO()
    csv.writer(samples, quoting=csv.QUOTE_ALL, lineterminator="\n").writerow(["time", *baseline.columns])
    for row in zip(baseline.time.tolist(), *(values.tolist() for values in baseline.columns.values()), strict=True):
        samples.write(",".join(map(repr, row)) + "\n")
    options = io.StringIO()
    writer = csv.writer(options, lineterminator="\n")
    run_values = (float(baseline.time[0]), baseline.stop_time, baseline.step, baseline.interval, 0.0)
    writer.writerows((key, repr(value)) for key, value in zip(RUN_KEYS, run_values, strict=True))
    for name, tolerance in baseline.tolerances.items():
        writer.writerows((key, name, repr(value)) for key, value in zip(SIGNAL_KEYS, tolerance, strict=True))

    files = baseline_files(folder, baseline.name)
    if samples.tell() > LARGEST_FILE:
        raise BaselineError(f"{files[0]} would have {samples.tell()} characters, expected at most {LARGEST_FILE}: "
                            "check fewer signals, or at a longer check.interval")
    with whole_file(files[0]) as first, whole_file(files[1]) as second:
        first.write_text(samples.getvalue(), encoding="utf-8", newline="\n")
        second.write_text(options.getvalue(), encoding="utf-8", newline="\n")
    write_digest(folder, baseline.name, baseline.digest)


def read_baseline(folder: Path, name: str) -> Baseline:
    """Read and check the baseline of a run; BaselineError, CsvError or OSError of what is not as it should be."""
    samples_file, options_file = baseline_files(folder, name)
    for file in (samples_file, options_file):
        if not file.is_file():
            raise BaselineError(f"{file}: there is no such file, expected the baseline of a run; "
                                "`maglev check --update` writes it")
    table = read_table(samples_file)
    if table.said:
        raise BaselineError(f"{table.said}, expected a plain CSV, as `maglev check --update` writes it")
    table.require_full_rows()
    time, *signals = table.names
    if time != "time":
        raise BaselineError(f"{samples_file}: the first column is {time!r}, expected time")
    times = table.column(time)
    if len(times) < 2:
        raise BaselineError(f"{samples_file}: 1 sample, expected 2 or more")
    options = read_options(options_file, signals)
    step = options["StepSize", None].value
    check_times(table, times.tolist(), step)
    for key, k in (("StartTime", 0), ("StopTime", -1)):
        given = options[key, None]
        if abs(given.value - times[k]) > ON_GRID * step:
            raise refused(options_file, given.line, key, given.value,
                          f"expected the {'first' if k == 0 else 'last'} time in {samples_file.name}, {times[k]} s")
    tolerances = {signal: Tolerance(*(options[key, signal].value for key in SIGNAL_KEYS)) for signal in signals}
    return Baseline(name, times, {signal: table.column(signal) for signal in signals}, step,
                    options["StopTime", None].value, tolerances, options["OutputInterval", None].value,
                    read_digest(folder, name))


def option_rows(place: object, text: str) -> Iterator[Option]:
    """Values of an options file of a baseline, or of an experiment of anybody's; BaselineError names the line."""
    reader = csv.reader(io.StringIO(text, newline=""), skipinitialspace=True, strict=True)
    try:
        for cells in filter(None, reader):
            key, *names, written = map(str.strip, cells if len(cells) > 1 else [*cells, ""])
            if len(cells) == 1 or len(names) > 1 or (names and key not in SIGNAL_KEYS):
                raise refused(place, reader.line_num, "row", ",".join(cells), OPTION_FORM)
            if not is_finite(written):
                raise refused(place, reader.line_num, ",".join([key, *names]), written, "expected a finite number")
            yield Option(reader.line_num, key, names[0] if names else None, float(written))
    except csv.Error as error:
        raise BaselineError(f"{place}, line {reader.line_num}: {error}, expected comma-separated values") from None


def read_options(path: Path, signals: Sequence[str]) -> Options:
    """Options of a run of these signals: finite numbers, not negative, none missing and none too many."""
    try:
        text = regular(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise BaselineError(f"{path}: cannot be read, expected UTF-8 text") from None
    if not text.strip():
        raise BaselineError(f"{path}: the file is empty, expected the baseline of a run")
    options: Options = {}
    for option in option_rows(path, text):
        line, key, signal, value = option
        if key not in (*RUN_KEYS, *SIGNAL_KEYS):
            raise refused(path, line, "key", key, f"unknown, nearest is {nearest(key, (*RUN_KEYS, *SIGNAL_KEYS))}")
        if signal is None and key not in RUN_KEYS:
            raise refused(path, line, "row", f"{key},{value}", OPTION_FORM)
        if signal is not None and signal not in signals:
            raise refused(path, line, option.label, value, "there is no such column; nearest is "
                                                           f"{nearest(signal, signals)}")
        if key in ("StepSize", "OutputInterval") and value <= 0.0:
            raise refused(path, line, key, value, "expected more than zero")
        if value < 0.0:
            raise refused(path, line, option.label, value, "expected zero or more")
        # Fixed-step runs have no solver tolerance. A number here would look as if it were one for every signal.
        if (key, signal) == ("RelTol", None) and value != 0.0:
            raise refused(path, line, key, value, "expected 0.0; tolerances stand at their signals")
        if (key, signal) in options:
            raise refused(path, line, option.label, value, f"given already in line {options[key, signal].line}, "
                                                           "expected once")
        options[key, signal] = option
    wanted = [(key, None) for key in RUN_KEYS[:-1]] + [(key, signal) for signal in signals for key in SIGNAL_KEYS]
    for key, signal in wanted:
        if (key, signal) not in options:
            form = f"{key},NUMBER" if signal is None else f"{key},{signal},NUMBER"
            raise BaselineError(f"{path}: {form.removesuffix(',NUMBER')} is missing, expected a line {form}")
    return options


def check_times(table: DataTable, times: Sequence[float], step: float) -> None:
    """Refuse times that do not ascend, or are not whole numbers of communication steps (s)."""
    for k, time in enumerate(times):
        if k > 0 and time <= times[k - 1]:
            raise table.refusal("time", k, f"expected more than {times[k - 1]} s, of the sample before")
        if time < 0.0 or abs(math.remainder(time, step)) > ON_GRID * step:
            raise table.refusal("time", k, f"expected a multiple of StepSize = {step} s")


def refused(place: object, line: int, label: str, value: object, expectation: str) -> BaselineError:
    return BaselineError(f"{place}, line {line}: {label} = {shortened(value)}: {expectation}")
