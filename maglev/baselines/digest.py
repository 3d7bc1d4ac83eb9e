"""Digest of a run: every signal at every sample, which has the same bits on every machine, in NAME_ref.sha256."""

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from maglev.errors import BaselineError
from maglev_files.whole_file import whole_file

FORM = re.compile(r"([0-9a-f]{64})  (\d+) signals at (\d+) samples\n")


class Digest(NamedTuple):
    """SHA-256 of a recording, its signals, and its samples."""

    sha256: str
    signals: int
    samples: int


def digest_of(time: npt.NDArray[np.float64], columns: Mapping[str, npt.NDArray[Any]]) -> Digest:
    """Digest of columns of numbers and Booleans, shape (n,), by name, and of their times (s)."""
    hashed = hashlib.sha256()
    for name, values in [("time", time), *((name, columns[name]) for name in sorted(columns))]:
        hashed.update(name.encode("utf-8") + b"\0")
        numbers = np.array(values, dtype="<f8")
        numbers[np.isnan(numbers)] = np.nan   # of which processors choose the sign
        hashed.update(numbers.data)
    return Digest(hashed.hexdigest(), len(columns), len(time))


def digest_file(folder: Path, name: str) -> Path:
    return folder / f"{name}_ref.sha256"


def write_digest(folder: Path, name: str, digest: Digest | None) -> None:
    """Write the digest of a run; None takes away what is there."""
    path = digest_file(folder, name)
    if digest is None:
        path.unlink(missing_ok=True)
        return
    with whole_file(path) as unfinished:
        unfinished.write_text(f"{digest.sha256}  {digest.signals} signals at {digest.samples} samples\n",
                              encoding="ascii", newline="\n")


def read_digest(folder: Path, name: str) -> Digest | None:
    """Digest of a run; None if there is none, BaselineError if the file is not one."""
    path = digest_file(folder, name)
    if not path.is_file():
        return None
    match = FORM.fullmatch(path.read_text(encoding="ascii", errors="replace"))
    if match is None:
        raise BaselineError(f"{path}: not a digest, expected a line with SHA-256, signals and samples; "
                            "`maglev check --update` writes it")
    return Digest(match[1], int(match[2]), int(match[3]))
