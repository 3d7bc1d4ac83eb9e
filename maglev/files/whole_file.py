"""Files that appear under their names when they are complete."""

import errno
import os
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from maglev.files.scratch import PREFIX, scratch

PATIENCE = 10.0   # s, until a written named pipe has a reader
POLL = 0.05       # s, between two looks for it


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a file in a folder next to `path` to write to, which takes its place at the end of the block.

    The file that stood there before is intact until then, and stays if the block fails. Two processes that write the
    same file both write a whole one, and the last one stays. The folder is made if it is not there. Behind a link, the
    target of the link is written; a device or a pipe is written into. The next process that writes into the folder
    removes the files of a process that was killed. OSError, with the name of the file to be written, if that fails.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        place = None if takes_text(path) else Path(os.path.realpath(path))
        with scratch(None if place is None else str(place.parent)) as folder:
            unfinished = folder / path.name
            yield unfinished
            if place is None:
                with os.fdopen(opened(path), "ab") as device:
                    device.write(unfinished.read_bytes())
            else:
                unfinished.replace(place)
    except OSError as error:
        # A disk that is full names no file, and the unfinished one says nothing to a person.
        if error.filename is None or PREFIX in str(error.filename):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise


def opened(path: Path) -> int:
    """Open a file to write into, never to replace it; OSError if it is a pipe that nobody reads within `PATIENCE`."""
    until = time.monotonic() + PATIENCE
    while True:
        try:
            file = os.open(path, os.O_WRONLY | os.O_APPEND | getattr(os, "O_NONBLOCK", 0))
        except OSError as error:
            if error.errno != errno.ENXIO:
                raise
            if time.monotonic() >= until:
                raise OSError(errno.ENXIO, "is a named pipe that nobody reads", str(path)) from None
            time.sleep(POLL)
        else:
            if hasattr(os, "set_blocking"):
                os.set_blocking(file, True)
            return file


def takes_text(path: Path) -> bool:
    """Return True if the file there is written into, never replaced: a device, a pipe, or a file opened by a shell."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return False
    folder = path.absolute().parent.parts[1:]
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)) or folder in (("dev",), ("dev", "fd")) or (
        folder[:1] == ("proc",))


@contextmanager
def whole_files(folder: Path) -> Iterator[Path]:
    """Give a folder inside `folder` to write files to, which take their places in it at the end of the block.

    If the block fails, everything in `folder` is as it was; an OSError names the file in it that was to be.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with scratch(str(folder)) as unfinished:
        try:
            yield unfinished
        except OSError as error:
            if error.filename is not None and Path(error.filename).parent == unfinished:
                raise OSError(error.errno, error.strerror, str(folder / Path(error.filename).name)) from error
            raise
        for file in sorted(unfinished.iterdir()):
            file.replace(folder / file.name)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write bytes, or a text in UTF-8, with line ends as they are."""
    with whole_file(path) as unfinished:
        unfinished.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)
