"""The cache of this user: results that take long to make, kept for the next time and known by their content.

A file in it is named after its own digest, in a folder that is named after the sources of the content. It is found for
as long as its content has that digest, and nobody else can write there.
"""

import errno
import hashlib
import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from maglev.files.regular_file import regular
from maglev.files.scratch import remove_scratch, scratch_folder
from maglev.files.session import SESSION
from maglev.files.whole_file import whole_file

PLACE = "MAGLEV_CACHE"   # environment variable with the folder, instead of the system's
FILES = "files"          # key of a record in JSON: digests, by file name, of files that belong together
FOLDERS = FMUS, STEP_LOOP, BLOCK_LOOPS = "fmus", "step_loop", "block_loops"   # in it


class Kept(NamedTuple):
    """A file, and the SHA-256 of its content."""

    path: Path
    sha256: str

    @property
    def intact(self) -> bool:
        return digest_at(self.path) == self.sha256


class KeptHere:
    """Files that only this process keeps, by key and name, because the cache cannot be written."""

    def __init__(self) -> None:
        self.files: dict[tuple[str, str], Kept] = {}

    def close(self) -> None:
        for entry in self.files.values():
            remove_scratch(entry.path.parent)


def cache_folder() -> Path:
    """Folder of the cache, which need not be there."""
    place = os.environ.get(PLACE)
    if place:
        return Path(place).absolute()
    from platformdirs import user_cache_path

    try:
        return user_cache_path("maglev-fmus", appauthor=False)
    except RuntimeError:
        return Path("~/.cache/maglev-fmus")   # there is no home folder, and nothing is kept


def key_of(folder: str, *made_of: object) -> str:
    """Return the key, in a folder of the cache, of a result made of these, whose texts tell it from all others."""
    return f"{folder}/{hashlib.sha256(repr(made_of).encode('utf-8')).hexdigest()[:32]}"


def kept(key: str, name: str) -> Kept | None:
    """Return the content under a key, a path in the cache, and a file name; None if it is missing or was changed."""
    if here := SESSION.get(KeptHere).files.get((key, name)):
        return here
    folder = cache_folder() / key
    if folder.is_absolute() and is_private(folder):
        for path in sorted(folder.glob(f"*-{name}")):
            entry = Kept(path, path.name.removesuffix(f"-{name}"))
            if is_private(path) and entry.intact:
                return entry
    return None


def keep(key: str, name: str, content: bytes) -> Kept:
    """Keep a content under a key and a file name, and replace the earlier one; OSError if it cannot be written."""
    folder = cache_folder() / key
    if not folder.is_absolute():   # where this user has no home folder
        raise OSError(errno.ENOENT, "there is no home folder", str(folder))
    folder.mkdir(parents=True, exist_ok=True)
    folder.chmod(0o700)
    digest = hashlib.sha256(content).hexdigest()
    path = folder / f"{digest}-{name}"
    if not path.is_file():   # a pipe would be written into
        path.unlink(missing_ok=True)
    with whole_file(path) as unfinished:
        unfinished.write_bytes(content)
        unfinished.chmod(0o700)
    for other in folder.glob(f"*-{name}"):
        if other != path:
            other.unlink(missing_ok=True)
    return Kept(path, digest)


def keep_here(key: str, name: str, content: bytes) -> Kept:
    """The same; where it cannot be written, in a temporary folder for as long as this process lives."""
    try:
        return keep(key, name, content)
    except OSError:
        entry = Kept(scratch_folder() / name, hashlib.sha256(content).hexdigest())
        SESSION.get(KeptHere).files[key, name] = entry
        entry.path.write_bytes(content)
        entry.path.chmod(0o700)
        return entry


def sizes() -> list[int]:
    """Return the size of every file in the cache, in bytes."""
    return [path.stat().st_size for part in FOLDERS for path in (cache_folder() / part).rglob("*-*")
            if path.is_file()]


def clear() -> None:
    """Remove all that is kept, and nothing else that lies there; OSError if it cannot be removed."""
    for part in FOLDERS:
        if (cache_folder() / part).exists():
            shutil.rmtree(cache_folder() / part)


def digest_at(path: Path) -> str:
    """SHA-256 of a file, by which a changed file is noticed; empty text if it cannot be read, or is no file.

    Size and time do not tell: an edit in place can leave both.
    """
    try:
        if not path.is_file():   # a pipe would wait for ever
            return ""
        with regular(path).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


def digest_of_all(files: Mapping[str, bytes]) -> str:
    """SHA-256 of files, of their names and contents."""
    hashed = hashlib.sha256()
    for name, content in sorted(files.items()):
        hashed.update(f"{name}\0{len(content)}\0".encode("utf-8", "surrogateescape"))
        hashed.update(content)
    return hashed.hexdigest()


def record_conflict(path: Path) -> str:
    """Return why a file does not belong to the JSON next to it, as the end of a sentence.

    Empty if the file belongs to it, or if no JSON next to it has a digest.
    """
    record = path.with_suffix(".json")
    try:
        expected = json.loads(regular(record).read_text(encoding="utf-8"))[FILES][path.name]
    except (OSError, ValueError, KeyError, TypeError):
        return ""
    return "" if digest_at(path) == expected else (
        f"does not belong to {record.name} next to it: one of the two was edited, or comes from another run. Keep both "
        "files of one run, or this file alone")


def is_private(path: Path) -> bool:
    """Return True if only this user, or the system's, can change a file or folder; True where owners are unknown."""
    try:
        status = path.stat()
    except OSError:
        return False
    return not hasattr(os, "geteuid") or (status.st_uid in (0, os.geteuid()) and not status.st_mode & 0o022)
