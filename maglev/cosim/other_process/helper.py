"""The process that runs what is not ours: it reads Python files of users, and runs one run, study or analysis.

Whatever such a file does when it is imported (it ends the process, or hangs) happens there. The process that has read
it waits, for what follows.
"""

import atexit
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from maglev.cosim.fmu import unpacking_folder
from maglev.cosim.user_classes.fmu import description_text
from maglev.errors import ControllerError, FmuError
from maglev.processes.beside import SERVING, Beside, Gone, Send, Silent
from maglev.processes.interrupts import held_interrupts
from maglev.user_controllers.source import digests, file_of
from maglev_files.scratch import remove_scratch

READING = 60.0   # s, at least, in which a Python file is to be imported

WAITING: dict[int, Beside] = {}                     # of the process with that number, which alone can end it
DESCRIPTIONS: dict[tuple[Path, str], bytes] = {}    # of Python files, by path and digest of everything that is read


@contextmanager
def other_process(keep: bool = False) -> Iterator[tuple[Beside, Path]]:
    """The process that waits, or a new one, and the folder in which it unpacks; both go with the block.

    With `keep` it waits for another task, unless the block fails. Interrupts are held back but where it is listened to.
    """
    with held_interrupts() as let_through:
        beside = WAITING.pop(os.getpid(), None)
        if beside is None or beside.process.poll() is not None:
            removed(beside)
            beside = Beside(folder_for_any())
        assert beside.folder is not None
        beside.let_through = let_through
        try:
            yield beside, beside.folder
        except BaseException:
            keep = False
            raise
        finally:
            if keep:
                WAITING[os.getpid()] = beside
            else:
                removed(beside)


def folder_for_any() -> Path:
    """Folder for whatever is unpacked in it; where none is for FMUs that run Python, these say so themselves."""
    try:
        return unpacking_folder()
    except FmuError:
        return unpacking_folder(python=False)


def removed(beside: Beside | None) -> None:
    if beside is not None and beside.folder is not None:
        beside.end()
        remove_scratch(beside.folder)


@atexit.register
def end_waiting() -> None:
    removed(WAITING.pop(os.getpid(), None))


def read_apart(path: Path, timeout: float = 0.0) -> bytes:
    """Model description of the class that the path of a Python file names, which is imported in another process.

    ControllerError also if the process ends, or takes longer than `READING` and `timeout`, s.
    """
    key = (path.absolute(), str(digests(path)))
    if key in DESCRIPTIONS:
        return DESCRIPTIONS[key]
    if any(SERVING):
        return description_text(path)
    limit = max(timeout, READING)
    with other_process(keep=True) as (beside, _):
        beside.ask(partial(describe, path))
        try:
            text: bytes = beside.next(limit).what
        except Gone as gone:
            what = (f"ended the process that reads it with {gone.how}" if gone.how else
                    f"was not read within {limit:g} s" if isinstance(gone, Silent) else str(gone))
            raise ControllerError(f"{file_of(path)[0].name}: {what}, expected a file that can be imported, and a class "
                                  "of which an object can be made") from None
    DESCRIPTIONS[key] = text
    return text


def describe(path: Path, _send: Send) -> bytes:
    return description_text(path)
