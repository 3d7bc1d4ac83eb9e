"""The FMUs that this project builds."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, TypeVar

from fmi_export.build import build_fmu
from fmi_export.definition import FmuDefinition
from fmi_export.errors import ExportError
from fmi_export.experiments.files import SMOKE_TEST, VALIDATION, carried
from fmi_export.experiments.smoke_test import smoke_test
from fmi_export.native.build import build_native_fmu, build_webassembly, host_platform, translated_blocks
from fmi_export.native.compiler import library, require_zig
from fmi_export.ssp import write_ssp
from maglev.errors import BuildError
from maglev.own_fmus import DEFINITIONS as DEFINITIONS
from maglev.own_fmus import SYSTEM_STOP, definition, places, project, systems
from maglev.own_fmus import SYSTEMS as SYSTEMS
from maglev.own_stage.loop import loop_table
from maglev.processors import processors
from maglev.schema.layers import PACKAGED
from maglev.user_controllers.build import FMU, buildable, finished, named_lines
from maglev.user_controllers.own_modules import PACKAGES
from maglev.user_controllers.source import is_class
from maglev_files.whole_file import whole_files

Made = TypeVar("Made")
Watch = Callable[[int, int], None]   # told how many of how many are done


@contextmanager
def build_errors() -> Iterator[None]:
    """Say what an export refuses as an error of this package."""
    try:
        yield
    except ExportError as error:
        raise BuildError(str(error)) from error


@build_errors()
def build_written(path: Path, folder: Path, native: bool = False, target: str = "all", fmi: int = 2,
                  clocked: bool = False) -> Path:
    """Build the FMU of a user's class into a folder, or its WebAssembly module; returns its path.

    Parameters
    ----------
    path : Path
        Python file, `lqi.py`, or a class in it, `lqi.py:LQI`.
    folder : Path
    native : bool
        A native FMU; otherwise one that runs in the importer's Python.
    target : "all", "host" or "wasm"
        What a native one is for; "wasm" makes the module with its description in place of an FMU.
    fmi : int
        As of `build_native_fmu`.
    clocked : bool
        As of `build_native`.

    Raises
    ------
    ControllerError, BuildError
        If the class cannot be flown, or an FMU cannot have what is in its file; with file and line.
    """
    from maglev.cosim.open import read_description  # to list what there is takes no fmpy

    version, licence = project()
    if native:
        require_zig()
    if not is_class(path):
        read_description("controller", path)   # in another process, which a file may end when it is imported
    with buildable(path, PACKAGES, native) as found, whole_files(folder) as unfinished:
        name, packages = found.definition.name, (*PACKAGES, *found.packages)
        if name in (*places(), *systems()):
            raise BuildError(f"{path}: class {name} would overwrite an FMU of this project, expected another name")
        if native:
            with named_lines(found.files):
                translation = finished(translated_blocks([found.definition], packages), found.packages)
            if target == "wasm":
                return folder / build_webassembly(found.definition, translation, version, packages, unfinished)[0].name
            build_native_fmu(replace(found.definition, clocked=clocked), translation, version, licence, packages,
                             unfinished, target == "host", fmi)
        else:
            build_fmu(found.definition, FMU, "DEFINITION", version, licence, packages, unfinished)
    return folder / f"{name}.fmu"


def unwatched(_done: int, _number: int) -> None:
    """Nobody looks on."""


def counted(made: Iterable[Made], number: int, watch: Watch) -> list[Made]:
    """List of what is made one by one; `watch` is told how many of how many there are."""
    found = []
    for each in made:
        found.append(each)
        watch(len(found), number)
    return found


@build_errors()
def build(names: Iterable[str], folder: Path, watch: Watch = unwatched) -> list[Path]:
    """Build FMUs that run in the importer's Python, and systems of them, into a folder; returns their paths.

    `watch` is told how many FMUs of how many are built. After an error the folder is as it was.
    """
    names = list(names)
    chosen = [(definition(name), *places()[name]) for name in with_parts(names)]
    version, licence = project()
    with whole_files(folder) as unfinished:
        fmus = counted((build_fmu(*item, version=version, licence=licence, packages=PACKAGES, destination=unfinished,
                                  extra=experiments_in(item[0])) for item in chosen), len(chosen), watch)
        made = [*fmus, *build_systems([name for name in names if name in systems()], unfinished, unfinished)]
    return [folder / path.name for path in made]


def experiments_in(definition: FmuDefinition) -> dict[str, bytes]:
    """Files of the experiments that an FMU carries: a smoke test, and of those of this project a part of a scenario.

    One with a clock has none: who flies them steps FMUs without one.
    """
    if definition.sampled and definition.clocked:
        return {}
    test, name = smoke_test(definition), f"{definition.name}_validation"
    found = {test.name: (SMOKE_TEST, test.files())}
    recorded = {path.name: path.read_bytes() for path in sorted((PACKAGED / "validation").glob(f"{name}*"))}
    return carried(found | ({name: (VALIDATION, recorded)} if recorded else {}))


def with_parts(names: Iterable[str]) -> list[str]:
    """FMUs to build: those that are named, and in place of a system, those of its scenario."""
    chosen = [list(loop_of(name).models.values()) if name in systems() else [name] for name in names]
    return list(dict.fromkeys(part for parts in chosen for part in parts))


class SystemLoop(NamedTuple):
    """Models of a system by their names in it, in the order of stepping; what they exchange; the stop time (s)."""

    models: dict[str, str]
    wires: list[tuple[str, str]]
    stop_time: float


def loop_of(name: str) -> SystemLoop:
    """Loop of a system: that of an experiment, or of a stage of the user's the one that its scenarios have."""
    from maglev.schema.loading import load_plan  # to list what there is takes no pydantic

    rig = systems()[name]
    if not rig.experiment:
        table = loop_table(rig)
        models = {part: fmu["model"] for part, fmu in table["fmus"].items()}
        return SystemLoop(models, [(source, target) for source, target in table["connections"]], SYSTEM_STOP)
    plan = load_plan(rig.experiment)
    return SystemLoop({part: fmu.model or "" for part, fmu in plan.fmus.items()}, list(plan.wires.values()),
                      plan.stop_time)


@build_errors()
def build_native(names: Iterable[str], folder: Path, host_only: bool = False, watch: Watch = unwatched,
                 fmi: int = 2, clocked: bool = False) -> list[Path]:
    """Build FMUs that need no Python, and systems of them, into a folder; returns their paths.

    The folder also gets the C loop that steps them on this machine. Clocked ones of FMI 3.0 sample when a clock of
    their importer's ticks.

    Errors as of `translated_blocks` and `build_native_fmu`, `host_only` and `fmi` as of the latter, `watch` as of
    `build`; after an error the folder is as it was.
    """
    names = list(names)
    chosen = [replace(definition(name), clocked=clocked) for name in with_parts(names)]
    version, licence = project()
    require_zig()
    watch(0, len(chosen))   # the translation takes its time
    translation = translated_blocks(chosen, PACKAGES)
    # Most of the time goes to the compiler, in processes of its own.
    with whole_files(folder) as unfinished, ThreadPoolExecutor(processors()) as pool:
        loop = pool.submit(build_step_loop, unfinished)
        fmus = counted(pool.map(lambda each: build_native_fmu(each, translation, version, licence, PACKAGES, unfinished,
                                                              host_only, fmi, experiments_in(each)), chosen),
                       len(chosen), watch)
        loop.result()
        made = [*fmus, *build_systems([name for name in names if name in systems()], unfinished, unfinished, fmi)]
    return [folder / path.name for path in made]


def build_step_loop(folder: Path) -> None:
    """Compile the loop that steps native FMUs under our master, for this machine."""
    from maglev.cosim.step_loop import LIBRARY, source  # to list what there is takes no fmpy

    platform, = host_platform().values()
    (folder / LIBRARY).write_bytes(library({"step_loop.c": source()}, Path(LIBRARY).stem, platform))


@build_errors()
def build_wasm(names: Iterable[str], folder: Path, watch: Watch = unwatched) -> list[Path]:
    """Build FMUs, and those of systems, as WebAssembly modules with their descriptions; returns the modules' paths.

    Errors and `watch` as of `build_native`; after an error the folder is as it was.
    """
    chosen = [definition(name) for name in with_parts(names)]
    version, _ = project()
    require_zig()
    watch(0, len(chosen))
    translation = translated_blocks(chosen, PACKAGES)
    with whole_files(folder) as unfinished, ThreadPoolExecutor(processors()) as pool:
        made = counted(pool.map(lambda each: build_webassembly(each, translation, version, PACKAGES, unfinished),
                                chosen), len(chosen), watch)
    return [folder / module.name for module, _ in made]


def build_systems(names: Iterable[str], fmus: Path, folder: Path, fmi: int = 2) -> list[Path]:
    """Write systems of the FMUs, of a version of FMI, in the folder `fmus` into a folder; returns their paths.

    Each as `NAME.ssp` and, for tools of FMI 2.0 that know no ports of a system, as `NAMENoPorts.ssp`.
    """
    written = []
    for name in names:
        loop = loop_of(name)
        parts = {part: (definition(model), fmus / f"{model}.fmu") for part, model in loop.models.items()}
        for ports in (True, False) if fmi == 2 else (True,):
            path = folder / (f"{name}.ssp" if ports else f"{name}NoPorts.ssp")
            written.append(write_ssp(path, parts, loop.wires, loop.stop_time, ports, fmi))
    return written
