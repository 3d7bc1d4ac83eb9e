"""Copies of files from when a run was prepared: the run uses these, which no later edit reaches."""

import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

from maglev.files.cache import digest_of_all
from maglev.files.regular_file import regular
from maglev.files.scratch import naming_full, remove_scratch, scratch_folder
from maglev.files.session import SESSION

ORIGIN = ".origin"        # file next to copies that names the folder that they are from


class Copies:
    """The folder of all copies of this process and of those that it starts; it goes with the first of them."""

    def __init__(self, folder: Path | None = None):
        self.folder = folder or scratch_folder()
        self.own = folder is None

    def close(self) -> None:
        if self.own:
            remove_scratch(self.folder)


def copied(files: Mapping[str, bytes], origin: Path) -> Path:
    """Folder with copies of files, by their paths in the folder that they are from; the same of the same content."""
    files = {**files, ORIGIN: os.fsencode(origin.absolute())}
    folder = SESSION.get(Copies).folder
    copy = folder / digest_of_all(files)[:32]
    if not copy.is_dir():
        unfinished = Path(tempfile.mkdtemp(dir=folder))
        with naming_full(folder):
            for name, data in files.items():
                path = unfinished / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(data)
        try:
            unfinished.rename(copy)
        except OSError:   # another process was faster
            shutil.rmtree(unfinished, ignore_errors=True)
    return copy


def original(path: Path) -> Path:
    """Return the file or folder that was copied to a path; the path itself if it is no copy."""
    beside = path if path.is_dir() else path.parent
    try:
        folder = Path(os.fsdecode(regular(beside / ORIGIN).read_bytes()))
    except OSError:
        return path
    return folder if path == beside else folder / path.name
