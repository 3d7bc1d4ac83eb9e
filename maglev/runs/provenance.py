"""Provenance of a result: version, command, FMUs, and every value that differs from the plan's."""

import hashlib
import platform
import shlex
import subprocess
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache, lru_cache
from importlib.metadata import packages_distributions, version
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from fmpy.model_description import ModelDescription

from maglev.cosim.fmu import HERE
from maglev.descriptions.own_fmus import own_build, stale
from maglev.files.cache import digest_at
from maglev.files.installed import code, edited
from maglev.scenario.layers import scenario_of
from maglev.scenario.run_plan import RunPlan
from maglev.user.source import FmuFile, PythonClass, PythonFile, Source

DIGITS = 12   # of a digest that are shown; NAME.json has all


def typed() -> str:
    """Return the typed command, if it was the command `maglev`."""
    name = Path(sys.argv[0]).name if sys.argv else ""
    called = name == "maglev" or sys.argv[:1] == [str(Path(__file__).parents[1] / "__main__.py")]
    return shlex.join(["maglev", *sys.argv[1:]]) if called else "Python"


@cache
def checked_out() -> str | None:
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


@dataclass(frozen=True)
class UsedFmu:
    name: str   # in the run, such as "plant"
    file: str   # its name
    model: str   # as its model description says, like the next two
    guid: str
    tool: str
    # "Python" or "native" of this project's, "Python file" or "Python class" of a user's, "foreign" otherwise
    kind: str
    put_in: bool   # whether it takes the place of the plan's
    built_here: bool = False   # true if its content is that of an FMU that this installation builds
    # every start value that it was given, SI, by variable; the others are its own
    start: dict[str, float | int | bool | str] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)   # why others of the plan were not given to it
    # of an FMU; of a user's Python file and of the modules next to it, by file name; of a class's text
    sha256: dict[str, str] = field(default_factory=dict)
    # SHA-256 of the library of this machine in an FMU; versions of packages that a user's Python file imports
    libraries: dict[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, name: str, source: Source, description: ModelDescription, **given: Any) -> "UsedFmu":
        """Return the record of a source; `given` has the fields about its use in the run."""
        kind, libraries = kind_and_libraries(source)
        return cls(name, source.name, description.modelName or "", description.guid or "",
                   description.generationTool or "", kind, built_here=source.built_here, sha256=dict(source.digests()),
                   libraries=libraries, **given)

    @property
    def shown(self) -> str:
        """Its file; of one that is not this project's also what it is, and the beginning of its digest."""
        digest = "" if self.built_here else next(iter(self.sha256.values()), "")
        return f"{self.file} ({self.kind}, sha256 {digest[:DIGITS]}…)" if digest else self.file


@dataclass(frozen=True, kw_only=True)
class Provenance:
    """The provenance of a result; fields that are not given take their present values."""

    version: str = field(default_factory=cache(lambda: version("maglev-fmus")))   # of this package
    # of the checkout that it runs from, "…-dirty" with changes that are not committed; None where there is none
    commit: str | None = field(default_factory=checked_out)
    command: str = field(default_factory=typed)   # as it was typed; "Python" for a function call
    python: str = f"{platform.python_version()} on {platform.system()} {platform.machine()}"   # version, and machine
    fmus: tuple[UsedFmu, ...]   # in the order of stepping
    # every value that differs from the plan's, "plant.y.mass = 8 instead of 6.9", and a step or order of its own
    changes: tuple[str, ...]
    scenario: str   # SHA-256 of the scenario and of the files that it extends
    departures: tuple[str, ...]   # why it is not the package's experiment although no change was asked for
    code: str = field(default_factory=code)   # SHA-256 of the Python modules of this package
    libraries: dict[str, str]   # SHA-256 of the compiled library that makes the steps, if there is one
    parameter_sets: dict[str, str]   # SHA-256 of files with start values, by path

    @property
    def modified(self) -> bool:
        """Return True if the run differs from its plan."""
        return bool(self.differences)

    @property
    def differences(self) -> tuple[str, ...]:
        """Return the differences from the plan, FMUs and values, and from the packaged run of the name."""
        return (*(f"{fmu.name} is {fmu.shown}" for fmu in self.fmus if fmu.put_in), *self.changes, *self.departures)

    def as_data(self) -> dict[str, Any]:
        return {**asdict(self), "modified": self.modified}


def departures_of(plan: RunPlan, sources: Mapping[str, Source], put_in: Iterable[str]) -> Iterator[str]:
    """Return why a run with a name, or FMUs, of the package is not the package's: one phrase each.

    A user's own scenario is never the package's, whatever it extends. A missing FMU is an error later.
    """
    for name, fmu in plan.fmus.items():
        source = sources[name]
        if name not in put_in and fmu.model and isinstance(source, FmuFile) and stale(fmu.model, source.path):
            yield f"{name} is a {fmu.model}.fmu that this installation did not build"
    if plan.own and scenario_of(plan.name) is not None:
        yield f"the scenario is {plan.source}, not the package's {plan.name}"
    for changed in edited():
        yield f"{changed} is not as it was installed"


def kind_and_libraries(source: Source) -> tuple[str, dict[str, str]]:
    """Return the kind of an FMU or of its replacement, and its libraries; see `UsedFmu`."""
    if isinstance(source, PythonClass):
        return "Python class", {}
    if isinstance(source, PythonFile):
        return "Python file", versions(source.modules().requires)
    build = own_build(source.path)
    return "foreign" if build is None else build.kind, libraries_in(source.path, digest_at(source.path))


@lru_cache(maxsize=64)
def libraries_in(path: Path, _sha256: str) -> dict[str, str]:
    """SHA-256 of the libraries of this machine in an FMU, by name; looked at once while its own stays the same."""
    with ZipFile(path) as archive:
        return {entry.filename: hashlib.file_digest(archive.open(entry), "sha256").hexdigest()   # type: ignore[arg-type]
                for entry in archive.infolist() if entry.filename.startswith(HERE) and not entry.is_dir()}


def versions(packages: Collection[str]) -> dict[str, str]:
    """Return the versions of importable packages, by name; empty text if a package has none."""
    known = packages_distributions() if packages else {}   # which reads them all
    return {name: ", ".join(version(package) for package in known.get(name, ())) for name in packages}
