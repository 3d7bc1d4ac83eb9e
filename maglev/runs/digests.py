"""Digests of whole runs, a line for each in the file of a folder of baselines.

They are of runs that have the same bits on every machine.
"""

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from maglev.files.errors import BaselineError, shortened
from maglev.files.regular_file import regular
from maglev.files.whole_file import write_whole

FILE = "digests.txt"
LINE = re.compile(r"([0-9a-f]{64})  (\S+): (\d+) signals at (\d+) samples")


class Digest(NamedTuple):
    """SHA-256 of a recording, its signals, and its samples."""

    sha256: str
    signals: int
    samples: int

    @property
    def extent(self) -> str:
        return f"{self.signals} signals at {self.samples} samples"


def digest_of(time: npt.NDArray[np.float64], columns: Mapping[str, npt.NDArray[Any]]) -> Digest:
    """Return the digest of columns of numbers and Booleans, shape (n,), by name, and of their times (s)."""
    hashed = hashlib.sha256()
    for name, values in [("time", time), *((name, columns[name]) for name in sorted(columns))]:
        hashed.update(name.encode("utf-8") + b"\0")
        numbers = np.array(values, dtype="<f8")
        numbers[np.isnan(numbers)] = np.nan   # whose sign depends on the processor
        hashed.update(numbers.data)
    return Digest(hashed.hexdigest(), len(columns), len(time))


def read_digests(folder: Path) -> dict[str, Digest]:
    """Return the digests of a folder by run; BaselineError names a line that is no digest, or the second of a run."""
    path = folder / FILE
    if not path.exists():
        return {}
    digests: dict[str, Digest] = {}
    lines = regular(path).read_text(encoding="utf-8-sig", errors="replace").splitlines()
    for number, line in enumerate(lines, 1):
        match = LINE.fullmatch(line)
        repeated = match is not None and match[2] in digests
        if match is None or repeated:
            raise BaselineError(f"{path}, line {number}: {shortened(line)}: expected SHA-256, name, signals and "
                                "samples of a run, each run once")
        digests[match[2]] = Digest(match[1], int(match[3]), int(match[4]))
    return digests


def write_digests(folder: Path, changed: Mapping[str, Digest | None]) -> None:
    """Add or replace the digests of runs in a folder; None removes one. Errors as of `read_digests`."""
    digests = read_digests(folder)
    new = {name: digest for name, digest in (digests | dict(changed)).items() if digest is not None}
    if new != digests:
        write_whole(folder / FILE, "".join(f"{new[name].sha256}  {name}: {new[name].extent}\n" for name in sorted(new)))
