"""The FMUs of this project: where they are described, and whether a file is one that this installation makes."""

import re
import zlib
from functools import lru_cache
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from typing import NamedTuple
from zipfile import BadZipFile, ZipFile

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.descriptions.registry import definitions_of, known_stages, system_of
from maglev.files.cache import digest_at
from maglev.files.copies import original
from maglev.files.errors import BuildError, FmuError, ScenarioError, nearest, option, or_of_own_stage
from maglev.files.packages import IN_FMUS
from maglev.fmi.build import Maker, licence_of
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.native_build import made_of
from maglev.fmi.recognition import is_native_build, is_python_build
from pmlsm.description_text import to_text

DEFINITIONS = definitions_of(PACKAGED_STAGES.values())

# Controller and plant as an SSP file: the loop of a scenario. Its start values are the defaults of the FMUs, so that
# tools that ignore start values in the file run the same.
SYSTEMS = {system_of(stage): stage.experiment for stage in PACKAGED_STAGES.values() if stage.experiment}

SYSTEM_STOP = 5.0   # s, of that of a user's stage

KINDS = {"native": "--kind native", "fmi3": "--kind native --fmi 3", "clocked": "--kind native --fmi 3 --clocked",
         "wasm": "--kind native --target wasm"}   # options that build those of a folder, by its name

PYTHON_KIND = "resources/slavemodule.txt"   # in every FMU that runs Python inside
NAME = re.compile(rb'modelName="(\w+)"')
MOST = 50_000_000   # bytes, more than any of them unpacks to


def own_fmu(name: str, folder: Path) -> Path:
    """Path of an FMU of this project, or of a user's stage, in a folder of FMUs.

    A caller that runs one finds it here, and asks `stale` if it is a build of the present sources.
    """
    return folder / f"{name}.fmu"


def current_fmu(name: str, folder: Path) -> Path:
    """Return the same file, if it is built from the present sources; FmuError otherwise."""
    path = own_fmu(name, folder)
    if old := stale(name, path):
        raise FmuError(old)
    return path


def stale(name: str, path: Path) -> str:
    """Say that a file differs from the FMU, system or module of this name that this installation builds: a sentence.

    Empty if it is; also if it is not there, which raises its own error where it is needed.
    """
    same = {".ssp": is_own_system, ".wasm": is_own_module}.get(path.suffix, is_own_fmu)
    if not path.is_file() or same(name, path):
        return ""
    path = original(path)
    return (f"{from_here(path)} is not the {name} that this installation builds; `{build_command(name, path)}` "
            "rebuilds it")


def build_command(name: str, path: Path) -> str:
    """The command that builds an FMU, system or module into the folder of a path."""
    kind = KINDS.get(path.parent.name)
    folder = from_here(path.parent if kind is None else path.parent.parent)
    known = known_stages().own_of(name)
    return " ".join(["maglev build", *([] if known is None else [f"--stage {from_here(known.file)}"]),
                     *([] if kind is None else [kind]), *([] if folder == Path("fmus") else [f"--fmus {folder}"])])


def from_here(path: Path) -> Path:
    """A path as one types it in the current folder."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


def kind_folder(fmus: Path, native: bool, fmi: int, clocked: bool = False) -> Path:
    """Folder of a kind of FMUs below a folder: the Python kind is in this one itself.

    ScenarioError for a version of FMI that there is not, or clocks in another than FMI 3.0.
    """
    if clocked and fmi != 3:
        raise ScenarioError(f"{option('clocked', True)}: needs {option('kind', 'native')} and {option('fmi', 3)}")
    if fmi not in (2, 3) or (fmi == 3 and not native):
        raise ScenarioError(f"{option('fmi', fmi)}: expected 2, or 3 with {option('kind', 'native')}")
    return fmus / ("clocked" if clocked else "fmi3" if fmi == 3 else "native") if native else fmus


def definition(name: str) -> FmuDefinition:
    """Definition of an FMU by its name; BuildError as of `require_definition`."""
    require_definition(name)
    return known_stages().definition(name)


def require_definition(name: str) -> None:
    """Raise BuildError with the nearest name if there is no FMU of a name."""
    if name not in known_stages().definitions():
        if name.endswith(".toml"):
            raise BuildError(f"{name}: expected the name of an FMU; for your own stage give {option('stage', name)}")
        known = [*known_stages().definitions(), *known_stages().systems()]
        raise BuildError(f"there is no FMU {name}, {nearest(name, known, '.py')}, expected one from `maglev list`, "
                         f"{or_of_own_stage()}")


def installed() -> Maker:
    """This installation as the maker of FMUs, without its licence text, which identifies nothing."""
    return Maker(version("maglev-fmus"), "", IN_FMUS)


def project() -> Maker:
    return installed()._replace(licence=licence_of("maglev-fmus"))


def built_here(path: Path) -> bool:
    """Return True if the installed version builds this FMU from its own sources, whatever the FMU states.

    Its code is compared with a build of this installation: all of it in one that runs Python; for a native one see
    `is_native_build`, which names the remaining trust. It is therefore False for another project's FMU with the same
    name, for a changed one, and for one of another version of the sources. The file's name, the date of the build and
    the machine that built it do not matter. False also for a user's class as an FMU, and for any other file.
    """
    return own_build(path) is not None


class OwnBuild(NamedTuple):
    """An FMU of this installation: its name, and "Python" or "native"."""

    name: str
    kind: str


def own_build(path: Path) -> OwnBuild | None:
    """Return name and kind of a file that was built here; None for any other."""
    sha256 = digest_at(path)
    known = tuple(to_text(own.description) for own in known_stages().own.values())
    return build_of_file(path, sha256, known) if sha256 else None


UNREADABLE = (OSError, BadZipFile, zlib.error, KeyError, ValueError, EOFError, RuntimeError, ImportError)


@lru_cache(maxsize=64)
def build_of_file(path: Path, _sha256: str, _stages: tuple[str, ...]) -> OwnBuild | None:
    """Return the build of a file, found once for each content and for the known stages."""
    try:
        return build_of(path)
    except UNREADABLE:
        return None   # whatever is wrong with it, loading it will say


def build_of(file: Path | BytesIO) -> OwnBuild | None:
    """Return the build of an archive, if it was built here; raises one of UNREADABLE if it is no FMU at all."""
    contents = files_in(file)
    match = NAME.search(contents["modelDescription.xml"])
    name = match[1].decode("ascii") if match else ""
    if name not in known_stages().definitions():
        return None
    if PYTHON_KIND in contents:
        same = is_python_build(contents, definition(name), known_stages().definitions()[name].text(), installed())
        return OwnBuild(name, "Python") if same else None
    same = is_native_build(contents, definition(name), installed())
    return OwnBuild(name, "native") if same else None


def is_own_fmu(name: str, path: Path) -> bool:
    build = own_build(path)
    return build is not None and build.name == name


def is_own_module(name: str, path: Path) -> bool:
    """Return True if a WebAssembly module of this name, and the description next to it, were built here."""
    try:
        made = made_of(definition(name), path.read_bytes(), installed())
        return path.with_suffix(".xml").read_bytes().endswith(b"\n" + made)
    except OSError:
        return False


def is_own_system(name: str, path: Path) -> bool:
    """Return True if this installation built all FMUs in a system."""
    try:
        fmus = {file: data for file, data in files_in(path).items() if file.endswith(".fmu")}
        return (name in known_stages().systems() and bool(fmus)
                and all(build_of(BytesIO(data)) is not None for data in fmus.values()))
    except UNREADABLE:
        return False


def files_in(path: Path | BytesIO) -> dict[str, bytes]:
    """Files of an archive by name; ValueError if it is too large, or two files have one name."""
    with ZipFile(path) as archive:
        entries = archive.infolist()
        if sum(entry.file_size for entry in entries) > MOST or len(entries) > len(set(archive.namelist())):
            raise ValueError(f"{path}: not an FMU of this project")
        return {entry.filename: archive.read(entry) for entry in entries}
