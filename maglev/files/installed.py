"""The code of this installation, known by its content."""

import base64
import hashlib
from collections.abc import Iterable
from functools import cache
from importlib.metadata import distribution
from pathlib import Path

from maglev.files.cache import digest_of_all
from maglev.files.packages import HERE, PACKAGES

COMPARED = (".py", ".c", ".h", ".toml", ".j2")   # endings of files that execute, or select the code to run


@cache
def code() -> str:
    """SHA-256 of all Python modules of this project that are installed."""
    return files_digest(HERE, (path for package in PACKAGES for path in (HERE / package).rglob("*.py")))


def files_digest(root: Path, files: Iterable[Path]) -> str:
    """SHA-256 of files below a folder, of their paths in it and their contents; without Python's compiled files."""
    return digest_of_all({path.relative_to(root).as_posix(): path.read_bytes() for path in files
                          if path.suffix != ".pyc"})


@cache
def edited() -> tuple[str, ...]:
    """Return the files of the installed package that have changed since; nothing for a checkout.

    Nor are files that were added: nothing imports them.
    """
    files = []
    for path in distribution("maglev-fmus").files or []:
        if path.hash is None or path.suffix not in COMPARED:
            continue
        try:
            content = Path(str(path.locate())).read_bytes()
        except OSError:
            content = b""
        digest = base64.urlsafe_b64encode(hashlib.new(path.hash.mode, content).digest()).rstrip(b"=").decode("ascii")
        if digest != path.hash.value:
            files.append(path.as_posix())
    return tuple(files)
