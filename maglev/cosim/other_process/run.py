"""Co-simulation in a process of its own: an FMU that crashes, exits or hangs there takes nothing with it.

The process records into files that both map into memory, and counts its calls of FMUs there, too. So whatever happens,
this side has the recording until then, and knows which call was the last.
"""

import pickle
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from maglev.cosim.fmu import unpacking_folder
from maglev.cosim.master import FmuSetup, Progress, Recording, RunFailed, by_column, ended, whole_steps
from maglev.cosim.order import Order
from maglev.cosim.other_process.flight import fly
from maglev.cosim.other_process.helper import Helper, helper
from maglev.cosim.other_process.reports import (
    COUNTER,
    ENDING,
    JOB,
    STARTING,
    TRACK,
    Failed,
    Finished,
    Job,
    Named,
    Refused,
    Stage,
    Stepped,
    Wired,
)
from maglev.cosim.wiring import Drives
from maglev.errors import FmuError
from maglev.processes.child import POLL, end, how_it_ended
from maglev.processes.interrupts import held_interrupts
from maglev_files.scratch import remove_scratch

TIMEOUT = 60.0   # s, after which an FMU that says nothing is taken to hang


def run_apart(setups: Sequence[FmuSetup], connections: Sequence[tuple[str, str]], step: float, order: Order,
              stop_time: float, drives: Drives, progress: Progress | None = None,
              timeout: float = TIMEOUT) -> Recording:
    """Do in another process what a `Master` does in this one; parameters and errors as of it.

    Parameters
    ----------
    timeout : float
        Longest time without a sign of life, s: a call of an FMU that takes longer ends the run.

    Raises
    ------
    RunFailed
        Also if the process dies, or a call takes too long.
    """
    with held_interrupts() as let_through:
        folder = unpacking_folder()
        try:
            job = Job(setups, connections, step, order, stop_time, drives)
            (folder / JOB).write_bytes(pickle.dumps(job))
            (folder / COUNTER).write_bytes(bytes(8))
            found = helper()
            try:
                found.ask(partial(fly, folder))
                return Follower(job, folder, found, timeout).follow(progress, let_through)
            finally:
                found.end()
        finally:
            remove_scratch(folder)


class Follower:
    """What is known here about a run in another process."""

    def __init__(self, job: Job, folder: Path, flying: Helper, timeout: float):
        self.job = job
        self.folder = folder
        self.process, self.reports = flying
        self.timeout = timeout
        self.stage = STARTING
        self.wired: Wired | None = None
        self.counter = np.memmap(folder / COUNTER, np.int64, "r")

    def follow(self, progress: Progress | None, let_through: Callable[[], None]) -> Recording:
        """Recording of the run at its end."""
        while True:
            try:
                report = self.report(let_through)
            except KeyboardInterrupt as error:
                if not self.calls():
                    raise
                raise self.early(error) from None
            if isinstance(report, str):
                raise self.early(self.blame(report))
            if isinstance(report, Stage):
                self.stage = report
            elif isinstance(report, Wired):
                self.wired = report
            elif isinstance(report, Stepped) and progress is not None:
                progress(*report)
            elif isinstance(report, Failed):
                failure = RunFailed(report.message, self.recording(report.rows))
                failure.add_note(report.traceback)
                raise failure
            elif isinstance(report, Refused):
                raise report.error or RuntimeError(report.bug)
            elif isinstance(report, Finished):
                rows = whole_steps(self.job.stop_time, self.job.step) + 1
                return self.complete(self.recording(rows, report.notes), let_through)

    def report(self, let_through: Callable[[], None]) -> Any:
        """Next report; a text if there will be none: how the process died, or that it is silent."""
        silent, calls = 0.0, self.calls()
        # No FMU is to blame for a machine that takes its time to start a process.
        most = max(self.timeout, TIMEOUT) if self.stage == STARTING else self.timeout
        while not self.reports.poll(POLL):
            let_through()
            # Looks are counted, not time: a machine that sleeps is no silence.
            silent, calls = (silent + POLL, calls) if self.calls() == calls else (0.0, self.calls())
            if silent > most:
                return f"has been silent for {most:g} s"
        try:
            return self.reports.recv()
        except (EOFError, OSError):
            self.process.join()
            return f"ended its process with {how_it_ended(self.process)}"

    def complete(self, found: Recording, let_through: Callable[[], None]) -> Recording:
        """Recording of a complete run, with a note if an FMU does not end as it should."""
        while not isinstance(report := self.report(let_through), str):
            if isinstance(report, Stage):
                self.stage = report
        if self.process.exitcode == 0 and self.stage == ENDING:
            return found
        note = f"{self.name(self.stage.fmu)} {report} in {self.stage.doing}, after the end of the run"
        return Recording(found.time, found.columns, (*found.notes, note))

    def calls(self) -> int:
        """Number of calls that were begun."""
        return int(self.counter[0])

    def last(self) -> tuple[int, Named]:
        """Communication step and name of the last call that was begun."""
        assert self.wired is not None
        initial, phases, _ = self.wired
        number = self.calls() - 1
        if number < len(initial):
            return 0, initial[number]
        cycles, number = divmod(number - len(initial), sum(map(len, phases)))
        for phase, calls in enumerate(phases):
            if number < len(calls):
                return cycles * len(phases) + phase, calls[number]
            number -= len(calls)
        raise AssertionError("a number below the sum is in one of the phases")

    def blame(self, what: str) -> FmuError:
        """Error of the FMU that was called last, which did this."""
        if not self.calls():
            return FmuError(f"{self.name(self.stage.fmu)} {what} in {self.stage.doing}")
        call = self.last()[1]
        return FmuError(f"{self.name(call.fmu)} {what} in {call.what}")

    def early(self, reason: BaseException) -> BaseException:
        """Error for the end of the run, with what was recorded until then, if anything was."""
        if not self.calls():
            return reason
        step, _ = self.last()
        end(self.process)   # before its memory is read
        return ended(reason, step * self.job.step, self.recording(step + 1))

    def recording(self, rows: int, notes: tuple[str, ...] = ()) -> Recording:
        """Copy of the first rows of what was recorded."""
        assert self.wired is not None
        columns: dict[str, Any] = {}
        for number, names in enumerate(self.wired.columns):
            path = next(self.folder.glob(f"{TRACK}{number}.*"))
            table = np.memmap(path, path.suffix[1:], "r").reshape(-1, len(names))[:rows]
            columns.update(zip(names, by_column(table), strict=True))
        return Recording(self.job.step * np.arange(rows, dtype=np.float64), columns, notes)

    def name(self, fmu: str) -> str:
        """Name of an FMU with that of its file."""
        return next((f"{fmu} ({setup.path.name})" for setup in self.job.setups if setup.name == fmu), fmu)
