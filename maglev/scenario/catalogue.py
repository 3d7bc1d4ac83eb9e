"""The FMUs that this project builds."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from maglev.descriptions.own_fmus import SYSTEM_STOP, definition, project
from maglev.descriptions.registry import known_stages
from maglev.files.cache import PLACE, cache_folder, digest_at
from maglev.files.errors import BuildError
from maglev.files.programs import programs_side_by_side
from maglev.files.session import SESSION
from maglev.files.side_by_side import Progress, processors
from maglev.files.whole_file import whole_files
from maglev.fmi.build import build_fmu
from maglev.fmi.compiler import require_zig
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.experiment_files import experiments_files, response, smoke_test
from maglev.fmi.native_build import build_native_fmu, build_webassembly, own_code
from maglev.fmi.ssp import write_ssp
from maglev.language.errors import ExportError
from maglev.user.blocks import BuiltClasses
from maglev.user.build import FMU, buildable
from maglev.user.scenario_loop import loop_table
from maglev.user.source import PythonFile

Make = Callable[[FmuDefinition, Path], Path]   # builds one into a folder, and gives the path of its file


class Kind(NamedTuple):
    """The kind of an FMU: Python or `native`, its platforms ("all", the "host" or "wasm"), and FMI 2 or 3.

    Clocked FMUs of FMI 3.0 sample when a clock of the importer ticks.
    """

    native: bool = False
    target: str = "all"
    fmi: int = 2
    clocked: bool = False


PYTHON, HOST, WASM = Kind(), Kind(True, "host"), Kind(True, "wasm")


@contextmanager
def build_errors() -> Iterator[None]:
    """Turn the errors of an export into errors of this package."""
    try:
        yield
    except ExportError as error:
        raise BuildError(str(error)) from error


@build_errors()
def build_written(source: PythonFile, folder: Path, kind: Kind = PYTHON) -> Path:
    """Build the FMU of a user's class into a folder, or its WebAssembly module; returns its path.

    ControllerError or BuildError if the class cannot be run, or an FMU cannot have what is in its file; with file and
    line.
    """
    from maglev.cosim.open import describe  # to list what there is takes no fmpy

    if kind.native:
        require_zig()
    describe("controller", source)   # in another process, which a file may end when it is imported
    with buildable(source, kind.native) as written, whole_files(folder) as unfinished:
        own = written.definition
        if own.name in (*known_stages().definitions(), *known_stages().systems()):
            raise BuildError(f"{source}: class {own.name} would overwrite an FMU of this project, expected another "
                             "name")
        made = maker(kind, written.texts)(own, unfinished)
        if kind.native and own_code(own, project().packages).ends:
            SESSION.get(BuiltClasses).definitions[digest_at(made)] = own
        return folder / made.name


def maker(kind: Kind, own: Mapping[str, str] | None = None) -> Make:
    """Return a function that builds one definition as an FMU of a kind.

    `own` are texts of the modules of a user's class, by name. Raises ExportError as `build_native_fmu` does.
    """
    made_by = project()._replace(pages=tuple(stage.folder for stage in known_stages().own.values()))
    if not kind.native:
        made_by = made_by._replace(packages=(*made_by.packages, *(own or ())))
    if kind.native:
        require_zig()

    def make(definition: FmuDefinition, folder: Path) -> Path:
        if kind.target == "wasm":
            return build_webassembly(definition, made_by, folder, own)[0]
        definition = replace(definition, clocked=kind.clocked)
        extra = {} if own else experiments_in(definition)
        if kind.native:
            return build_native_fmu(definition, made_by, folder, kind.target == "host", kind.fmi, extra, own)
        written = f"from {FMU} import DEFINITION" if own else as_python(definition)
        return build_fmu(definition, written, made_by, folder, extra)

    return make


def unwatched(_done: int, _number: int) -> None:
    pass


def as_python(definition: FmuDefinition) -> str:
    """Return the Python text of a definition of this project, also of one with parameters as inputs."""
    text = known_stages().definitions()[definition.was or definition.name].text()
    if definition.fed:
        text += (f"\nfrom maglev.fmi.definition import with_inputs\n\nDEFINITION = with_inputs(DEFINITION, "
                 f"{definition.name!r}, {definition.fed!r})\n")
    return text


@build_errors()
def build(names: Iterable[str], folder: Path, kind: Kind = PYTHON, watch: Progress = unwatched) -> list[Path]:
    """Build FMUs, and systems of them, into a folder; returns their paths.

    With native ones comes the C loop that steps them on this machine; WebAssembly modules come with their descriptions,
    and instead of systems. `watch` is told how many FMUs of how many are built. After an error the folder is as it
    was; errors as of `maker`.
    """
    names = list(names)
    chosen = [definition(name) for name in with_parts(names)]
    watch(0, len(chosen))
    make = maker(kind)
    made = []
    # Most of the time goes to the compiler, in processes of its own; Python alone is not faster side by side.
    with whole_files(folder) as unfinished, programs_side_by_side(processors() if kind.native else 1) as pool:
        loop = pool.submit(build_step_loop) if kind.native and kind.target != "wasm" else None
        for path in pool.map(lambda definition: make(definition, unfinished), chosen):
            made.append(path)
            watch(len(made), len(chosen))
        if loop is not None:
            loop.result()
        if kind.target != "wasm":
            chosen_systems = [name for name in names if name in known_stages().systems()]
            made += build_systems(chosen_systems, unfinished, unfinished, kind.fmi)
    return [folder / path.name for path in made]


def experiments_in(definition: FmuDefinition) -> dict[str, bytes]:
    """Return the files of the experiments in an FMU: a smoke test, and the response to steps of its inputs.

    An FMU with a clock has none, because the tools that run experiments tick no clock.
    """
    if definition.sampled and definition.clocked:
        return {}
    experiments = [smoke_test(definition)]
    with suppress(ExportError):   # a user's stage may refuse to be moved from its start
        experiments.append(response(definition))
    return experiments_files({each.name: (each.role, each.files()) for each in experiments})


def with_parts(names: Iterable[str]) -> list[str]:
    """Return the FMUs to build: the named ones, and for a system those of its scenario."""
    chosen = [list(system_loop(name).models.values()) if name in known_stages().systems() else [name] for name in names]
    return list(dict.fromkeys(part for parts in chosen for part in parts))


class SystemLoop(NamedTuple):
    """The models of a system by name, in the order of stepping, with their connections and the stop time (s)."""

    models: dict[str, str]
    wires: list[tuple[str, str]]
    stop_time: float


def system_loop(name: str) -> SystemLoop:
    """Return the loop of a system: that of an experiment, or for a user's stage that of its scenarios."""
    from maglev.scenario.loading import load_plan  # to list what there is takes no pydantic

    stage = known_stages().systems()[name]
    if not stage.experiment:
        table = loop_table(stage)
        models = {part: fmu["model"] for part, fmu in table["fmus"].items()}
        return SystemLoop(models, [(source, target) for source, target in table["connections"]], SYSTEM_STOP)
    plan = load_plan(stage.experiment)
    return SystemLoop({part: fmu.model or "" for part, fmu in plan.fmus.items()}, list(plan.wires.values()),
                      plan.stop_time)


def build_step_loop() -> None:
    """Compile the loop that steps FMUs under our master, for this machine, into the user's cache, if there is room."""
    from maglev.cosim.step_loop import build_loop  # to list what there is takes no fmpy

    with suppress(OSError):   # runs are stepped in Python, then
        build_loop()


def without_step_loop() -> str:
    """Return a sentence if the loop is missing although it was built, else an empty text."""
    from maglev.cosim.step_loop import own_loop

    return "" if own_loop() is not None else uncacheable("the step loop", "runs are stepped in Python")


def uncacheable(what: str, then: str) -> str:
    """Return a sentence that says that a file cannot be cached, and the consequence."""
    return (f"{cache_folder()}: {what} cannot be kept there, expected a folder that this user alone can write to; "
            f"{then}. {PLACE} sets another folder")


def build_systems(names: Iterable[str], fmus: Path, folder: Path, fmi: int = 2) -> list[Path]:
    """Write the FMUs in the folder `fmus` as systems, for a version of FMI, into a folder; return their paths.

    Each is written as `NAME.ssp` and as `NAMENoPorts.ssp`, which is for tools of FMI 2.0 that know no ports of a
    system.
    """
    written = []
    for name in names:
        loop = system_loop(name)
        parts = {part: (definition(model), fmus / f"{model}.fmu") for part, model in loop.models.items()}
        for ports in (True, False) if fmi == 2 else (True,):
            path = folder / (f"{name}.ssp" if ports else f"{name}NoPorts.ssp")
            written.append(write_ssp(path, parts, loop.wires, loop.stop_time, ports, fmi))
    return written
