"""Finished parts of a study or a tuning, by one writer: each is whole and unchanged, or missing."""

import hashlib
import json
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from maglev.files.errors import ScenarioError, option
from maglev.files.one_writer import Busy, NoLock, only_writer
from maglev.files.regular_file import regular
from maglev.files.scratch import PREFIX, remove_leftovers
from maglev.files.whole_file import whole_file, write_whole

DIGITS = 32   # of a digest, in the name of a file


class Parts:
    """Folder with the finished parts, a file for each, such as "samples-0000003.parquet".

    The name of the file has a digest before its ending: SHA-256 of the key of the study, the name of the part and the
    content. A file with another digest is no part of this study, or was changed.
    """

    def __init__(self, folder: Path, key: str):
        self.folder = folder
        self.place = folder.absolute()     # threads that load FMUs change the working folder for a moment
        self.key = key
        self.mark = folder / "study.json"
        self.files: dict[str, Path] = {}   # by name of the part

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Keep others out of the folder for the block; ScenarioError if one is at work there."""
        path = self.folder.with_name(f".{self.folder.name}.lock")
        require_file(path)
        try:
            with only_writer(path):
                yield
        except Busy:
            raise ScenarioError(f"{self.folder}: another process is writing there: wait for it, or give another "
                                f"{option('out')}") from None
        except NoLock as error:
            raise ScenarioError(f"{self.folder}: cannot be locked ({error.strerror}), expected a file system with "
                                f"locks: give another {option('out')}") from None

    def find(self) -> int:
        """Find parts; return the number of other files. ScenarioError if the folder is of another study."""
        if not self.folder.exists():
            return 0
        if not self.folder.is_dir():
            raise ScenarioError(f"{self.folder}: is {kind_at(self.folder)}, expected a folder, or nothing there")
        remove_leftovers(self.folder)   # of a process that was ended as it wrote
        # A part with a dot was never finished.
        paths = sorted(path for path in self.folder.glob("[!.]*") if not path.name.startswith(PREFIX))
        for path in paths:
            require_file(path)
        try:
            key = json.loads(regular(self.mark).read_text(encoding="utf-8"))["key"]
        except (OSError, ValueError, KeyError, TypeError):
            key = None
        if key != self.key:
            raise ScenarioError(f"{self.folder}: has parts of another study, or of another version of this one: "
                                f"remove the folder, or give another {option('out')}")
        others = 0
        for path in paths:
            name = f"{path.stem.rpartition('.')[0]}{path.suffix}"
            if path == self.path(name, path.read_bytes()):
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
        require_file(self.place / path.name)
        with whole_file(self.place / path.name) as unfinished:
            unfinished.write_bytes(content)
        self.files[name] = path

    def read(self, name: str) -> bytes:
        """Content of a part that is there; ScenarioError if somebody else has changed it since."""
        path = self.files[name]
        require_file(path)
        content = path.read_bytes() if path.is_file() else b""
        if path != self.path(name, content):
            raise ScenarioError(f"{path}: was changed or removed during the study; {option('resume', True)} runs its "
                                "samples again")
        return content

    def remove(self) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)


KINDS = {"l": "a link", "d": "a folder", "-": "a file", "p": "a pipe", "s": "a socket"}   # as of `ls -l`


def kind_at(path: Path) -> str:
    """Return the kind of object at a path, such as "a pipe"; empty if nothing is there."""
    try:
        return KINDS.get(stat.filemode(path.lstat().st_mode)[0], "a device")
    except FileNotFoundError:
        return ""


def require_file(path: Path) -> None:
    """Refuse what is there and no file of its own: it may be somebody's, a pipe waits for ever, a link leads away."""
    if kind_at(path) not in ("", "a file"):
        raise ScenarioError(f"{path}: is {kind_at(path)}, expected a file that was written here, or nothing: remove it")
