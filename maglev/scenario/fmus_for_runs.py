"""FMUs that runs need: from a named folder, or built when they are missing and kept in the user's cache.

A cached file is named after the digest of all its inputs, so that every folder and every version finds its own. The
wheel of a release contains native FMUs for all platforms, and modules. They are taken from it without a compiler.
"""

import platform
from collections.abc import Collection, Iterable
from contextlib import suppress
from functools import cache, partial
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import get_args

from maglev.descriptions.own_fmus import kind_folder, require_definition, stale
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.descriptions.registry import known_stages
from maglev.files.cache import FMUS, cache_folder, keep, kept, key_of
from maglev.files.copies import copied
from maglev.files.environment import DATE, number_in
from maglev.files.errors import BuildError, ScenarioError, few, option
from maglev.files.installed import files_digest
from maglev.files.packages import BLOCKS, HERE
from maglev.files.scratch import scratch
from maglev.files.side_by_side import Say, Watch, unwatched, warn
from maglev.language.errors import ExportError
from maglev.scenario.catalogue import PYTHON, Kind, build, build_step_loop, uncacheable
from maglev.scenario.options import KindName
from maglev.scenario.shipped import take_native
from maglev.user.adoption import know_stage
from pmlsm.description_text import to_text

SHIPPED = HERE / "maglev" / "shipped"          # only in the wheel of a release
COMPILER = ("ziglang",)                         # what native FMUs are made with
TOOLS = ("fmpy", "pythonfmu", *COMPILER)        # parts of built FMUs come from these


def fmus_for_runs(names: Iterable[str], fmus: str | Path | None = None, kind: str | None = None, fmi: int = 2, *,
                  everywhere: bool = False, say: Say = warn, watch: Watch = unwatched) -> Path:
    """Return the folder with FMUs of this project, or of the user's stages that this process knows.

    `fmus` is a folder that the user names. Its FMUs run as they are, and nothing is built. Native ones are in its
    folder `native`, those of FMI 3.0 in `fmi3`. Without a `kind` a named folder is taken as it is, and built FMUs are
    native where there is a compiler, for this machine or `everywhere`. Raises ScenarioError or BuildError if the kind
    or the FMU does not exist, or an FMU of `kind` or `fmi` cannot be built.
    """
    if kind not in (None, *get_args(KindName)):
        raise ScenarioError(f"{option('kind', kind)}: expected python or native")
    asked = kind == "native" or (kind is None and fmi != 2)
    folder = kind_folder(Path(fmus or ""), asked, fmi)
    if fmus is not None:
        if asked and folder.is_dir():
            step_in_c()
        return folder
    needed = list(dict.fromkeys(names))
    for name in needed:
        require_definition(name)
    native = Kind(True, "all" if everywhere else "host", fmi)
    if asked or compiles(kind) or (kind is None and all(is_shipped(name, native) for name in needed)):
        try:
            return built(needed, native, say, watch)
        except BuildError as error:
            if asked:
                raise
            say(f"{error}; runs use FMUs in Python instead: the same results, slower")
    return built(needed, PYTHON, say, watch)


def fmus_named(given: Iterable[object], stage: str | Path | None, fmus: str | Path | None = None,
               kind: str | None = None, fmi: int = 2) -> Path:
    """Return a folder with the FMUs that are given by name, among files and classes; also of the stage of a
    description.
    """
    if stage is not None:
        know_stage(stage)
    return fmus_for_runs([str(name) for name in given if str(name) in known_stages().definitions()], fmus, kind, fmi)


def compiles(kind: str | None) -> bool:
    """Return True if FMUs of a kind, or of the default kind, are built as native ones."""
    return kind == "native" or (kind is None and has_compiler())


def has_compiler() -> bool:
    """Return True if the tools that make native FMUs are installed."""
    return all(find_spec(name) is not None for name in COMPILER)


def step_in_c() -> None:
    """Build the loop that steps native FMUs if possible: cached or named FMUs may lack it."""
    if has_compiler():
        with suppress(ExportError):
            build_step_loop()


def built(names: Collection[str], kind: Kind, say: Say, watch: Watch) -> Path:
    """Return a folder with FMUs or modules of a kind, from the cache, from a release, or else built.

    They are copies, so that a run keeps its files if the cache changes. Raises BuildError as `build` and `take_native`
    do.
    """
    ready: dict[str, bytes] = {}
    for name in names:
        ready |= kept_files(name, kind)
    shipped = [name for name in names if file_names(name, kind)[0] not in ready and is_shipped(name, kind)]
    if shipped:
        contents = shipped_files(shipped, kind)
        ready |= contents
        keep_files(shipped, kind, contents, say)
    missing = [name for name in names if file_names(name, kind)[0] not in ready]
    if missing:
        for stage in {stage.file: stage for stage in map(known_stages().own_of, missing) if stage is not None}:
            require_runnable(stage, say)
        what = "WebAssembly modules" if kind.target == "wasm" else f"{'native' if kind.native else 'Python'} FMUs"
        say(f"{few(missing)}: {what} are built, once for all runs")
        with scratch() as folder, watch(["FMUs"]) as watcher:
            build(missing, folder, kind, partial(watcher, "FMUs"))
            ready |= {file: (folder / file).read_bytes() for name in missing for file in file_names(name, kind)}
        keep_files(missing, kind, ready, say)
    elif kind.native and kind.target != "wasm":
        step_in_c()
    return copied(ready, cache_folder() / FMUS)


def is_shipped(name: str, kind: Kind) -> bool:
    """Return True if the installed wheel contains an FMU, or a module, of a kind."""
    folder = SHIPPED / "wasm" if kind.target == "wasm" else kind_folder(SHIPPED, kind.native, kind.fmi)
    return kind.native and (folder / file_names(name, kind)[0]).is_file()


def shipped_files(names: Collection[str], kind: Kind) -> dict[str, bytes]:
    """Return the files of the wheel; raise BuildError if they differ from those of the installed sources."""
    with scratch() as folder:
        if kind.target != "wasm":
            return {path.name: path.read_bytes() for path in take_native(names, SHIPPED, folder, kind.fmi)}
    for name in names:
        if old := stale(name, SHIPPED / "wasm" / f"{name}.wasm"):
            raise BuildError(old)
    return {file: (SHIPPED / "wasm" / file).read_bytes() for name in names for file in file_names(name, kind)}


def file_names(name: str, kind: Kind) -> tuple[str, ...]:
    return (f"{name}.wasm", f"{name}.xml") if kind.target == "wasm" else (f"{name}.fmu",)


def kept_files(name: str, kind: Kind) -> dict[str, bytes]:
    """Return the cached files of an FMU: all or none."""
    entries = [kept(fmu_key(name, kind), file) for file in file_names(name, kind)]
    try:
        return {file: entry.path.read_bytes() for file, entry in zip(file_names(name, kind), entries, strict=True)
                if entry is not None and None not in entries}
    except OSError:   # cleared by another process
        return {}


def is_kept(name: str, kind: Kind) -> bool:
    """Return True if the cache has an FMU of the present sources."""
    return kept(fmu_key(name, kind), f"{name}.fmu") is not None


def keep_files(names: Iterable[str], kind: Kind, contents: dict[str, bytes], say: Say) -> None:
    """Put files into the cache; report one sentence if it cannot be written."""
    try:
        for name in names:
            for file in file_names(name, kind):
                keep(fmu_key(name, kind), file, contents[file])
        lost = any(not kept_files(name, kind) for name in names)
    except OSError:
        lost = True
    if lost:
        say(uncacheable("what is built", "it is for this command alone"))


def fmu_key(name: str, kind: Kind) -> str:
    """Return the place in the cache: a digest of sources, tools and kind, and of an own stage's description and pages.
    """
    stage = known_stages().own_of(name)
    described = []
    if stage is not None:
        pages = stage.folder.glob("*/**/*.*")
        described = [to_text(stage.description), files_digest(stage.folder, pages)]
    return key_of(FMUS, dependencies(), tuple(kind), number_in(DATE), described)


def require_runnable(description: Path, say: Say) -> None:
    """Refuse a stage that cannot run, as `runnable` does, and report its warnings."""
    from maglev.user.consequences import stage  # linear models: scipy takes its time to load

    for warning in stage(description).warnings:
        say(f"{description}: {warning}")


MAKING = ("language", "fmi", "descriptions", "scenario")   # packages whose code makes FMUs


@cache
def dependencies() -> tuple[str, ...]:
    """Return the inputs that all FMUs depend on: sources, descriptions, versions of tools, this machine."""
    folders = [HERE / folder for folder in (*BLOCKS, *(f"maglev/{name}" for name in MAKING))]
    return (files_digest(HERE, (path for folder in folders for path in folder.rglob("*.*"))),
            *map(to_text, PACKAGED_STAGES.values()), *map(version_of, ("maglev-fmus", *TOOLS)),
            platform.system(), platform.machine())


def version_of(package: str) -> str:
    """Return the version of a package; empty text if it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
