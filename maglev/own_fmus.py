"""The FMUs of this project: where they are described, and whether a file is one that this installation makes."""

import re
import zlib
from functools import lru_cache
from importlib import import_module
from importlib.metadata import distribution, version
from pathlib import Path
from zipfile import BadZipFile, ZipFile

from fmi_export.definition import FmuDefinition
from fmi_export.recognition import is_native_build, is_python_build
from maglev.errors import BuildError, ScenarioError, nearest
from maglev.own_stage.adoption import OWN, know_stage
from maglev.rig.modules import definitions
from maglev.user_controllers.own_modules import PACKAGES
from pmlsm.rig import Rig
from pmlsm.rigs import RIGS

DEFINITIONS = {name: place for rig in RIGS.values() for name, place in definitions(rig).items()}

# Controller and plant as an SSP file: the loop of a scenario, whose start values are those that the FMUs have anyway,
# so that tools that leave out the start values in it run the same.
SYSTEMS = {f"Stage{rig.suffix}": rig.experiment for rig in RIGS.values() if rig.experiment}

SYSTEM_STOP = 5.0   # s, of that of a stage of the user's

PYTHON_KIND = "resources/slavemodule.txt"   # in every FMU that runs Python inside
NAME = re.compile(rb'modelName="(\w+)"')
MOST = 50_000_000   # bytes, more than any of them unpacks to


def kind_folder(fmus: Path, native: bool, fmi: int = 2, clocked: bool = False) -> Path:
    """Folder of a kind of FMUs below a folder: the Python kind is in this one itself.

    ScenarioError for a version of FMI that there is not, or clocks in another than FMI 3.0.
    """
    if clocked and fmi != 3:
        raise ScenarioError("--clocked: expected --native and --fmi 3 with it")
    if fmi not in (2, 3) or (fmi == 3 and not native):
        raise ScenarioError(f"--fmi {fmi}: expected 2, or 3 and --native with it")
    return fmus / ("clocked" if clocked else "fmi3" if fmi == 3 else "native") if native else fmus


def places() -> dict[str, tuple[str, str]]:
    """Module and attribute of every FMU that can be built, by its name: of the project, and of the user's stages."""
    return DEFINITIONS | {name: place for own in OWN.values() for name, place in definitions(own.rig).items()}


def systems() -> dict[str, Rig]:
    """Rig of every system that can be built, by its name: of the project, and of the user's stages."""
    rigs = [*(rig for rig in RIGS.values() if rig.experiment), *(own.rig for own in OWN.values())]
    return {f"Stage{rig.suffix}": rig for rig in rigs}


def names_of(rig: str | Path | None) -> list[str]:
    """Names of all FMUs and systems, of this project or of a stage of the user's."""
    if rig is None:
        return [*DEFINITIONS, *SYSTEMS]
    described = know_stage(rig)
    return [*definitions(described), f"Stage{described.suffix}"]


def definition(name: str) -> FmuDefinition:
    """Definition of an FMU by its name; BuildError with the nearest name if there is none."""
    if name not in places():
        if name.endswith(".toml"):
            raise BuildError(f"{name}: expected the name of an FMU; the FMUs of a stage of yours: --rig {name}")
        raise BuildError(f"there is no FMU {name}, nearest is {nearest(name, [*places(), *systems()])}, expected one "
                         "that `maglev list` lists, or with --rig mine.toml one of a stage of yours")
    module, attribute = places()[name]
    found: FmuDefinition = getattr(import_module(module), attribute)
    return found


def project() -> tuple[str, str]:
    """Version and licence text of this project."""
    installed = distribution("maglev-fmus")
    return installed.version, next(path.read_text() for path in installed.files or [] if path.name == "LICENSE")


def built_here(path: Path) -> bool:
    """Whether an FMU is one that the installed version builds of its own sources, whatever it says of itself.

    Its code is compared with what this installation makes: all of it in one that runs Python; of a native one see
    `is_native_build`, which says what remains trusted. So neither another project's FMU with our name in it, nor one
    that somebody changed, nor one of another version of the sources is; its file's name, the date of the build and the
    machine that built it do not matter. False also of a user's class as an FMU, and of what is no FMU at all.
    """
    return own_kind(path) is not None


def own_kind(path: Path) -> str | None:
    """Kind of an FMU that was built here, "Python" or "native"; None of what was not."""
    try:
        written = path.stat()
    except OSError:
        return None
    return kind_of_build(path, written.st_mtime_ns, written.st_size, written.st_ino,
                         tuple(str(own.folder) for own in OWN.values()))


@lru_cache(maxsize=64)
def kind_of_build(path: Path, _written: int, _size: int, _file: int, _stages: tuple[str, ...]) -> str | None:
    """Kind of a file that is an FMU of this installation, looked at once for as long as it stays as it is."""
    try:
        contents = files_in(path)
        found = NAME.search(contents["modelDescription.xml"])
        name = found[1].decode("ascii") if found else ""
        if name not in places():
            return None
        if PYTHON_KIND in contents:
            same = is_python_build(contents, definition(name), *places()[name], version("maglev-fmus"), PACKAGES)
            return "Python" if same else None
        return "native" if is_native_build(contents, definition(name), version("maglev-fmus"), PACKAGES) else None
    except (OSError, BadZipFile, zlib.error, KeyError, ValueError, EOFError, RuntimeError, ImportError):
        return None   # whatever is wrong with it, loading it will say


def files_in(path: Path) -> dict[str, bytes]:
    """Files of an archive by name; ValueError if it is none of ours: too large, or two files of one name."""
    with ZipFile(path) as archive:
        entries = archive.infolist()
        if sum(entry.file_size for entry in entries) > MOST or len(entries) > len(set(archive.namelist())):
            raise ValueError(f"{path}: not an FMU of this project")
        return {entry.filename: archive.read(entry) for entry in entries}
