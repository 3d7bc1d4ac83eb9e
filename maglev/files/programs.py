"""Programs that end with all that they have started: each has a session of its own, and is its leader.

They also end, with all that they have started, when this process does, however it ends: a keeper next to each reads
from a pipe whose other end only this process has.
"""

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event

from maglev.files.session import SESSION

LONGEST = 1800.0   # s, in which a program has to end: a compiler takes seconds
PATIENCE = 10.0    # s, for the system to end killed processes

# Runs the program that its arguments name; when the pipe on its standard input ends, it ends with all in its group.
KEEPER = """
import os, signal, subprocess, sys, threading

def keep():
    sys.stdin.buffer.read()
    if hasattr(os, "killpg"):
        os.killpg(0, signal.SIGKILL)
    program.kill()
    os._exit(1)

program = subprocess.Popen(sys.argv[1:], stdin=subprocess.DEVNULL)
threading.Thread(target=keep, daemon=True).start()
code = program.wait()
os._exit(code) if code >= 0 else os.kill(os.getpid(), -code)
"""


class Programs:
    """The programs that `output_of` runs, and whether they are to end at once."""

    def __init__(self) -> None:
        self.running: set[subprocess.Popen[str]] = set()
        self.ending = Event()


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
    with suppress(subprocess.TimeoutExpired):   # where the system itself does not come back
        process.wait(PATIENCE)
    return left


def python_environment() -> dict[str, str]:
    """Environment in which another Python imports the same packages: they may be in `sys.path` alone."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(place for place in sys.path if Path(place).is_absolute())}


def output_of(arguments: Sequence[str | Path], folder: Path, environment: Mapping[str, str],
              limit: float = LONGEST) -> tuple[int, str]:
    """Return the exit code and the output of a program run in a folder; an interrupt here ends it with its children.

    TimeoutError, which names the program, if it takes longer than `limit` (s).
    """
    programs = SESSION.get(Programs)
    kept, end = os.pipe()   # this process alone has the end
    try:
        process = subprocess.Popen([sys.executable, "-I", "-S", "-c", KEEPER, *arguments], cwd=folder, env=environment,
                                   text=True, stdin=kept, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   start_new_session=True)
        programs.running.add(process)
        try:
            if programs.ending.is_set():
                end_with_children(process)
            printed, _ = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            end_with_children(process)
            raise TimeoutError(errno.ETIMEDOUT, f"has not ended within {limit:g} s", str(arguments[0])) from None
        except BaseException:
            end_with_children(process)
            raise
        finally:
            programs.running.discard(process)
    finally:
        os.close(kept)
        os.close(end)
    return process.returncode, printed


@contextmanager
def programs_side_by_side(number: int) -> Iterator[ThreadPoolExecutor]:
    """Run programs in a limited number of threads; if the block fails, these end and no others start."""
    pool, programs = ThreadPoolExecutor(number), SESSION.get(Programs)
    try:
        yield pool
    except BaseException:
        programs.ending.set()
        pool.shutdown(wait=False, cancel_futures=True)
        for process in list(programs.running):
            end_with_children(process)
        raise
    finally:
        pool.shutdown()
        programs.ending.clear()
