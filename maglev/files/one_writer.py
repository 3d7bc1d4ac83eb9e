"""One writer at a time: a lock that the system holds, and releases when the process ends, however it ends.

The package filelock leaves its files where it has locked, which here are folders with a user's results.
"""

import errno
import os
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

BUSY = (errno.EACCES, errno.EAGAIN, errno.EDEADLK)
POLL = 0.05   # s, between two attempts


class Busy(OSError):
    """Another process, or another block of this one, is writing."""


class NoLock(OSError):
    """A file system without locks, or something else in the lock's place."""


@contextmanager
def only_writer(path: Path, wait: float = 0.0) -> Iterator[None]:
    """Lock a path for the block against others who lock the same path.

    The lock is a file next to it, which is removed at the end.

    Busy if another is at work, and still is after a wait (s); NoLock if nobody can be kept out; OSError if nothing can
    be written there.
    """
    until = time.monotonic() + wait
    while True:
        path.parent.mkdir(parents=True, exist_ok=True)
        if os.path.lexists(path) and not stat.S_ISREG(path.lstat().st_mode):   # a pipe would wait for ever
            raise NoLock(errno.EINVAL, "it is not a file", str(path))
        try:
            file = path.open("a")
        except OSError as error:   # neither could the file itself be written
            raise OSError(error.errno, error.strerror, str(path.parent)) from None
        with file:
            try:
                lock(file)
            except OSError as error:
                if error.errno not in BUSY:
                    raise NoLock(error.errno, error.strerror, str(path)) from None
                if time.monotonic() >= until:
                    raise Busy(error.errno, f"another process {f'still writes after {wait:g} s' if wait else 'writes'}",
                               str(path)) from None
                time.sleep(POLL)
                continue
            if not is_at(path, file):   # its last owner has just removed it
                continue
            try:
                yield
            finally:
                with suppress(PermissionError):   # of Windows, where it stays: it is open
                    path.unlink(missing_ok=True)
            return


def lock(file: IO[str]) -> None:
    """Lock an open file for as long as it is open, here and in every other process; OSError if it is locked."""
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def is_at(path: Path, file: IO[str]) -> bool:
    try:
        return os.path.samestat(path.stat(), os.fstat(file.fileno()))
    except FileNotFoundError:
        return False
