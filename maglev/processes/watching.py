"""How whoever calls a function is told what goes on: in sentences, and of progress."""

import warnings
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext

from maglev.processes.side_by_side import Watcher

Say = Callable[[str], None]
Watch = Callable[[Sequence[str]], AbstractContextManager[Watcher]]   # from the names of tasks to what is told of them


def warn(sentence: str) -> None:
    """Say a sentence as Python does."""
    warnings.warn(sentence, stacklevel=6)


def unwatched(_names: Sequence[str]) -> AbstractContextManager[Watcher]:
    """Nobody looks on."""
    return nullcontext(lambda _name, _done, _steps: None)
