"""The other process of a co-simulation apart: it flies, records into files, and reports."""

import mmap
import os
import shutil
import tempfile
import traceback
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from maglev.cosim.apart.child import end_with_parent
from maglev.cosim.apart.reports import (
    COUNTER,
    ENDING,
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
from maglev.cosim.master import Master, Observer, RunFailed
from maglev.cosim.wiring import Call, Track, Wiring
from maglev.errors import FAILURES


class Reporter(Observer):
    """The observer in the other process: sends reports, allocates in files, and counts calls."""

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

    def wired(self, wiring: Wiring) -> Wiring:
        self.reports.send(Wired([named(call) for call in wiring.initial],
                                [[named(call) for call in phase] for phase in wiring.phases],
                                [track.names for track in sorted(wiring.tracks, key=self.number)]))
        return wiring._replace(initial=[self.counted(call) for call in wiring.initial],
                               phases=[[self.counted(call) for call in phase] for phase in wiring.phases])

    def number(self, track: Track) -> int:
        """Number of the file of a track."""
        return next(i for i, array in enumerate(self.arrays) if array is track.array)

    def counted(self, call: Call) -> Call:
        """A call that counts itself before it is made."""
        counter, function = self.counter, call.function

        def counted(*arguments: Any) -> int:
            counter[0] += 1
            status: int = function(*arguments)
            return status

        return call._replace(function=counted)


def named(call: Call) -> Named:
    """Name of a call."""
    fmu, what = call.what
    return Named(fmu.name, what)


def fly(job: Job, reports: Connection) -> None:
    """Run in this process, and send reports."""
    end_with_parent(partial(shutil.rmtree, job.folder, ignore_errors=True))
    tempfile.tempdir = str(job.folder)   # what is unpacked goes with it, however this process ends
    try:
        observer = Reporter(job.folder, reports)
        with Master(job.setups, job.connections, job.step, job.order, observer) as master:
            master.require_memory(job.stop_time)
            recording = master.run(job.stop_time, job.drives, lambda *steps: reports.send(Stepped(*steps)))
            reports.send(Finished(recording.notes))   # whatever happens in the calls that are left
            for name, fmu in master.fmus.items():
                observer.stage(name, "fmi2FreeInstance")
                fmu.close()
        reports.send(ENDING)
    except RunFailed as error:
        reports.send(Failed(str(error), len(error.recording.time)))
    except FAILURES as error:
        reports.send(Refused(error))
    except Exception:
        reports.send(Refused(None, traceback.format_exc()))
