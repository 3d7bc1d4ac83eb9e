"""Processes that a command leaves behind: known by a folder for temporary files that it alone was given."""

import time
from pathlib import Path


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
