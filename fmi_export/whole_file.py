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
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
    os.close(handle)
    unfinished = Path(name)
    try:
        yield unfinished
        unfinished.chmod(0o666 & ~current_umask())   # temporary files are for their owner alone
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)


def current_umask() -> int:
    """File mode bits that this process withholds."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def write_whole(path: Path, text: str) -> None:
    """Write a text in UTF-8, with line ends as they are."""
    with whole_file(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8", newline="\n")
