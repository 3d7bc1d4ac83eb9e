"""The other process of a co-simulation apart: it flies, records into files, and reports; and what it reports."""

import mmap
import os
from collections.abc import Sequence
from pathlib import Path
from traceback import format_exc
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from maglev.cosim import Order
from maglev.cosim.master import FmuSetup, Master, Observer, RunFailed
from maglev.cosim.wires.wiring import Drives, Track, Wiring
from maglev.processes.beside import Send
from maglev_files.cache import Kept

COUNTER = "calls"   # file with the number of calls that were begun
TRACK = "track"     # files of the arrays, TRACK0.float64 and so on


class Job(NamedTuple):
    """A run, as of `Master`."""

    setups: Sequence[FmuSetup]
    connections: Sequence[tuple[str, str]]
    step: float
    order: Order
    stop_time: float
    drives: Drives
    loop: Kept | None = None


class Stage(NamedTuple):
    """A call of an FMU, by its name; as a report: what is done with it now, while no calls are counted."""

    fmu: str
    doing: str


STARTING = Stage("the process of the run", "its start")
ENDING = Stage("the process of the run", "its end")


class Wired(NamedTuple):
    """Report: the calls before the first step, of each phase, and after the last step; the columns of each array."""

    initial: list[Stage]
    phases: list[list[Stage]]
    final: list[Stage]
    columns: list[list[str]]


class Stepped(NamedTuple):
    """Report: progress."""

    done: int
    steps: int


class Finished(NamedTuple):
    """Report: the recording is complete; notes as of `Recording`."""

    notes: tuple[str, ...]


class Failed(NamedTuple):
    """Report: an FMU refused a call, after so many rows; with the traceback of that."""

    message: str
    rows: int
    traceback: str


class Reporter(Observer):
    """The observer in the other process: sends reports, allocates and counts calls in files."""

    whole = True

    def __init__(self, folder: Path, send: Send):
        self.folder = folder
        self.send = send
        self.arrays: list[npt.NDArray[Any]] = []
        with (folder / COUNTER).open("r+b") as file:
            self.counter = memoryview(mmap.mmap(file.fileno(), 8)).cast("q")

    def stage(self, fmu: str, doing: str) -> None:
        self.send(Stage(fmu, doing))

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
        def named(fmu: Any, what: str) -> Stage:
            return Stage(fmu.name, what)

        self.send(Wired([named(*call.what) for call in wiring.initial],
                        [[named(*call.what) for call in phase] for phase in wiring.phases],
                        [named(*call.what) for call in wiring.final],
                        [track.names for track in sorted(wiring.tracks, key=self.number)]))

    def number(self, track: Track) -> int:
        """Number of the file of a track."""
        return next(i for i, array in enumerate(self.arrays) if array is track.array)


def fly(folder: Path, job: Job, send: Send) -> None:
    """Do a run in this process, recorded into a folder, and send reports."""
    observer = Reporter(folder, send)
    try:
        with Master(job.setups, job.connections, job.step, job.order, observer, job.loop) as master:
            master.require_memory(job.stop_time)
            recording = master.run(job.stop_time, job.drives, lambda *steps: send(Stepped(*steps)))
            send(Finished(recording.notes))   # whatever happens in the calls that are left
            for name, fmu in master.fmus.items():
                observer.stage(name, f"{fmu.fmi.prefix}FreeInstance")
                fmu.close()
        send(ENDING)
    except RunFailed as error:
        send(Failed(str(error), len(error.recording.time), format_exc()))
