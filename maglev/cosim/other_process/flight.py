"""The other process of a co-simulation apart: it flies, records into files, and reports."""

import mmap
import os
import pickle
import tempfile
import traceback
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from maglev.cosim.master import Master, Observer, RunFailed
from maglev.cosim.other_process.helper import TEMPORARY
from maglev.cosim.other_process.reports import (
    COUNTER,
    ENDING,
    JOB,
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
from maglev.cosim.wiring import Call, Track, Wiring
from maglev.errors import FAILURES


class Reporter(Observer):
    """The observer in the other process: sends reports, allocates and counts calls in files."""

    def __init__(self, folder: Path, reports: Connection):
        self.folder = folder
        self.reports = reports
        self.arrays: list[npt.NDArray[Any]] = []
        with (folder / COUNTER).open("r+b") as file:
            self.counter = memoryview(mmap.mmap(file.fileno(), 8)).cast("q")

    def stage(self, fmu: str, doing: str) -> None:
        self.reports.send(Stage(fmu, doing))

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
        self.reports.send(Wired([named(call) for call in wiring.initial],
                                [[named(call) for call in phase] for phase in wiring.phases],
                                [track.names for track in sorted(wiring.tracks, key=self.number)]))

    def number(self, track: Track) -> int:
        """Number of the file of a track."""
        return next(i for i, array in enumerate(self.arrays) if array is track.array)


def named(call: Call) -> Named:
    """Name of a call."""
    fmu, what = call.what
    return Named(fmu.name, what)


def fly(folder: Path, reports: Connection) -> bool:
    """Run in this process what lies in a folder, and send reports."""
    TEMPORARY.append(folder)
    tempfile.tempdir = str(folder)   # what is unpacked goes with it, however this process ends
    try:
        job: Job = pickle.loads((folder / JOB).read_bytes())
        observer = Reporter(folder, reports)
        with Master(job.setups, job.connections, job.step, job.order, observer) as master:
            master.require_memory(job.stop_time)
            recording = master.run(job.stop_time, job.drives, lambda *steps: reports.send(Stepped(*steps)))
            reports.send(Finished(recording.notes))   # whatever happens in the calls that are left
            for name, fmu in master.fmus.items():
                observer.stage(name, "fmi2FreeInstance")
                fmu.close()
        reports.send(ENDING)
    except RunFailed as error:
        reports.send(Failed(str(error), len(error.recording.time), traceback.format_exc()))
    except FAILURES as error:
        error.add_note(traceback.format_exc())
        reports.send(Refused(error))
    except Exception:
        reports.send(Refused(None, traceback.format_exc()))
    return False   # what was loaded stays in this process
