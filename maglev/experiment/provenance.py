"""What a result rests on: version, command, FMUs, and every value that is not the plan's."""

import platform
import shlex
import subprocess
import sys
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fmpy.model_description import ModelDescription

from maglev.cosim.fmu import OWN_TOOL
from maglev.written.source import is_class, is_written, load

DIGITS = 12   # of a digest that are shown; NAME.json has all

PYTHON_KIND = "resources/slavemodule.txt"   # in every FMU that runs Python inside


@dataclass(frozen=True)
class FlownFmu:
    """An FMU of a run.

    Attributes
    ----------
    name : str
        In the run, such as "plant".
    file, model, guid, tool : str
        Its file's name, and what its model description says.
    kind : str
        "Python" or "native" of this project's, "Python file" or "Python class" of a user's, "foreign" otherwise.
    put_in : bool
        Whether it takes the place of the plan's.
    sha256 : dict of str to str
        Of a user's Python file and of the modules beside it, by file name; of a class's text. None of FMUs.
    """

    name: str
    file: str
    model: str
    guid: str
    tool: str
    kind: str
    put_in: bool
    sha256: dict[str, str] = field(default_factory=dict)

    @property
    def shown(self) -> str:
        """Its file; of a user's Python file also what it is, and the beginning of its digest."""
        digest = next(iter(self.sha256.values()), "")
        return f"{self.file} ({self.kind}, sha256 {digest[:DIGITS]}…)" if digest else self.file


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from.

    Attributes
    ----------
    version : str
        Of this package.
    commit : str or None
        Of the checkout that it runs from, "…-dirty" with changes that are not committed; None where there is none.
    command : str
        As it was typed; "Python" for a function call.
    python : str
        Version, and machine.
    fmus : tuple of FlownFmu
        In the order of stepping.
    changes : tuple of str
        Every value that differs from the plan's, "plant.y.mass = 8 instead of 6.9", and a step or order of its own.
    """

    version: str
    commit: str | None
    command: str
    python: str
    fmus: tuple[FlownFmu, ...]
    changes: tuple[str, ...]

    @property
    def modified(self) -> bool:
        """Whether the run is another one than its plan says."""
        return bool(self.differences)

    @property
    def differences(self) -> tuple[str, ...]:
        """What is different from the plan: FMUs that were put in, and values."""
        return (*(f"{fmu.name} is {fmu.shown}" for fmu in self.fmus if fmu.put_in), *self.changes)

    def as_data(self) -> dict[str, Any]:
        """The same as JSON has it."""
        return {**asdict(self), "modified": self.modified}


def provenance(files: Mapping[str, Path], descriptions: Mapping[str, ModelDescription], put_in: Iterable[str],
               changes: Iterable[str]) -> Provenance:
    """Provenance of a run of FMU files, with their descriptions, those that were put in, and the values changed."""
    replaced = set(put_in)
    fmus = tuple(FlownFmu(name, path.name, descriptions[name].modelName or "", descriptions[name].guid or "",
                          descriptions[name].generationTool or "", kind(path, descriptions[name]), name in replaced,
                          dict(load(path).sha256) if is_written(path) else {})
                 for name, path in files.items())
    return Provenance(version("maglev-fmus"), commit(), command(), f"{platform.python_version()} on "
                      f"{platform.system()} {platform.machine()}", fmus, tuple(changes))


def kind(path: Path, description: ModelDescription) -> str:
    """Kind of an FMU, or of what flew in its place."""
    if is_written(path):
        return "Python class" if is_class(path) else "Python file"
    if not (description.generationTool or "").startswith(OWN_TOOL):
        return "foreign"
    with zipfile.ZipFile(path) as archive:
        return "Python" if PYTHON_KIND in archive.namelist() else "native"


def command() -> str:
    """What was typed, if it was the command `maglev`."""
    name = Path(sys.argv[0]).name if sys.argv else ""
    called = name == "maglev" or sys.argv[:1] == [str(Path(__file__).parents[1] / "__main__.py")]
    return shlex.join(["maglev", *sys.argv[1:]]) if called else "Python"


@cache
def commit() -> str | None:
    """Commit of the checkout that holds this file, None where git knows none."""
    root = Path(__file__).parents[2]
    if not (root / ".git").exists():
        return None
    try:
        done = subprocess.run(["git", "describe", "--always", "--dirty", "--abbrev=12"], cwd=root, capture_output=True,
                              text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() or None
