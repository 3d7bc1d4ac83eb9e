"""Files that appear under their names when they are complete."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a file beside `path` to write to, which takes its place at the end of the block.

    What stood there before is intact until then, and stays if the block fails. The name of the unfinished file is
    unique: two processes that write the same file both write a whole one, and the last one stays. The folder is made if
    it is not there.

    Raises
    ------
    OSError
        If it cannot be written; with the name of the file that was to be.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_name(f".{path.name}.{os.urandom(8).hex()}.part")
        try:
            yield unfinished
            unfinished.replace(path)
        finally:
            unfinished.unlink(missing_ok=True)
    except OSError as error:
        # A disk that is full names no file, and the unfinished one says nothing to a person.
        if error.filename is None or str(error.filename).endswith(".part"):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise


@contextmanager
def whole_files(folder: Path) -> Iterator[Path]:
    """Give a folder inside `folder` to write files to, which take their places in it at the end of the block.

    If the block fails, everything in `folder` is as it was; an OSError names the file in it that was to be.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".unfinished.", dir=folder) as name:
        try:
            yield Path(name)
        except OSError as error:
            if error.filename is not None and Path(error.filename).parent == Path(name):
                raise OSError(error.errno, error.strerror, str(folder / Path(error.filename).name)) from error
            raise
        for file in sorted(Path(name).iterdir()):
            file.replace(folder / file.name)


def write_whole(path: Path, text: str) -> None:
    """Write a text in UTF-8, with line ends as they are."""
    with whole_file(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8", newline="\n")
