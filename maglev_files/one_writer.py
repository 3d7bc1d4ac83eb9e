"""One writer at a time: a lock that the system holds, and that goes with the process, however that ends."""

import errno
import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO


class Busy(OSError):
    """Another process, or another block of this one, is writing."""


class NoLock(OSError):
    """A file system without locks, or something else in the lock's place."""


@contextmanager
def only_writer(path: Path, wait: bool = False) -> Iterator[None]:
    """Keep others out for the block, who ask by the same path: a file beside what is written, which goes at the end.

    Busy if another is at work, unless it is waited for; NoLock if nobody can be kept out; OSError if nothing can be
    written there.
    """
    while True:
        path.parent.mkdir(parents=True, exist_ok=True)
        if os.path.lexists(path) and not stat.S_ISREG(path.lstat().st_mode):   # a pipe would wait for ever
            raise NoLock(errno.EINVAL, "what lies there is no file", str(path))
        try:
            file = path.open("a")
        except OSError as error:   # what is to be written there cannot be either
            raise OSError(error.errno, error.strerror, str(path.parent)) from None
        with file:
            try:
                lock(file, wait)
            except OSError as error:
                kind = Busy if error.errno in (errno.EACCES, errno.EAGAIN, errno.EDEADLK) else NoLock
                raise kind(error.errno, error.strerror, str(path)) from None
            if not is_at(path, file):   # who had it has just removed it
                continue
            try:
                yield
            finally:
                with suppress(PermissionError):   # of Windows, where it stays: it is open
                    path.unlink(missing_ok=True)
            return


def lock(file: IO[str], wait: bool) -> None:
    """Lock an open file for as long as it is open, here and in every other process; OSError if it is locked."""
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(file.fileno(), msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


def is_at(path: Path, file: IO[str]) -> bool:
    try:
        return os.path.samestat(path.stat(), os.fstat(file.fileno()))
    except FileNotFoundError:
        return False
