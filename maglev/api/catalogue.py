"""The FMUs and systems to build, and the runs of the package."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from maglev.descriptions.own_fmus import DEFINITIONS, SYSTEMS, definition, kind_folder
from maglev.descriptions.registry import definitions, known_stages, system_of
from maglev.files.errors import ControllerError, ScenarioError, option
from maglev.files.side_by_side import Progress, warn
from maglev.scenario.catalogue import Kind, build_written, unwatched, without_step_loop
from maglev.scenario.catalogue import build as build_named
from maglev.scenario.layers import merged, packaged_files, run_layers
from maglev.scenario.loading import load_plan
from maglev.scenario.options import KindName
from maglev.scenario.scenario_system import build_scenario
from maglev.scenario.shipped import take_native
from maglev.user.adoption import know_stage
from maglev.user.source import Given, PythonFile, carried


@dataclass(frozen=True)
class FmuEntry:
    """An FMU, or a system of FMUs, that this package builds: name, ending of its file, and description."""

    name: str
    ending: str
    description: str

    def file(self, fmus: str | Path = "fmus") -> Path:
        """Return its file in the folder of the FMUs."""
        return Path(fmus) / f"{self.name}.{self.ending}"


def fmus(stage: str | Path | None = None) -> list[FmuEntry]:
    """FMUs and systems that `build` makes; of your own stage those of its description, "mine.toml".

    Examples
    --------
    >>> import maglev
    >>> [entry.name for entry in maglev.fmus()][:2]
    ['Plant2DOF', 'Regulator2DOF']
    """
    names, connected = fmu_names(stage), known_stages().systems()
    return [FmuEntry(name, "ssp", f"plant and controller of {connected[name].experiment or connected[name].title}, "
                     "connected (SSP)") if name in connected else FmuEntry(name, "fmu", definition(name).description)
            for name in names]


def fmu_names(stage: str | Path | None) -> list[str]:
    """Return the names of all FMUs and systems, of this project or of a user's stage."""
    if stage is None:
        return [*DEFINITIONS, *SYSTEMS]
    described = know_stage(stage)
    return [*definitions(described), system_of(described)]


@dataclass(frozen=True)
class RunEntry:
    """A run that comes with the package: its name, the scenario that it is of, its title, the thesis's figures."""

    name: str
    scenario: str
    title: str
    figures: tuple[str, ...]


def scenarios() -> list[RunEntry]:
    """Runs that come with the package, in the order of their scenarios.

    Examples
    --------
    >>> import maglev
    >>> [run.name for run in maglev.scenarios() if run.scenario == "2dof-step-4"]
    ['2dof-step-4-nonlinear', '2dof-step-4-linear', '2dof-step-4-fed-forward']
    """
    return [RunEntry(run["name"], scenario, run["title"], tuple(run.get("figures", ())))
            for scenario, path in packaged_files().items() for run in map(merged, run_layers(path))]


def build(names: Iterable[Given] | Given = (), *, stage: str | Path | None = None,
          fmus: str | Path = "fmus", kind: KindName = "python", fmi: int = 2, target: str = "all",
          source: str | Path | None = None, clocked: bool = False, ssp: str | Path | None = None,
          say: Callable[[str], None] | None = None, watch: Progress = unwatched) -> list[Path]:
    """Build FMUs from the blocks; the same sources give the same bytes. Returns the files.

    Parameters
    ----------
    names : str, Path or type, or iterable of these, optional
        Names of `fmus()`, all if not given. Or your controller: a Python file, "lqi.py" or "lqi.py:LQI", or its class,
        if a module defines it.
    stage : path, optional
        Description of your own stage, whose FMUs are built: all of them if no names are given.
    fmus : path
        Folder for the files, made if it is not there.
    kind : "python" or "native"
        Native ones need no Python; they go into the folder's folder `native`, and are made by the extra `native`.
    fmi : int
        Of native ones: version of FMI; those of FMI 3.0 go into the folder's folder `fmi3`, their systems as SSP 2.0.
    target : "all", "host" or "wasm"
        Of native ones: binaries for Linux, Windows and macOS, or one for this machine. "wasm" makes, instead of the
        FMUs, their WebAssembly modules `NAME.wasm`, each with its model description `NAME.xml`, in the folder's folder
        `wasm`.
    source : path, optional
        Of native ones: archive of a release, or a folder with its content, to copy them from without a compiler. They
        must be of the installed sources.
    clocked : bool
        With `fmi=3`: FMUs sample when a clock of the importer ticks; into the folder's folder `clocked`.
    ssp : str or path, optional
        A run of the package, or a TOML file: its FMUs, connections and start values become one file `NAME.ssp`, and
        its settings `NAME.ssv`. Inputs with a signal are inputs of the system; parameters with a signal or a
        connection are inputs of the FMUs in it.
    say : callable, optional
        Called with a sentence on the packages that an FMU of a Python file needs in its importer; a warning if not
        given.
    watch : callable, optional
        Called with the number of FMUs built, and the number of all.

    Raises
    ------
    MaglevError
        If a name does not exist, or a tool of the build is missing.

    Examples
    --------
    >>> import maglev
    >>> [path.name for path in maglev.build(["PID3DOF"])]
    ['PID3DOF.fmu']
    """
    if kind not in get_args(KindName):
        raise ScenarioError(f"{option('kind', kind)}: expected python or native")
    native = kind == "native"
    if target not in ("all", "host", "wasm") or (target != "all" and not native):
        raise ScenarioError(f"{option('target', target)}: expected all, host or wasm, with {option('kind', 'native')}")
    given = [carried(name) for name in ([names] if isinstance(names, str | type) or not isinstance(names, Iterable)
                                        else names)]
    if stage is not None:
        from maglev.user.consequences import stage as consequences  # linear models: scipy takes its time to load

        follows = consequences(stage)
        if say is not None:
            say(follows.brief)
        for warning in follows.warnings:
            (say or warn)(f"{stage}: {warning}")
    all_of = [name for name in fmu_names(stage) if name not in known_stages().systems() or target != "wasm"]
    folder = kind_folder(Path(fmus), native, fmi, clocked)
    if target == "wasm":
        folder = Path(fmus) / "wasm"
        if fmi != 2:
            raise ScenarioError(f"{option('fmi', fmi)}: expected 2 with {option('target', 'wasm')}")
    if ssp is not None:
        if given or stage is not None or source is not None or clocked or target == "wasm":
            raise ScenarioError(f"{option('ssp', str(ssp))}: cannot be combined with names, {option('stage')}, "
                                f"{option('source')}, {option('clocked')} or {option('target', 'wasm')}")
        plan = load_plan(ssp)
        if plan.stage_file is not None:
            know_stage(plan.stage_file)
        return build_scenario(plan, folder, Kind(native, target, fmi))
    files = [block for block in given if isinstance(block, PythonFile)]
    chosen = [str(block) for block in given if not isinstance(block, PythonFile)]
    if source is not None:
        if not native or target != "all" or stage is not None or files:
            raise ScenarioError(f"{option('source', str(source))}: needs {option('kind', 'native')}, and has FMUs of "
                                "this package only")
        return take_native(map(str, given or all_of), Path(source), folder, fmi, clocked)
    require_different_names(files, chosen if given else all_of)
    form = Kind(native, target, fmi, clocked)
    written = [build_written(file, folder, form) for file in files]
    chosen = chosen if given else all_of
    ours = build_named(chosen, folder, form, watch) if chosen else []
    if ours and native and target != "wasm" and (lacking := without_step_loop()):
        (say or warn)(lacking)
    for path, file in zip(written, files, strict=True):
        if needed := () if native else file.load().requires:
            (say or warn)(f"{path} does not contain {', '.join(needed)}: the Python of who imports it needs "
                                   f"{'them' if len(needed) > 1 else 'it'}")
    return [*ours, *written]


def require_different_names(files: Iterable[PythonFile], names: Iterable[str]) -> None:
    """Raise an error if two classes, or a class and an FMU built with it, have one name: files get these names."""
    from maglev.cosim.open import describe  # in another process, which a file may end when it is imported

    taken = {name.casefold(): name for name in names}
    for file in files:
        name = describe("controller", file).modelName
        other = taken.setdefault(name.casefold(), str(file))
        if other != str(file):
            raise ControllerError(f"{file}: its class {name} has the name of {other}, expected another one: the FMU is "
                                  "named after it")
