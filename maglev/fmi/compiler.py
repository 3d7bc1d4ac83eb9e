"""Libraries for several platforms from one machine, by zig's C compiler."""

import os
import struct
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from maglev.files.cache import is_private
from maglev.files.errors import lacking
from maglev.files.programs import output_of, python_environment
from maglev.files.scratch import scratch
from maglev.language.errors import ExportError

# No contraction of a product and a sum into one rounding: Python does not do it either. A square root is the
# processor's, which sets no errno. Without a pointer to its frame a function has one more register. Nothing but FMI's
# functions is visible, under their own names. Debug information has paths in it, which would make the bytes depend on
# the machine.
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fomit-frame-pointer", "-DBLOCKS_IN_ONE_UNIT",
         "-fvisibility=hidden", "-fno-sanitize=all", "-g0", "-s", "-DFMI2_OVERRIDE_FUNCTION_PREFIX",
         "-DFMI3_OVERRIDE_FUNCTION_PREFIX")

UNIT = "{}_in_one.c"   # a name of its own: zig locks its cache of a file by the file's name


class Platform(NamedTuple):
    """A platform: zig's targets (several make a universal binary), the file's ending, further flags."""

    targets: tuple[str, ...]
    ending: str
    flags: tuple[str, ...]


# By the names that FMI 3.0 has for them. Those of Linux are linked against the oldest C library that zig has for both
# processors; newer ones run it.
PLATFORMS = {
    "x86_64-linux": Platform(("x86_64-linux-gnu.2.17",), ".so", ("-shared", "-fPIC")),
    "aarch64-linux": Platform(("aarch64-linux-gnu.2.17",), ".so", ("-shared", "-fPIC")),
    "x86_64-windows": Platform(("x86_64-windows-gnu",), ".dll", ("-shared",)),
    "aarch64-windows": Platform(("aarch64-windows-gnu",), ".dll", ("-shared",)),
    "x86_64-darwin": Platform(("x86_64-macos.11.0",), ".dylib", ("-shared", "-fPIC")),
    "aarch64-darwin": Platform(("aarch64-macos.11.0",), ".dylib", ("-shared", "-fPIC"))}
MACOS = PLATFORMS["x86_64-darwin"]._replace(targets=("x86_64-macos.11.0", "aarch64-macos.11.0"))

# One module with the C library in it that asks its host for nothing: whoever reserves memory in it needs its malloc. It
# travels in pages: functions stay functions, which takes two thirds of the room.
WEBASSEMBLY = Platform(("wasm32-wasi",), ".wasm", (
    "-UBLOCKS_IN_ONE_UNIT", "-mexec-model=reactor", "-Wl,--export-dynamic", "-Wl,--export=malloc", "-Wl,--export=free"))

# Universal binaries of macOS: several libraries, each for one processor, behind a common header.
FAT_MAGIC = 0xCAFEBABE      # of the header, which is big-endian
MACH_MAGIC = 0xFEEDFACF     # of a 64-bit library, in its own byte order
ALIGNMENT = 14              # power of two, by which each library is placed: a page of arm64


def require_zig() -> None:
    """Raise ExportError if ziglang, an extra of this project, is not installed."""
    if missing := lacking("ziglang", "native", "a native FMU"):
        raise ExportError(missing)


def library(sources: Mapping[str, str], name: str, platform: Platform) -> bytes:
    """Library of C files by name, and their headers, for a platform; `name` is its file name's stem.

    They are compiled as one translation unit, so that calls are inlined between the step of a block, its parts and the
    functions of FMI above it, which are in different files. Inlining changes no operation, so that no bit differs.
    ExportError if the compiler refuses the sources.
    """
    with in_one_unit(sources, name) as root:
        made = []
        for target in platform.targets:
            output = root / target / f"{name}{platform.ending}"
            output.parent.mkdir()
            compiled(root, [*FLAGS, *platform.flags, "-target", target, "-o",
                            str(output.relative_to(root)), UNIT.format(name)])
            made.append(output.read_bytes())
    return made[0] if len(made) == 1 else universal(made)


class Libraries:
    """How the libraries of FMUs are made."""

    def made(self, sources: Mapping[str, str], name: str, platform: Platform) -> bytes:
        """Return a library; see `library`."""
        return library(sources, name, platform)


def universal(libraries: Sequence[bytes]) -> bytes:
    """Universal binary of 64-bit Mach-O libraries, little-endian."""
    header = struct.pack(">II", FAT_MAGIC, len(libraries))
    result = bytearray(1 << ALIGNMENT)   # in which the header has its place
    for library in libraries:
        magic, processor, variant = struct.unpack_from("<III", library)
        if magic != MACH_MAGIC:
            raise ValueError(f"library begins with {magic:#x}, expected a 64-bit Mach-O library, {MACH_MAGIC:#x}")
        result += bytes(-len(result) % (1 << ALIGNMENT))
        header += struct.pack(">IIIII", processor, variant, len(result), len(library), ALIGNMENT)
        result += library
    result[:len(header)] = header
    return bytes(result)


@contextmanager
def in_one_unit(sources: Mapping[str, str], name: str) -> Iterator[Path]:
    """Folder with C files, and with one that includes all of them but headers; ExportError without a compiler."""
    require_zig()
    with scratch() as root:
        for file, text in sources.items():
            (root / file).write_text(text, encoding="utf-8", newline="\n")
        unit = "".join(f'#include "{file}"\n' for file in sorted(sources) if file.endswith(".c"))
        (root / UNIT.format(name)).write_text(unit, encoding="utf-8", newline="\n")
        yield root


def kept_at_home() -> bool:
    """Return True if zig can keep compiled C libraries in this user's home, which not every service has."""
    home = os.environ.get("XDG_CACHE_HOME") or os.environ.get("HOME")
    if not home:
        return False
    folder = Path(home).absolute() / ("zig" if os.environ.get("XDG_CACHE_HOME") else ".cache/zig")
    return os.access(next(place for place in (folder, *folder.parents) if place.exists()), os.W_OK)


def compiled(root: Path, arguments: list[str]) -> None:
    place = {}
    if not kept_at_home():
        shared = Path(tempfile.gettempdir()) / "maglev_zig"
        shared.mkdir(mode=0o700, exist_ok=True)
        place["ZIG_GLOBAL_CACHE_DIR"] = str(shared if is_private(shared) else root / "zig")   # of another user
    code, printed = output_of([sys.executable, "-m", "ziglang", "cc", *arguments], root,
                              {**place, **python_environment(), "SOURCE_DATE_EPOCH": "0"})
    if code != 0:
        raise ExportError(f"the C compiler refuses the sources: {' '.join(printed.split())[-1000:]}")
