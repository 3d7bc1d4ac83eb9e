"""The process that runs what is not ours: it reads Python files of users, and flies one run.

Whatever such a file does when it is imported (it ends the process, or hangs) happens there. The process that has read
it waits, for the run that follows.
"""

import atexit
import os
import shutil
import signal
import sys
from collections.abc import Callable
from functools import partial
from multiprocessing import Pipe, current_process
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from traceback import format_exc
from typing import NamedTuple

from maglev.cosim.user_classes.fmu import description_text
from maglev.errors import FAILURES, ControllerError
from maglev.processes.child import POLL, end, end_with_parent, how_it_ended, start
from maglev.processes.interrupts import held_interrupts
from maglev.user_controllers.source import digests, file_of

NAME = "maglev helper"
READING = 60.0   # s, at least, in which a Python file is to be imported

Task = Callable[[Connection], bool]   # can be pickled; sends what it finds, and says whether another may follow


class Helper(NamedTuple):
    """The other process, and the pipe to it."""

    process: BaseProcess
    pipe: Connection

    def ask(self, task: Task) -> None:
        """Have a task done in the folder of this process; one that has ended says so by the end of its reports."""
        try:
            self.pipe.send((os.getcwd(), task))   # short: what is longer than a pipe holds would wait for its reader
        except ConnectionError:
            return

    def end(self) -> None:
        """End it, whatever it does."""
        end(self.process)
        self.pipe.close()


WAITING: dict[int, Helper] = {}                     # of the process with that number, which alone can end it
DESCRIPTIONS: dict[tuple[Path, str], bytes] = {}    # of Python files, by path and digest of everything that is read
TEMPORARY: list[Path] = []                          # folders that the other process removes if this one ends


def helper() -> Helper:
    """The process that waits, or a new one."""
    found = WAITING.pop(os.getpid(), None)
    if found is not None:
        if found.process.is_alive():
            return found
        found.end()
    ours, theirs = Pipe()
    try:
        return Helper(start(serve, theirs, name=NAME), ours)
    finally:
        theirs.close()


@atexit.register
def end_waiting() -> None:
    """End the process that waits: multiprocessing would wait for it."""
    found = WAITING.pop(os.getpid(), None)
    if found is not None:
        found.end()


def read_apart(path: Path, timeout: float = 0.0) -> bytes:
    """Model description of the class that the path of a Python file names, which is imported in another process.

    Parameters
    ----------
    path : Path
    timeout : float
        Longest time that this may take, s, if it is longer than `READING`.

    Raises
    ------
    ControllerError
        Also if the process ends, or takes too long.
    """
    key = (path.absolute(), str(digests(path)))
    if key in DESCRIPTIONS:
        return DESCRIPTIONS[key]
    if current_process().name == NAME:
        return description_text(path)
    with held_interrupts() as let_through:
        found = helper()
        try:
            found.ask(partial(describe, path))
            text, error = answer(found, path, max(timeout, READING), let_through)
        except BaseException:
            found.end()
            raise
        WAITING[os.getpid()] = found
    if error is not None:
        raise error
    DESCRIPTIONS[key] = text
    return text


def answer(found: Helper, path: Path, timeout: float,
           let_through: Callable[[], None]) -> tuple[bytes, Exception | None]:
    """What the other process finds, within so many seconds."""
    waited = 0.0
    while not found.pipe.poll(POLL):
        let_through()
        waited += POLL
        if waited > timeout:
            what = f"was not read within {timeout:g} s"
            break
    else:
        try:
            text, error = found.pipe.recv()
            return text, error
        except (EOFError, OSError):
            found.process.join()
            what = f"ended the process that reads it with {how_it_ended(found.process)}"
    raise ControllerError(f"{file_of(path)[0].name}: {what}, expected a file that can be imported, and a class of "
                          "which an object can be made")


def serve(pipe: Connection) -> None:
    """Do tasks in this process as they are asked for."""
    end_with_parent(remove_temporary)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)   # the first process ends this one
    os.dup2(2, 1)   # what is printed here is no result
    sys.stdout = sys.stderr
    try:
        more = True
        while more:
            folder, task = pipe.recv()
            os.chdir(folder)
            more = task(pipe)
    except (EOFError, ConnectionError):   # nobody asks, or wants to know
        return


def remove_temporary() -> None:
    """Remove what this process has unpacked."""
    for folder in TEMPORARY:
        shutil.rmtree(folder, ignore_errors=True)


def describe(path: Path, pipe: Connection) -> bool:
    """Read a Python file in this process, and send the model description of its class, or what is wrong with it."""
    try:
        pipe.send((description_text(path), None))
    except FAILURES as error:
        error.add_note(format_exc())
        pipe.send((b"", error))
    return True
