"""Co-simulation in a process of its own: an FMU that crashes, exits or hangs there takes nothing with it.

The process records into files that it maps into memory, counts its calls of FMUs there, too, and reports. So whatever
happens, this side has the recording until then, and knows which call was the last.
"""

import mmap
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from traceback import format_exc
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from maglev.cosim import Order
from maglev.cosim.fmi_versions import FMI2, FMI3
from maglev.cosim.helper_process import checked, other_process
from maglev.cosim.master import PROGRESS_STEPS, FmuSetup, Master, Observer, Recording, RunFailed, countable, early_end
from maglev.cosim.wiring import Call, Drives, Wiring
from maglev.files.cache import Kept
from maglev.files.errors import FmuError, Interrupted, ended_by, signal_of
from maglev.files.regular_file import regular
from maglev.files.side_by_side import Progress
from maglev.files.time_grid import whole_steps
from maglev.files.worker_process import PATIENCE, Forged, Gone, Send, Silent, WorkerProcess

TIMEOUT = 60.0   # s, after which an FMU that says nothing is taken to hang
COUNTER = "calls"   # file with the number of calls that were begun
TRACK = "track"     # files of the arrays, TRACK0.float64 and so on

Complete = Callable[[Recording], None]   # told of a recording


class IsolatedRun(NamedTuple):
    """A run; for the parameters see `Master`."""

    setups: Sequence[FmuSetup]
    connections: Sequence[tuple[str, str]]
    step: float
    order: Order
    stop_time: float
    drives: Drives
    loop: Kept | None = None
    columns: frozenset[str] = frozenset()   # which have to be recorded, at least


class Work(NamedTuple):
    """A call of an FMU, by its name; as a report: the present work on it, while no calls are counted."""

    fmu: str
    doing: str


STARTING = Work("the process of the run", "its start")
ENDING = Work("the process of the run", "its end")

KINDS = [np.dtype(kind.item).name for kind in (*FMI2.types.values(), *FMI3.types.values())]   # of recorded arrays


class Wired(NamedTuple):
    """Report: the calls before the first step, of each phase, and after the last step; the columns of each array."""

    initial: list[Work]
    phases: list[list[Work]]
    final: list[Work]
    columns: list[list[str]]


class Stepped(NamedTuple):
    done: int
    steps: int


class Finished(NamedTuple):
    """Report: the recording is complete; notes as in `Recording`."""

    notes: tuple[str, ...]


class Failed(NamedTuple):
    """Report that an FMU failed in a call, after a number of rows, with its traceback."""

    message: str
    rows: int
    traceback: str


Report = Work | Wired | Stepped | Finished | Failed


class Reporter(Observer):
    """The observer in the other process: sends reports, allocates and counts calls in files."""

    whole = True

    def __init__(self, folder: Path, send: Send):
        self.folder = folder
        self.send = send
        self.arrays: list[npt.NDArray[Any]] = []
        with (folder / COUNTER).open("r+b") as file:
            self.counter = memoryview(mmap.mmap(file.fileno(), 8)).cast("q")

    def working(self, fmu: str, doing: str) -> None:
        self.send(Work(fmu, doing))

    def allocate(self, shape: tuple[int, int], kind: type) -> npt.NDArray[Any]:
        path = self.folder / f"{TRACK}{len(self.arrays)}.{np.dtype(kind).name}"
        size = shape[0] * shape[1] * np.dtype(kind).itemsize
        with path.open("wb") as file:
            if hasattr(os, "posix_fallocate"):   # a disk that is full only later would end this process
                try:
                    os.posix_fallocate(file.fileno(), 0, size)
                except OSError as error:
                    what = f"{error.strerror} for a recording of {size} bytes"
                    raise OSError(error.errno, what, str(path)) from error
            file.truncate(size)
        self.arrays.append(np.memmap(path, kind, "r+", shape=shape))
        return self.arrays[-1]

    def wired(self, wiring: Wiring) -> None:
        def named(calls: Sequence[Call]) -> list[Work]:
            return [Work(fmu.name, what) for fmu, what in (call.what for call in calls)]

        names = {id(track.array): track.names for track in wiring.tracks}
        self.send(Wired(named(wiring.initial), [*map(named, wiring.phases)], named(wiring.final),
                        [names[id(array)] for array in self.arrays]))


def run_and_report(folder: Path, run: IsolatedRun, send: Send) -> None:
    """Do a run in this process, recorded into a folder, and send reports."""
    observer = Reporter(folder, send)
    try:
        with Master(run.setups, run.connections, run.step, run.order, observer, run.loop) as master:
            master.require_memory(run.stop_time)
            recording = master.run(run.stop_time, run.drives, lambda *steps: send(Stepped(*steps)))
            send(Finished(recording.notes))   # whatever happens in the calls that are left
            for name, fmu in master.fmus.items():
                observer.working(name, f"{fmu.fmi.prefix}FreeInstance")
                fmu.close()
        send(ENDING)
    except RunFailed as error:
        send(Failed(str(error), len(error.recording.time), format_exc()))


def run_apart(run: IsolatedRun, progress: Progress | None = None, timeout: float = TIMEOUT,
              complete: Complete = lambda _: None) -> Recording:
    """Do the work of a `Master` in another process; errors as there, RunFailed also if the process dies.

    A call of an FMU that gives no sign of life for longer than `timeout`, s, ends the run. `complete` is called with
    the recording as soon as that is complete. The process then has `PATIENCE`, or the timeout if that is shorter, to
    end. After that it is ended with its child processes, and a note says so. Interrupted after Ctrl-C or SIGTERM as it
    ends.
    """
    with other_process() as (worker, folder):
        (folder / COUNTER).write_bytes(bytes(8))
        worker.ask(partial(run_and_report, folder, run))
        return Follower(run, folder, worker, timeout).follow(progress, complete)


class Follower:
    """State of a run in another process, as known here."""

    def __init__(self, run: IsolatedRun, folder: Path, process: WorkerProcess, timeout: float):
        self.run = run
        self.folder = folder
        self.process = process
        self.timeout = timeout
        self.work = STARTING
        self.wired = Wired([], [], [], [])   # until the first call
        self.counted = 0
        self.cut = False   # true if somebody has cut the file with the number of calls

    def follow(self, progress: Progress | None, complete: Complete) -> Recording:
        while True:
            try:
                # A slow start of a process is not the fault of an FMU.
                limit = max(self.timeout, TIMEOUT) if self.work == STARTING else self.timeout
                report = self.next(limit)
            except KeyboardInterrupt as error:
                with suppress(Gone):
                    while self.calls() and not self.wired.phases:   # its report is still in the pipe
                        self.next(PATIENCE)
                if not self.begun():
                    raise
                raise self.early_end(error) from None
            except Gone as gone:
                raise self.early_end(self.blame(gone)) from None
            if isinstance(report, Work):
                self.work = report
            elif isinstance(report, Stepped) and progress is not None:
                progress(*report)
            elif isinstance(report, Failed):
                failure = RunFailed(report.message, self.recording(report.rows))
                failure.add_note(report.traceback)
                raise failure
            elif isinstance(report, Finished):
                rows = whole_steps(self.run.stop_time, self.run.step) + 1
                recording = self.recording(rows, report.notes)
                if len(recording.time) < rows:
                    raise self.early_end(FmuError(f"{self.foreign()} has truncated the file of the recording"))
                complete(recording)
                note = self.end()
                return Recording(recording.time, recording.columns, (*recording.notes, note)) if note else recording

    def next(self, limit: float) -> Report:
        """Return the next report, and keep the calls that will be made; Forged if it is no report of a run."""
        said = self.process.next(limit, self.calls)
        report: Report = checked(said, Report)
        if said.last or isinstance(report, Wired if self.wired.phases else Stepped | Finished):
            raise Forged   # the wiring is reported once, before the steps
        if isinstance(report, Stepped) and not 0 <= report.done <= report.steps:
            raise Forged
        if isinstance(report, Wired):
            columns = {name for names in report.columns for name in names}
            if not (any(report.phases) and report.final and columns >= self.run.columns):
                raise Forged
            self.wired = report
        return report

    def end(self) -> str:
        """Let the process end after a complete run, if it does so soon; return a note if it does not end well."""
        self.work, patience = ENDING, min(PATIENCE, self.timeout)
        try:
            for _ in range(len(self.run.setups) + 3):   # each is freed, the task ends, and so does the process
                if (said := self.process.next(patience)).last:
                    self.process.ask(None)
                elif isinstance(said.what, Work):
                    self.work = said.what
        except KeyboardInterrupt as error:
            raise Interrupted(f"{ended_by(error)} after the end of the run", signal_of(error)) from None
        except Gone as gone:
            self.process.end()
            if self.work != ENDING or gone.how not in ("exit code 0", ""):
                return f"{self.name(self.work.fmu)} {gone} in {self.work.doing}, after the end of the run"
            if not gone.how:
                return (f"the process of {self.foreign()} still ran {patience:g} s after the run, and was ended with "
                        "its child processes")
        return (f"the process of {self.foreign()} left child processes, which were ended after the run"
                if self.process.left else "")

    def calls(self) -> int:
        # Read as a file, not mapped: the running code could cut it, and this process would end by SIGBUS.
        with regular(self.folder / COUNTER).open("rb") as file:
            count = file.read(8)
        self.cut = len(count) < 8
        if not self.cut:
            self.counted = int.from_bytes(count, sys.byteorder)
        return self.counted

    def begun(self) -> bool:
        """Return True if a call of the run was begun, and it is known which."""
        return self.calls() > 0 and bool(self.wired.phases)

    def last(self) -> tuple[int, Work]:
        """Communication step and name of the last call that was begun."""
        initial, phases, final, _ = self.wired
        number = self.calls() - 1
        if number < len(initial):
            return 0, initial[number]
        number -= len(initial)
        cycle = [(phase, call) for phase, calls in enumerate(phases) for call in calls]
        steps = whole_steps(self.run.stop_time, self.run.step)
        cycles, rest = divmod(steps, len(phases))
        stepping = cycles * len(cycle) + sum(map(len, phases[:rest]))
        if number >= stepping:
            return steps, final[min(number - stepping, len(final) - 1)]
        cycles, number = divmod(number, len(cycle))
        phase, call = cycle[number]
        return cycles * len(phases) + phase, call

    def blame(self, gone: Gone) -> FmuError:
        """Error of the FMU that was called last, for the end of the process."""
        begun = self.begun()
        if self.cut or not (gone.how or isinstance(gone, Silent)):   # others were called since
            return FmuError(f"{self.foreign()} {gone}{', after it truncated the count of calls' if self.cut else ''}")
        fmu, doing = self.last()[1] if begun else self.work
        return FmuError(f"{self.name(fmu)} {gone} in {doing}")

    def early_end(self, reason: BaseException) -> BaseException:
        """Error for the end of the run, with the recording until then, if there is one."""
        if not self.begun():
            return reason
        step, _ = self.last()
        self.process.end()   # before its memory is read
        return early_end(reason, step * self.run.step, self.recording(step + 1))

    def recording(self, rows: int, notes: tuple[str, ...] = ()) -> Recording:
        """Copy of the first rows of the recording, or of as many as there are."""
        columns: dict[str, Any] = {}
        rows = max(0, min(rows, whole_steps(self.run.stop_time, self.run.step) + 1))
        for number, names in enumerate(self.wired.columns):
            kind = next((kind for kind in KINDS if (self.folder / f"{TRACK}{number}.{kind}").is_file()), None)
            if kind is None:
                return Recording(np.zeros(0), {})
            table, rows = read_track(self.folder / f"{TRACK}{number}.{kind}", len(names), rows)
            columns.update(zip(names, table, strict=True))
        return Recording(self.run.step * np.arange(rows, dtype=np.float64),
                         {name: column[:rows] for name, column in columns.items()}, notes)

    def foreign(self) -> str:
        """Names of the running FMUs that are not of this project."""
        return " or ".join(self.name(setup.name) for setup in self.run.setups
                           if not setup.source.built_here) or STARTING.fmu

    def name(self, fmu: str) -> str:
        return next((f"{fmu} ({setup.source.name})" for setup in self.run.setups if setup.name == fmu), fmu)


def read_track(path: Path, names: int, rows: int) -> tuple[npt.NDArray[Any], int]:
    """Rows of an array in a file, each column as one piece of memory, shape (names, rows), and how many there are."""
    kind = np.dtype(path.suffix[1:])
    rows = min(rows, path.stat().st_size // (kind.itemsize * max(1, names)))   # whatever was said of it
    table = np.empty((names, rows), countable(kind))
    with regular(path).open("rb") as file:
        for first in range(0, rows, PROGRESS_STEPS):
            wanted = min(PROGRESS_STEPS, rows - first)
            part = np.fromfile(file, kind, wanted * names)
            part = part[:len(part) // names * names].reshape(-1, names)
            table[:, first:first + len(part)] = part.T
            if len(part) < wanted:
                return table, first + len(part)
    return table, rows
