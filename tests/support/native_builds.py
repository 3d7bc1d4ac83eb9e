"""Native FMUs for the tests: built once, however many processes the tests run in, and their C sources."""

import os
import shutil
import subprocess
import zipfile
from collections.abc import Callable
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parents[1] / "fmi_export" / "c"   # C sources of the tests

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror")
# pyccel keeps the results of calls that it does not need.
GENERATED = ("-Wno-unused-but-set-variable",)
FMI_HEADERS = ("-I", str(files("fmpy").joinpath("c-code")))   # an FMU leaves them to its importer


def missing_native_tools() -> list[str]:
    """Packages of the extra `native` that are not installed."""
    return [name for name in ("pyccel", "ziglang") if find_spec(name) is None]


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


def unpacked_sources(fmu: Path, folder: Path) -> Path:
    """Folder `sources` of an FMU, unpacked, with nothing beside it."""
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(folder, [name for name in archive.namelist() if name.startswith("sources/")])
    return folder / "sources"


def compiled(sources: Path, output: Path, *flags: str | Path, extra: tuple[Path, ...] = ()) -> Path:
    """What gcc makes of an FMU's sources, and of `extra` C files, with flags; it must have nothing to say."""
    units = [*sorted(sources.glob("*.c")), *extra]
    done = subprocess.run([require_command("gcc"), *STRICT, *GENERATED, *FMI_HEADERS, *flags, "-I", sources,
                           *units, "-o", output, "-lm"], capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr[-3000:]
    return output
