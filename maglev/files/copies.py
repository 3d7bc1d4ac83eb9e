"""Copies of files from when a run was prepared: the run uses these, which no later edit reaches."""

import os
import shutil
import tempfile
from collections.abc import Mapping
from functools import cache
from multiprocessing import parent_process, util
from pathlib import Path

from maglev.files.cache import digest_of_all
from maglev.files.regular_file import regular
from maglev.files.scratch import naming_full, remove_scratch, scratch_folder
from maglev.files.worker_process import SERVING

PLACE = "MAGLEV_COPIES"   # environment variable with the folder of the copies, for the processes that this one starts
ORIGIN = ".origin"        # file next to copies that names the folder that they are from


@cache
def folder_of_copies() -> Path:
    """Folder of all copies of this process and of those that it starts; it goes with the first of them."""
    if (SERVING or parent_process() is not None) and PLACE in os.environ:
        return Path(os.environ[PLACE])
    folder = scratch_folder()
    util.Finalize(None, remove_scratch, (folder,), exitpriority=0)
    os.environ[PLACE] = str(folder)
    return folder


def copied(files: Mapping[str, bytes], origin: Path) -> Path:
    """Folder with copies of files, by their paths in the folder that they are from; the same of the same content."""
    files = {**files, ORIGIN: os.fsencode(origin.absolute())}
    copy = folder_of_copies() / digest_of_all(files)[:32]
    if not copy.is_dir():
        unfinished = Path(tempfile.mkdtemp(dir=folder_of_copies()))
        with naming_full(folder_of_copies()):
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
