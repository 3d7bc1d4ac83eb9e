"""The process for third-party code: it reads Python files of users, and does one run, study, check or analysis.

Whatever such a file does when it is imported (it ends the process, or hangs) happens there. The process that has read
it waits for the next task. This is the one way to third-party code, without a pool of processes such as those of
`concurrent.futures`. A pool unpickles the messages of its processes, loses all of them when one dies, and leaves alive
the processes that they have started.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from maglev.cosim.fmu import unpacking_folder
from maglev.cosim.user_class import description_text
from maglev.files.errors import ControllerError, FmuError
from maglev.files.interrupts import held_interrupts
from maglev.files.json_lines import fits
from maglev.files.scratch import remove_scratch
from maglev.files.session import SESSION
from maglev.files.worker_process import Forged, Gone, Said, Send, Served, Silent, Task, WorkerProcess
from maglev.user.source import Digests, PythonFile

STARTED_WITHIN = 60.0   # s, at least, until the first report: no FMU is to blame for a machine that takes its time


class Helper:
    """The process that waits for a task, and the descriptions that it has read."""

    def __init__(self) -> None:
        # of the process with that number, which alone can end it
        self.waiting: dict[int, WorkerProcess] = {}
        # of Python files, by absolute path and digests of everything that is read
        self.descriptions: dict[tuple[PythonFile, Digests], bytes] = {}

    def close(self) -> None:
        removed(self.waiting.pop(os.getpid(), None))


@contextmanager
def other_process(keep: bool = False) -> Iterator[tuple[WorkerProcess, Path]]:
    """The process that waits, or a new one, and the folder in which it unpacks; both go with the block.

    With `keep` it waits for another task, unless the block fails. Interrupts are held back but where it is listened to.
    """
    waiting = SESSION.get(Helper).waiting
    with held_interrupts() as let_through:
        worker = waiting.pop(os.getpid(), None)
        if worker is None or worker.process.poll() is not None:
            removed(worker)
            worker = WorkerProcess(folder_for_any())
        assert worker.folder is not None
        worker.let_through = let_through
        try:
            yield worker, worker.folder
        except BaseException:
            keep = False
            raise
        finally:
            if keep:
                waiting[os.getpid()] = worker
            else:
                removed(worker)


def folder_for_any() -> Path:
    """Folder for unpacked files; if there is no folder for FMUs that run Python, these raise their own error."""
    try:
        return unpacking_folder()
    except FmuError:
        return unpacking_folder(python=False)


def removed(worker: WorkerProcess | None) -> None:
    if worker is not None and worker.folder is not None:
        worker.end()
        remove_scratch(worker.folder)


def called_apart(task: Task, names: str, limit: float, kind: Any,
                 progress: Callable[[int, int], None] = lambda done, steps: None) -> Any:
    """Return the result of a task, done in another process, where it sends the steps done and the steps in all.

    FmuError, which begins with the names of the code that runs, if the process dies, or sends nothing for longer than
    `limit` (s), before the first report longer than `STARTED_WITHIN`. Also if a message is no report, or no result of
    the type `kind`.
    """
    with other_process() as (worker, _):
        worker.ask(task)
        patience = max(limit, STARTED_WITHIN)
        try:
            while not (said := worker.next(patience)).last:
                done, steps = checked(said, tuple[int, int])
                if not 0 <= done <= steps:
                    raise Forged
                progress(done, steps)
                patience = limit
            return checked(said, kind)
        except Gone as gone:
            raise FmuError(f"{names} {gone}") from None


def checked(said: Said, kind: Any) -> Any:
    """Return what a process that is not trusted has said; Forged if it is not of a type."""
    if not fits(said.what, kind):
        raise Forged
    return said.what


def read_apart(source: PythonFile, timeout: float = 0.0) -> bytes:
    """Model description of the class in a Python file, which is imported in another process.

    ControllerError also if the process ends, or takes longer than `STARTED_WITHIN` and `timeout`, s.
    """
    key = (replace(source, path=source.path.absolute()), source.digests())
    descriptions = SESSION.get(Helper).descriptions
    if key in descriptions:
        return descriptions[key]
    if SESSION.get(Served).third_party:
        return description_text(source)
    limit = max(timeout, STARTED_WITHIN)
    with other_process(keep=True) as (worker, _):
        worker.ask(partial(describe, source))
        try:
            text: bytes = checked(worker.next(limit), bytes)
        except Gone as gone:
            what = (f"ended the process that reads it with {gone.how}" if gone.how else
                    f"was not read within {limit:g} s" if isinstance(gone, Silent) else str(gone))
            raise ControllerError(f"{source.path.name}: {what}, expected an importable file, and a class that "
                                  "can be instantiated") from None
    descriptions[key] = text
    return text


def describe(source: PythonFile, _send: Send) -> bytes:
    return description_text(source)
