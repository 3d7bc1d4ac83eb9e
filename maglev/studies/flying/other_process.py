"""Samples flown in a process beside the worker: an FMU that hangs or crashes there costs its sample, and no worker.

The process is no child as multiprocessing starts them: the workers of a cluster are daemonic and may have none.
"""

import os
import pickle
import queue
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.cosim.fmu import unpacking_folder
from maglev.errors import MaglevError
from maglev.processes.child import PATIENCE, interrupts_blocked, named_end
from maglev.studies.flying.samples import Job, Sample, each_flown, failed
from maglev_files.scratch import remove_scratch

STARTED_WITHIN = 60.0   # s, of the process, at least: no sample is to blame for a machine that takes its time
FLIGHTS = 2             # of a sample whose process dies: the first time it may be want of memory
PROGRAM = "import sys; sys.path[:] = {path!r}; from maglev.studies.flying.other_process import fly; fly({folder!r})"
READY = "ready"


def each_flown_apart(job: Job, values: NDArray[np.float64], limit: float) -> Iterator[Sample]:
    """Fly samples in a process beside this one, and in another after each that takes longer than `limit`, s.

    Raises
    ------
    MaglevError
        If the FMUs cannot be loaded.
    """
    done, deaths = 0, 0
    while done < len(values):
        with Beside(job, values[done:], limit) as beside:
            try:
                for sample in beside.samples():
                    yield sample
                    done, deaths = done + 1, 0
            except TimeoutError:
                if not beside.loaded:
                    raise MaglevError(f"the FMUs were not loaded within {beside.patience:g} s") from None
                yield failed(job, f"took longer than {limit:g} s")
                done, deaths = done + 1, 0
            except EOFError:
                deaths += 1
                if deaths < FLIGHTS:
                    continue
                why = f"the process that flew it ended ({beside.how_it_ended()})"
                if not beside.loaded:
                    raise MaglevError(f"the FMUs cannot be loaded: {why}") from None
                yield failed(job, why)
                done, deaths = done + 1, 0


class Beside:
    """A process that flies samples; a context manager that ends it."""

    def __init__(self, job: Job, values: NDArray[np.float64], limit: float):
        self.limit = limit
        self.patience = max(limit, STARTED_WITHIN)
        self.loaded = False
        self.folder = unpacking_folder()
        self.reports: queue.Queue[Any] = queue.Queue()
        with interrupts_blocked():
            self.process = subprocess.Popen(
                [sys.executable, "-c", PROGRAM.format(path=sys.path, folder=str(self.folder))],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        threading.Thread(target=self.receive, daemon=True).start()
        assert self.process.stdin is not None
        try:
            pickle.dump((job, values), self.process.stdin)
            self.process.stdin.flush()   # and it stays open: its end is that of this process
        except BrokenPipeError:
            pass   # it has ended, which `samples` tells

    def __enter__(self) -> "Beside":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdin is not None
        with suppress(BrokenPipeError):
            self.process.stdin.close()
        remove_scratch(self.folder)

    def receive(self) -> None:
        """Pass on what the process sends, and at last that it has ended."""
        assert self.process.stdout is not None
        try:
            while True:
                self.reports.put(pickle.load(self.process.stdout))
        except (EOFError, pickle.UnpicklingError):   # it ended, perhaps in the middle of a report
            self.reports.put(EOFError())
        self.process.stdout.close()

    def samples(self) -> Iterator[Sample]:
        """Samples as they come; TimeoutError if one takes too long, EOFError if the process dies."""
        self.next(self.patience)
        self.loaded = True
        while (report := self.next(self.limit)) is not None:
            yield report

    def next(self, limit: float) -> Any:
        """What the process sends next, within so many seconds; the error if it is one."""
        try:
            report = self.reports.get(timeout=limit)
        except queue.Empty:
            raise TimeoutError from None
        if isinstance(report, BaseException):
            raise report
        return report

    def how_it_ended(self) -> str:
        """Signal or exit code of the process, whose end was told."""
        return named_end(self.process.wait(timeout=PATIENCE))


def fly(folder: str) -> None:
    """Fly, in the other process, what comes on standard input, and send each sample; unpack into a folder."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)   # the one that plans handles it for all
    tempfile.tempdir = folder
    sent = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)   # what FMUs print is none of it
    job, values = pickle.load(sys.stdin.buffer)
    threading.Thread(target=end_with_parent, args=(Path(folder),), daemon=True).start()

    def send(report: object) -> None:
        pickle.dump(report, sent)
        sent.flush()

    try:
        for sample in each_flown(job, values, partial(send, READY)):
            send(sample)
        send(None)
    except Exception as error:
        send(error)
    os._exit(0)   # whatever FMUs do when they are freed


def end_with_parent(folder: Path) -> None:
    """End this process with the one that started it."""
    sys.stdin.buffer.read()
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)
