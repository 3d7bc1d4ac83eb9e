"""Native FMUs for the tests: built once, however many processes the tests run in, and their C sources."""

import hashlib
import os
import shutil
import subprocess
import zipfile
from collections.abc import Callable, Mapping
from importlib.metadata import version
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest

from maglev.files.whole_file import whole_file
from maglev.fmi.compiler import FLAGS, Libraries, Platform

HERE = Path(__file__).parents[1] / "maglev" / "fmi" / "c"   # C sources of the tests

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror")
FMI_HEADERS = ("-I", str(files("fmpy").joinpath("c-code")))   # an FMU leaves them to its importer

# The header of the standard prepends the prefix; that of fmpy, which makes shared libraries alone, does not.
WITHOUT_PREFIX = "#define fmi2FullName(name) name\n"
WITH_PREFIX = """\
#define PASTED(a, b) a ## b
#define PASTED_VALUES(a, b) PASTED(a, b)
#define fmi2FullName(name) PASTED_VALUES(FMI2_FUNCTION_PREFIX, name)
"""


def prefixing_headers(folder: Path) -> Path:
    """Write FMI headers that heed FMI2_FUNCTION_PREFIX into a folder; returns it."""
    for header in files("fmpy").joinpath("c-code").iterdir():
        if header.name.startswith("fmi2") and header.name.endswith(".h"):
            (folder / header.name).write_text(header.read_text().replace(WITHOUT_PREFIX, WITH_PREFIX))
    assert "PASTED" in (folder / "fmi2Functions.h").read_text()
    return folder


def missing_native_tools() -> list[str]:
    """Packages of the extra `native` that are not installed."""
    return [name for name in ("ziglang",) if find_spec(name) is None]


def require_native_tools() -> None:
    """Skip where the extra `native` is not installed."""
    for name in missing_native_tools():
        pytest.skip(f"{name} is not installed (extra `native`)")


def require_command(name: str) -> str:
    """Path of a command; skip where there is none."""
    path = shutil.which(name)
    if path is None:
        pytest.skip(f"{name} is not installed")
    return path


def built_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], Any],
               asked: Path | None = None) -> Path:
    """Folder that `make` fills, by the first of the parallel test processes to ask for it; the others wait.

    A temporary one of that name, or the one that is asked for.
    """
    parallel = "PYTEST_XDIST_WORKER" in os.environ
    place = factory.getbasetemp().parent if parallel else factory.getbasetemp()
    folder, complete = place / name if asked is None else asked.absolute(), place / f"{name}.complete"
    with (place / f"{name}.lock").open("w") as lock:
        if os.name == "posix":
            import fcntl
            fcntl.flock(lock, fcntl.LOCK_EX)
        elif parallel:
            folder, complete = factory.mktemp(name), factory.mktemp(name) / "complete"
        if not complete.exists():
            if asked is None:
                shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True, exist_ok=True)
            make(folder)
            complete.touch()
    return folder


class KeptLibraries(Libraries):
    """Libraries that are kept in a folder: the same sources are compiled once."""

    def __init__(self, folder: Path):
        self.folder = folder

    def made(self, sources: Mapping[str, str], name: str, platform: Platform) -> bytes:
        what = version("ziglang"), FLAGS, sorted(sources.items()), name, platform
        kept = self.folder / hashlib.sha256(repr(what).encode()).hexdigest()
        if not kept.exists():
            with whole_file(kept) as unfinished:
                unfinished.write_bytes(super().made(sources, name, platform))
        return kept.read_bytes()


def unpacked_sources(fmu: Path, folder: Path) -> Path:
    """Folder `sources` of an FMU, unpacked, with nothing next to it."""
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(folder, [name for name in archive.namelist() if name.startswith("sources/")])
    return folder / "sources"


def compiled(sources: Path, output: Path, *flags: str | Path, extra: tuple[Path, ...] = ()) -> Path:
    """What gcc makes of an FMU's sources, and of `extra` C files, with flags; it must have nothing to say."""
    units = [*sorted(sources.glob("*.c")), *extra]
    done = subprocess.run([require_command("gcc"), *STRICT, *FMI_HEADERS, *flags, "-I", sources,
                           *units, "-o", output, "-lm"], capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr[-3000:]
    return output


def two_fmus_simulated(program: Path, fmus: Path, measured: list[tuple[str, str]], step: float,
                       steps: int) -> np.ndarray:
    """What the program made of `two_fmus.c` measures at every step, shape (steps, measurements).

    `fmus` has the FMUs whose sources are in it, `measured` the plant's outputs and the regulator's inputs.
    """
    plant, controller = (fmpy.read_model_description(str(fmus / f"{name}.fmu"))
                         for name in ("Plant3DOF", "Regulator3DOF"))
    of_plant, of_controller = ({v.name: v.valueReference for v in each.modelVariables} for each in (plant, controller))
    commanded = [f"{pair}.i_{phase}_cmd" for pair in ("alpha", "beta") for phase in "abc"]
    text = f"{len(measured)} {len(commanded)}\n" + "\n".join(
        [*(f"{of_plant[a]} {of_controller[b]}" for a, b in measured),
         *(f"{of_controller[each]} {of_plant[each]}" for each in commanded)])
    done = subprocess.run([program, repr(step), str(steps), plant.guid, controller.guid], input=text,
                          check=True, capture_output=True, text=True)
    rows = [[int(each, 16) for each in line.split()] for line in done.stdout.splitlines()]
    return np.array(rows, dtype=np.uint64).view(np.float64)
