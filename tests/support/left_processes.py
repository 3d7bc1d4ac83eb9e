"""Processes that a command leaves behind: known by a folder for temporary files that it alone was given."""

import os
import signal
import subprocess
import time
from pathlib import Path

AT_ONCE = 10.0   # s, in which a command ends after a signal: it takes 0.2 to 1.5 s, 16 s if it waits for a compiler


def ended(process: subprocess.Popen[str], begun: float) -> str:
    """What a command, which began then and has got its signal, still says on standard error; kill it if it continues.

    Where the machine is so busy that it took longer than `AT_ONCE` to come to the signal, it may take as long to end.
    """
    try:
        return process.communicate(timeout=max(AT_ONCE, time.monotonic() - begun))[1]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        raise


def require_none(folder: Path, within: float = 60.0) -> None:
    """Fail if there still is, after a while (s), a process with the folder in its environment."""
    end = time.monotonic() + within
    while left := processes_with(folder):
        assert time.monotonic() < end, left
        time.sleep(0.05)


def processes_with(folder: Path) -> list[str]:
    """Command lines of the processes that have a folder in their environment."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if str(folder).encode() in (process / "environ").read_bytes():
                found.append((process / "cmdline").read_bytes().decode())
        except OSError:   # of another user, or gone
            continue
    return found
