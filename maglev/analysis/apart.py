"""An analysis in a process of its own, where what runs in it is not of this project: it may crash, exit or hang."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from maglev.analysis.differences import participant
from maglev.cosim.other_process.helper import other_process
from maglev.cosim.other_process.run import TIMEOUT
from maglev.errors import ControllerError, FmuError
from maglev.experiment.preparation import runs_apart
from maglev.processes.beside import Gone, Send
from maglev.user_controllers.source import is_class

Found = TypeVar("Found")


def apart(function: Callable[..., Found], files: Sequence[Path], timeout: float, *arguments: Any,
          **options: Any) -> Found:
    """Call a function here, or where one of the files that it runs is not of this project, in another process.

    `timeout` is the longest time without a step, s, `TIMEOUT` at least. FmuError if the process dies, or a step takes
    too long; ControllerError if one of the files stands for a class, which only this process knows, and another has to
    run elsewhere.
    """
    foreign = [path for path in files if runs_apart(path)]
    if not foreign:
        return function(*arguments, **options)
    for path in files:
        if is_class(path):
            raise ControllerError(f"{path}: was given as a class, which runs in this process alone, but "
                                  f"{foreign[0].name} runs in another; expected the file of the class")
    with other_process() as (beside, _):
        beside.ask(partial(work, function, arguments, options))
        try:
            while not (said := beside.next(max(timeout, TIMEOUT))).last:
                pass
        except Gone as gone:
            raise FmuError(f"{' or '.join(path.name for path in foreign)} {gone}") from None
        answer: Found = said.what
        return answer


def work(function: Callable[..., Any], arguments: Sequence[Any], options: dict[str, Any], send: Send) -> Any:
    """Call the function in this process; each step of what it runs is a sign of life."""
    participant.SIGN_OF_LIFE[:] = [partial(send, "alive")]
    return function(*arguments, **options)
