"""Native FMUs from a release, which need no compiler, and the loops that step them on any platform."""

import zlib
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from zipfile import BadZipFile, ZipFile

from maglev.descriptions.own_fmus import built_here, definition, installed, kind_folder
from maglev.descriptions.registry import known_stages
from maglev.files.errors import BuildError, option
from maglev.files.whole_file import whole_files
from maglev.fmi.compiler import PLATFORMS, library
from maglev.fmi.native_build import host_platform
from maglev.scenario.catalogue import build_errors, build_systems, with_parts


def build_step_loops(folder: Path) -> None:
    """Compile that loop for every platform, into a folder for each with FMI 3.0's name of it."""
    from maglev.cosim.step_loop import LIBRARY, source

    for name, platform in PLATFORMS.items():
        path = folder / name / f"{Path(LIBRARY).stem}{platform.ending}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(library({"step_loop.c": source()}, path.stem, platform))


@build_errors()
def take_native(names: Iterable[str], given: Path, folder: Path, fmi: int = 2, clocked: bool = False) -> list[Path]:
    """Copy native FMUs from a release, and make systems of them; return their paths.

    `given` is the archive `…-native.zip` of a release, or a folder with its content. FMUs are in `native` and `fmi3`,
    those with a clock in `clocked`, and the loops that step them in `step_loop`. FMUs without a clock in `clocked` are
    those of `fmi3`. After an error the folder is unchanged. Raises BuildError if a file is missing, or differs from the
    one that this installation makes of its own sources.
    """
    from maglev.cosim.step_loop import LIBRARY, keep_loop, step_function

    names = list(names)
    loop = f"step_loop/{next(iter(host_platform(3)))}/{LIBRARY}"
    with whole_files(folder) as unfinished:
        for part in with_parts(names):
            kind = kind_folder(Path(), True, fmi, clocked and definition(part).sampled)
            file = f"{(kind / part).as_posix()}.fmu"
            path = unfinished / f"{part}.fmu"
            path.write_bytes(shipped_file(given, file))
            if not built_here(path):
                raise BuildError(f"{option('source', str(given))}: {file} was built from other sources, expected the "
                                 f"FMUs of the release maglev-fmus {installed().version}")
        content = shipped_file(given, loop)
        build_systems([name for name in names if name in known_stages().systems()], unfinished, unfinished, fmi)
        with suppress(OSError):   # no room in the cache: runs are stepped in Python, then
            kept = keep_loop(content)
            if step_function(kept) is None:
                kept.path.unlink()
                raise BuildError(f"{option('source', str(given))}: {loop} was built from other sources, expected that "
                                 f"of the release maglev-fmus {installed().version}")
        return [folder / path.name for path in sorted(unfinished.iterdir())]


def shipped_file(given: Path, name: str) -> bytes:
    """Return a file by its path in an archive or a folder; BuildError if it is not there."""
    try:
        if given.is_dir():
            return (given / name).read_bytes()
        with ZipFile(given) as archive:
            return archive.read(name)
    except (OSError, KeyError, BadZipFile, EOFError, zlib.error) as error:
        raise BuildError(f"{option('source', str(given))}: has no {name} ({error}), expected a release's archive of "
                         "native FMUs, or its unpacked folder") from error
