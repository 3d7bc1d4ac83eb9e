"""A user's controller for the workers of a study: they have no Python file of his, but take any FMU."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from maglev.catalogue import build_written
from maglev.errors import BuildError, ControllerError
from maglev.user_controllers.source import is_written
from maglev_files.scratch import scratch


@contextmanager
def controller_built(given: str | Path | type | None, native: bool, everywhere: bool,
                     say: Callable[[str], None]) -> Iterator[str | Path | None]:
    """An FMU in place of a controller's Python file, for as long as the block lasts; any other controller as it is.

    Parameters
    ----------
    given : path or None
    native : bool
        Whether its FMU is native, too, if it can be; `say` is told why if it cannot.
    everywhere : bool
        Whether a native one has binaries for all platforms, not only for this machine.
    say : callable

    Raises
    ------
    ControllerError, BuildError
        If there is no such controller, or no FMU of it.
    """
    if isinstance(given, type):
        raise ControllerError(f"class {given.__name__}: was given as a class, which only the process that defines it "
                              "can fly, and a study takes others; expected its file, such as 'lqi.py'")
    if given is None or not is_written(Path(given)):
        yield given
        return
    with scratch() as folder:
        path = None
        if native:
            try:
                path = build_written(Path(given), folder, native=True, host_only=not everywhere)
            except BuildError as error:
                say(f"{given} runs in Python, which takes its time, for it cannot be native: {error}")
        yield path or build_written(Path(given), folder)
