"""The FMUs that this project builds."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from importlib.metadata import distribution
from pathlib import Path
from typing import TYPE_CHECKING

from fmi_export.build import build_fmu
from fmi_export.definition import FmuDefinition
from fmi_export.errors import ExportError
from fmi_export.native.build import build_native_fmu, build_webassembly, host_platform, translated_blocks
from fmi_export.native.compiler import library, require_zig
from fmi_export.ssp import write_ssp
from fmi_export.whole_file import whole_files
from maglev.errors import BuildError, nearest
from maglev.processors import processors
from maglev.written.build import FMU, buildable, finished, named_lines
from maglev.written.own_modules import PACKAGES

if TYPE_CHECKING:
    from maglev.schema.run_plan import RunPlan

DEFINITIONS = {
    "Plant2DOF": ("plant_fmu.plant_2dof", "PLANT_2DOF"),
    "Plant3DOF": ("plant_fmu.plant_3dof", "PLANT_3DOF"),
    "Regulator2DOF": ("controller_fmu.regulator_2dof_fmu", "REGULATOR_2DOF"),
    "Regulator3DOF": ("controller_fmu.regulator_3dof_fmu", "REGULATOR_3DOF"),
    "LinearRegulator2DOF": ("controller_fmu.regulator_2dof_fmu", "LINEAR_REGULATOR_2DOF"),
    "LinearRegulator3DOF": ("controller_fmu.regulator_3dof_fmu", "LINEAR_REGULATOR_3DOF"),
    "ScheduledRegulator3DOF": ("controller_fmu.regulator_3dof_fmu", "SCHEDULED_REGULATOR_3DOF"),
    "PID2DOF": ("controller_fmu.pid_fmu", "PID_2DOF"),
    "PID3DOF": ("controller_fmu.pid_fmu", "PID_3DOF"),
    "Commutation2DOF": ("controller_fmu.commutation_fmu", "COMMUTATION_2DOF"),
    "Commutation3DOF": ("controller_fmu.commutation_fmu", "COMMUTATION_3DOF"),
    "Estimator2DOF": ("estimator_fmu.estimator_2dof_fmu", "ESTIMATOR_2DOF"),
    "Estimator3DOF": ("estimator_fmu.estimator_3dof_fmu", "ESTIMATOR_3DOF"),
    "ClosedLoop2DOF": ("closed_loop_fmu.closed_loops_fmu", "CLOSED_LOOP_2DOF"),
    "ClosedLoop3DOF": ("closed_loop_fmu.closed_loops_fmu", "CLOSED_LOOP_3DOF"),
    "ClosedLoopLinear2DOF": ("closed_loop_fmu.closed_loops_fmu", "CLOSED_LOOP_LINEAR_2DOF"),
    "ClosedLoopLinear3DOF": ("closed_loop_fmu.closed_loops_fmu", "CLOSED_LOOP_LINEAR_3DOF"),
    "ClosedLoopScheduled3DOF": ("closed_loop_fmu.closed_loops_fmu", "CLOSED_LOOP_SCHEDULED_3DOF"),
    "ClosedLoopPID2DOF": ("closed_loop_fmu.closed_loops_fmu", "CLOSED_LOOP_PID_2DOF"),
    "ClosedLoopPID3DOF": ("closed_loop_fmu.closed_loops_fmu", "CLOSED_LOOP_PID_3DOF"),
}

# Controller and plant as an SSP file: the loop of a scenario, whose start values are those that the FMUs have anyway,
# so that tools that leave out the start values in it run the same.
SYSTEMS = {"Stage2DOF": "2dof-setpoints", "Stage3DOF": "3dof-setpoints-improved"}


def definition(name: str) -> FmuDefinition:
    """Definition of an FMU by its name; BuildError with the nearest name if there is none."""
    if name not in DEFINITIONS:
        known = [*DEFINITIONS, *SYSTEMS]
        raise BuildError(f"there is no FMU {name}, expected one of {', '.join(known)}; nearest is "
                         f"{nearest(name, known)}")
    module, attribute = DEFINITIONS[name]
    found: FmuDefinition = getattr(import_module(module), attribute)
    return found


@contextmanager
def build_errors() -> Iterator[None]:
    """Say what an export refuses as an error of this package."""
    try:
        yield
    except ExportError as error:
        raise BuildError(str(error)) from error


@build_errors()
def build_written(path: Path, folder: Path, native: bool = False, host_only: bool = False) -> Path:
    """Build the FMU of a user's class into a folder; returns its path.

    Parameters
    ----------
    path : Path
        Python file, `lqi.py`, or a class in it, `lqi.py:LQI`.
    folder : Path
    native : bool
        A native FMU; otherwise one that runs in the importer's Python.
    host_only : bool
        As of `build_native_fmu`.

    Raises
    ------
    ControllerError, BuildError
        If the class cannot be flown, or an FMU cannot have what is in its file; with file and line.
    """
    version, licence = project()
    if native:
        require_zig()
    with buildable(path, PACKAGES, native) as found, whole_files(folder) as unfinished:
        name, packages = found.definition.name, (*PACKAGES, *found.packages)
        if name in (*DEFINITIONS, *SYSTEMS):
            raise BuildError(f"{path}: class {name} would overwrite an FMU of this project, expected another name")
        if native:
            with named_lines(found.files):
                translation = finished(translated_blocks([found.definition], packages), found.packages)
            build_native_fmu(found.definition, translation, version, licence, packages, unfinished, host_only)
        else:
            build_fmu(found.definition, FMU, "DEFINITION", version, licence, packages, unfinished)
    return folder / f"{name}.fmu"


@build_errors()
def build(names: Iterable[str], folder: Path) -> list[Path]:
    """Build FMUs that run in the importer's Python, and systems of them, into a folder; returns their paths.

    After an error the folder is as it was.
    """
    names = list(names)
    chosen = [(definition(name), *DEFINITIONS[name]) for name in with_parts(names)]
    version, licence = project()
    with whole_files(folder) as unfinished:
        fmus = [build_fmu(*item, version=version, licence=licence, packages=PACKAGES, destination=unfinished)
                for item in chosen]
        made = [*fmus, *build_systems([name for name in names if name in SYSTEMS], unfinished, unfinished)]
    return [folder / path.name for path in made]


def with_parts(names: Iterable[str]) -> list[str]:
    """FMUs to build: those that are named, and in place of a system, those of its scenario."""
    chosen = [list(models(loop_of(name)).values()) if name in SYSTEMS else [name] for name in names]
    return list(dict.fromkeys(part for parts in chosen for part in parts))


def loop_of(name: str) -> "RunPlan":
    """Plan of the run that a system is of."""
    from maglev.schema.loading import load_plan  # to list what there is takes no pydantic

    return load_plan(SYSTEMS[name])


def models(plan: "RunPlan") -> dict[str, str]:
    """FMUs of a scenario in the order in which they step, by their names in it."""
    return {part: fmu.model or "" for part, fmu in plan.fmus.items()}


@build_errors()
def build_native(names: Iterable[str], folder: Path, host_only: bool = False) -> list[Path]:
    """Build FMUs that need no Python, and systems of them, into a folder; returns their paths.

    The folder also gets the C loop that steps them on this machine.

    Errors as of `translated_blocks` and `build_native_fmu`, `host_only` as of the latter; after an error the folder is
    as it was.
    """
    names = list(names)
    chosen = [definition(name) for name in with_parts(names)]
    version, licence = project()
    require_zig()
    translation = translated_blocks(chosen, PACKAGES)
    # Most of the time goes to the compiler, in processes of its own.
    with whole_files(folder) as unfinished, ThreadPoolExecutor(processors()) as pool:
        loop = pool.submit(build_step_loop, unfinished)
        fmus = list(pool.map(lambda each: build_native_fmu(each, translation, version, licence, PACKAGES, unfinished,
                                                           host_only), chosen))
        loop.result()
        made = [*fmus, *build_systems([name for name in names if name in SYSTEMS], unfinished, unfinished)]
    return [folder / path.name for path in made]


def build_step_loop(folder: Path) -> None:
    """Compile the loop that steps native FMUs under our master, for this machine."""
    from maglev.cosim.step_loop import LIBRARY, source  # to list what there is takes no fmpy

    platform, = host_platform().values()
    (folder / LIBRARY).write_bytes(library({"step_loop.c": source()}, Path(LIBRARY).stem, platform))


@build_errors()
def build_wasm(names: Iterable[str], folder: Path) -> list[Path]:
    """Build FMUs, and those of systems, as WebAssembly modules with their descriptions; returns the modules' paths.

    Errors as of `build_native`; after an error the folder is as it was.
    """
    chosen = [definition(name) for name in with_parts(names)]
    version, _ = project()
    require_zig()
    translation = translated_blocks(chosen, PACKAGES)
    with whole_files(folder) as unfinished, ThreadPoolExecutor(processors()) as pool:
        made = list(pool.map(lambda each: build_webassembly(each, translation, version, PACKAGES, unfinished), chosen))
    return [folder / module.name for module, _ in made]


def build_systems(names: Iterable[str], fmus: Path, folder: Path) -> list[Path]:
    """Write systems of the FMUs in the folder `fmus` into a folder; returns their paths.

    Each as `NAME.ssp` and, for tools that know no ports of a system, as `NAMENoPorts.ssp`.
    """
    written = []
    for name in names:
        plan = loop_of(name)
        parts = {part: (definition(model), fmus / f"{model}.fmu") for part, model in models(plan).items()}
        for ports in (True, False):
            path = folder / (f"{name}.ssp" if ports else f"{name}NoPorts.ssp")
            written.append(write_ssp(path, parts, list(plan.wires.values()), plan.stop_time, ports))
    return written


def project() -> tuple[str, str]:
    """Version and licence text of this project."""
    installed = distribution("maglev-fmus")
    return installed.version, next(path.read_text() for path in installed.files or [] if path.name == "LICENSE")
