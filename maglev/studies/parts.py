"""What is done of a study or a tuning: parts of one writer, whole and as they were written, or none."""

import errno
import hashlib
import json
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from maglev.errors import ScenarioError
from maglev_files.whole_file import whole_file, write_whole

DIGITS = 32   # of a digest, in the name of a file


class Parts:
    """Folder with what is done, a file for each part, such as "samples-0000003.parquet".

    The name of the file has a digest before its ending, SHA-256 of the key of the study, the name of the part and the
    content: a file that has another is no part of this study, or not as it was written.
    """

    def __init__(self, folder: Path, key: str):
        self.folder = folder
        self.key = key
        self.mark = folder / "study.json"
        self.files: dict[str, Path] = {}   # by name of the part

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Keep others out of the folder for the block; ScenarioError if one is at work there.

        The system holds the lock, which goes with the process, however that ends.
        """
        path = self.folder.with_name(f".{self.folder.name}.lock")
        path.parent.mkdir(parents=True, exist_ok=True)
        while True:
            with path.open("a") as file:
                try:
                    lock(file)
                except OSError as error:
                    busy = error.errno in (errno.EACCES, errno.EAGAIN, errno.EDEADLK)
                    raise ScenarioError(f"{self.folder}: " + (
                        "another process is writing there, expected one at a time: wait for it, or give another --out"
                        if busy else f"cannot be locked ({error.strerror}), expected a file system with locks: give "
                                     "another --out")) from None
                if not is_at(path, file):   # who had it has just removed it
                    continue
                try:
                    yield
                finally:
                    with suppress(PermissionError):   # of Windows, where it stays: it is open
                        path.unlink(missing_ok=True)
                return

    def find(self) -> int:
        """Find the parts that are there; returns how many other files are.

        ScenarioError if the folder is of another study.
        """
        if not self.folder.exists():
            return 0
        try:
            key = json.loads(self.mark.read_text(encoding="utf-8"))["key"]
        except (OSError, ValueError, KeyError, TypeError):
            key = None
        if key != self.key:
            raise ScenarioError(f"{self.folder}: has parts of another study, or of this one with other files or "
                                "another version, expected none: remove the folder, or give another --out")
        others = 0
        for path in sorted(self.folder.glob("[!.]*")):   # one with a dot is a part that was never finished
            name = f"{path.stem.rpartition('.')[0]}{path.suffix}"
            if path.is_file() and path == self.path(name, path.read_bytes()):
                self.files[name] = path
            elif path != self.mark:
                others += 1
        return others

    def begin(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        write_whole(self.mark, json.dumps({"key": self.key}) + "\n")

    def path(self, name: str, content: bytes) -> Path:
        digest = hashlib.sha256(f"{self.key}\0{name}\0".encode())
        digest.update(content)
        part = Path(name)
        return self.folder / f"{part.stem}.{digest.hexdigest()[:DIGITS]}{part.suffix}"

    def write(self, name: str, content: bytes) -> None:
        path = self.path(name, content)
        with whole_file(path) as unfinished:
            unfinished.write_bytes(content)
        self.files[name] = path

    def read(self, name: str) -> bytes:
        """Content of a part that is there; ScenarioError if somebody else has changed it since."""
        path = self.files[name]
        content = path.read_bytes() if path.is_file() else b""
        if path != self.path(name, content):
            raise ScenarioError(f"{path}: was changed or removed meanwhile, expected nobody else to write there; "
                                "--resume flies its samples again")
        return content

    def remove(self) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)


def lock(file: IO[str]) -> None:
    """Lock an open file for as long as it is open, here and in every other process; OSError if it is locked."""
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def is_at(path: Path, file: IO[str]) -> bool:
    """Whether an open file is the one at a path."""
    try:
        return os.path.samestat(path.stat(), os.fstat(file.fileno()))
    except FileNotFoundError:
        return False
