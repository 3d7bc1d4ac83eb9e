"""Programs that end with all that they have started: each has a session of its own, and is its leader."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event

RUNNING: set["subprocess.Popen[str]"] = set()   # of `output_of`
ENDING = Event()                                # what `output_of` starts ends at once


def end_with_children(process: "subprocess.Popen[bytes] | subprocess.Popen[str]") -> bool:
    """End a process that leads a session, whatever it does, with all in its group, and wait for that.

    Returns whether one was left in its group that had ended itself. A process that has made a session of its own is not
    found; Windows has no groups.
    """
    ended = process.poll() is not None
    left = False
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
            left = ended
    process.kill()
    process.wait()
    return left


def python_environment() -> dict[str, str]:
    """Environment in which another Python imports what this one does: packages may be in `sys.path` alone."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(place for place in sys.path if Path(place).is_absolute())}


def output_of(arguments: Sequence[str | Path], folder: Path, environment: Mapping[str, str]) -> tuple[int, str]:
    """Exit code of a program in a folder, and what it printed; it ends with its children where this is interrupted."""
    process = subprocess.Popen(arguments, cwd=folder, env=environment, text=True, stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
    RUNNING.add(process)
    try:
        if ENDING.is_set():
            end_with_children(process)
        printed, _ = process.communicate()
    except BaseException:
        end_with_children(process)
        raise
    finally:
        RUNNING.discard(process)
    return process.returncode, printed


@contextmanager
def programs_side_by_side(number: int) -> Iterator[ThreadPoolExecutor]:
    """Threads, of which so many run programs at a time; where the block fails, these end and no others start."""
    pool = ThreadPoolExecutor(number)
    try:
        yield pool
    except BaseException:
        ENDING.set()
        pool.shutdown(wait=False, cancel_futures=True)
        for process in list(RUNNING):
            end_with_children(process)
        raise
    finally:
        pool.shutdown()
        ENDING.clear()
