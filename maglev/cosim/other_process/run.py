"""Co-simulation in a process of its own: an FMU that crashes, exits or hangs there takes nothing with it.

The process records into files that both map into memory, and counts its calls of FMUs there, too. So whatever happens,
this side has the recording until then, and knows which call was the last.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from maglev.cosim.master import FmuSetup, Progress, Recording, RunFailed, by_column, ended, whole_steps
from maglev.cosim.order import Order
from maglev.cosim.other_process.flight import (
    COUNTER,
    ENDING,
    STARTING,
    TRACK,
    Failed,
    Finished,
    Job,
    Stage,
    Stepped,
    Wired,
    fly,
)
from maglev.cosim.other_process.helper import other_process
from maglev.cosim.wiring import Drives
from maglev.errors import FmuError
from maglev.processes.beside import Beside, Gone, Said

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
    job = Job(setups, connections, step, order, stop_time, drives)
    with other_process() as (found, folder):
        (folder / COUNTER).write_bytes(bytes(8))
        found.ask(partial(fly, folder, job))
        return Follower(job, folder, found, timeout).follow(progress)


class Follower:
    """What is known here about a run in another process."""

    def __init__(self, job: Job, folder: Path, flying: Beside, timeout: float):
        self.job = job
        self.folder = folder
        self.flying = flying
        self.timeout = timeout
        self.stage = STARTING
        self.wired: Wired | None = None
        self.counter = np.memmap(folder / COUNTER, np.int64, "r")

    def follow(self, progress: Progress | None) -> Recording:
        """Recording of the run at its end."""
        while True:
            try:
                report = self.said().what
            except KeyboardInterrupt as error:
                if not self.calls():
                    raise
                raise self.early(error) from None
            except Gone as gone:
                raise self.early(self.blame(gone)) from None
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
            elif isinstance(report, Finished):
                rows = whole_steps(self.job.stop_time, self.job.step) + 1
                return self.complete(self.recording(rows, report.notes))

    def said(self) -> Said:
        """What the process says next; an FMU that is called gives a sign of life, too."""
        # No FMU is to blame for a machine that takes its time to start a process.
        return self.flying.next(max(self.timeout, TIMEOUT) if self.stage == STARTING else self.timeout, self.calls)

    def complete(self, found: Recording) -> Recording:
        """Recording of a complete run, with a note if an FMU does not end as it should."""
        try:
            while not (said := self.said()).last:
                self.stage = said.what
            self.flying.ask(None)
            raise AssertionError(self.said())   # it ends
        except Gone as gone:
            if self.stage == ENDING and gone.how == "exit code 0":
                return found
            note = f"{self.name(self.stage.fmu)} {gone} in {self.stage.doing}, after the end of the run"
        return Recording(found.time, found.columns, (*found.notes, note))

    def calls(self) -> int:
        """Number of calls that were begun."""
        return int(self.counter[0])

    def last(self) -> tuple[int, Stage]:
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

    def blame(self, gone: Gone) -> FmuError:
        """Error of the FMU that was called last, which did this."""
        fmu, doing = self.last()[1] if self.calls() else self.stage
        return FmuError(f"{self.name(fmu)} {gone} in {doing}")

    def early(self, reason: BaseException) -> BaseException:
        """Error for the end of the run, with what was recorded until then, if anything was."""
        if not self.calls():
            return reason
        step, _ = self.last()
        self.flying.end()   # before its memory is read
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
