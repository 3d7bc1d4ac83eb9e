"""An analysis in a process of its own, where what flies in it is not of this project: it may crash, exit or hang."""

import tempfile
import traceback
from collections.abc import Callable, Sequence
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, TypeVar

from maglev.analysis import participant
from maglev.cosim.fmu import unpacking_folder
from maglev.cosim.other_process.helper import TEMPORARY, Helper, helper
from maglev.cosim.other_process.run import TIMEOUT
from maglev.errors import FAILURES, ControllerError, FmuError
from maglev.experiment.preparation import flies_apart
from maglev.processes.child import POLL, how_it_ended
from maglev.processes.interrupts import held_interrupts
from maglev.user_controllers.source import is_class
from maglev_files.scratch import remove_scratch

Found = TypeVar("Found")


def apart(function: Callable[..., Found], files: Sequence[Path], timeout: float, *arguments: Any,
          **options: Any) -> Found:
    """Call a function of a module here, or where one of the files is not of this project, in another process.

    Parameters
    ----------
    function : callable
    files : sequence of Path
        What it flies.
    timeout : float
        Longest time without a step, s; `TIMEOUT` at least.
    *arguments, **options
        Of the function.

    Raises
    ------
    FmuError
        If the process dies, or a step takes too long.
    ControllerError
        If one of the files stands for a class, which only this process knows, and another has to fly elsewhere.
    """
    foreign = [path for path in files if flies_apart(path)]
    if not foreign:
        return function(*arguments, **options)
    for path in files:
        if is_class(path):
            raise ControllerError(f"{path}: was given as a class, which flies in this process alone, but "
                                  f"{foreign[0].name} flies in another; expected the file of the class")
    with held_interrupts() as let_through:
        folder = unpacking_folder()
        try:
            found = helper()
            try:
                found.ask(partial(work, folder, function, arguments, options))
                answer: Found = wait(found, foreign, max(timeout, TIMEOUT), let_through)
                return answer
            finally:
                found.end()
        finally:
            remove_scratch(folder)


def wait(found: Helper, foreign: Sequence[Path], timeout: float, let_through: Callable[[], None]) -> Any:
    """What the other process finds."""
    names, silent = " or ".join(path.name for path in foreign), 0.0
    while True:
        let_through()
        if not found.pipe.poll(POLL):
            silent += POLL
            if silent > timeout:
                raise FmuError(f"{names} has been silent for {timeout:g} s")
            continue
        try:
            kind, answer = found.pipe.recv()
        except (EOFError, OSError):
            found.process.join()
            raise FmuError(f"{names} ended its process with {how_it_ended(found.process)}") from None
        if kind == "refused":
            raise answer
        if kind == "bug":
            raise RuntimeError(answer)
        if kind == "found":
            return answer
        silent = 0.0


def work(folder: Path, function: Callable[..., Any], arguments: Sequence[Any], options: dict[str, Any],
         pipe: Connection) -> bool:
    """Call the function in this process, and send what it finds; what is unpacked goes with the folder."""
    TEMPORARY.append(folder)
    tempfile.tempdir = str(folder)
    participant.SIGN_OF_LIFE[:] = [partial(pipe.send, ("alive", None))]
    try:
        pipe.send(("found", function(*arguments, **options)))
    except FAILURES as error:
        error.add_note(traceback.format_exc())
        pipe.send(("refused", error))
    except Exception:
        pipe.send(("bug", traceback.format_exc()))
    return False   # what was loaded stays in this process
