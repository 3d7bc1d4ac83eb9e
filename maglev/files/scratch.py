"""Temporary folders that are removed after use, or by the next process after one that was killed."""

import errno
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from importlib.util import find_spec
from pathlib import Path

from maglev.files.session import SESSION

PREFIX = "maglev_scratch_"
MADE = re.compile(f"{PREFIX}[a-z0-9_]{{8}}")   # as `mkdtemp` makes them, for this user alone

if find_spec("fcntl") is not None:   # not on Windows
    import fcntl


class ScratchFolders:
    """The temporary folders of this process."""

    def __init__(self) -> None:
        self.locks: dict[Path, int] = {}        # by folder: file descriptors that hold its lock
        self.looked_through: set[str] = set()   # folders in which those that were left have been removed


def scratch_folder(place: str | None = None) -> Path:
    """Make a temporary folder, inside a folder if one is given; `remove_scratch` removes it.

    It is locked for as long as this process lives, whatever ends it: an unlocked folder may be removed.
    """
    inside, folders = place or tempfile.gettempdir(), SESSION.get(ScratchFolders)
    if inside not in folders.looked_through:
        folders.looked_through.add(inside)
        remove_leftovers(Path(inside))
    while True:
        folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=inside))
        lock = locked(folder)
        if lock is not None:
            folders.locks[folder] = lock
        if folder.exists():   # between its making and its lock another process may have taken it for one that was left
            return folder
        remove_scratch(folder)


def remove_scratch(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    lock = SESSION.get(ScratchFolders).locks.pop(folder, None)
    if lock is not None:
        os.close(lock)


@contextmanager
def scratch(place: str | None = None) -> Iterator[Path]:
    folder = scratch_folder(place)
    try:
        with nullcontext() if place else naming_full(folder):
            yield folder
    finally:
        remove_scratch(folder)


@contextmanager
def naming_full(folder: Path) -> Iterator[None]:
    """Name the folder of temporary files in the error of a full disk, which names no file, while a block writes."""
    try:
        yield
    except OSError as error:
        if error.filename is not None or error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        raise OSError(error.errno, f"{error.strerror} for temporary files; TMPDIR sets another folder",
                      str(folder.parent)) from error


def remove_leftovers(place: Path) -> None:
    """Remove the temporary folders in a folder that no process has locked; folders with a person's names stay."""
    for folder in place.glob(f"{PREFIX}*"):
        if not (MADE.fullmatch(folder.name) and is_of_this_user(folder)):
            continue
        lock = locked(folder, wait=False)
        if lock is not None:
            shutil.rmtree(folder, ignore_errors=True)
            os.close(lock)


def is_of_this_user(folder: Path) -> bool:
    """Return True if nobody else may look into a folder, as into one from `mkdtemp`."""
    try:
        return not folder.lstat().st_mode & 0o077
    except OSError:
        return False   # it is gone


def locked(folder: Path, wait: bool = True) -> int | None:
    """Lock a folder; None if another process has done so, or it cannot be locked."""
    if find_spec("fcntl") is None:
        return None
    try:
        lock = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    except OSError:
        return None   # another user's, or gone
    try:
        fcntl.flock(lock, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(lock)
        return None
    return lock
