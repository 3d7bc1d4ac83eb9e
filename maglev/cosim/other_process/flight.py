"""The other process of a co-simulation apart: it flies, records into files, and reports."""

import mmap
import os
from pathlib import Path
from traceback import format_exc
from typing import Any

import numpy as np
import numpy.typing as npt

from maglev.cosim.master import Master, Observer, RunFailed
from maglev.cosim.other_process.reports import COUNTER, ENDING, TRACK, Failed, Finished, Job, Stage, Stepped, Wired
from maglev.cosim.wiring import Track, Wiring
from maglev.processes.beside import Send


class Reporter(Observer):
    """The observer in the other process: sends reports, allocates and counts calls in files."""

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
                        [track.names for track in sorted(wiring.tracks, key=self.number)]))

    def number(self, track: Track) -> int:
        """Number of the file of a track."""
        return next(i for i, array in enumerate(self.arrays) if array is track.array)


def fly(folder: Path, job: Job, send: Send) -> None:
    """Do a run in this process, recorded into a folder, and send reports."""
    observer = Reporter(folder, send)
    try:
        with Master(job.setups, job.connections, job.step, job.order, observer) as master:
            master.require_memory(job.stop_time)
            recording = master.run(job.stop_time, job.drives, lambda *steps: send(Stepped(*steps)))
            send(Finished(recording.notes))   # whatever happens in the calls that are left
            for name, fmu in master.fmus.items():
                observer.stage(name, "fmi2FreeInstance")
                fmu.close()
        send(ENDING)
    except RunFailed as error:
        send(Failed(str(error), len(error.recording.time), format_exc()))
