"""The C of a controller for a microcontroller, and its executable for an emulated Cortex-M7, linked by zig."""

import struct
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from maglev.cosim.fmi_versions import OWN_TOOL
from maglev.descriptions.own_fmus import definition
from maglev.files.errors import BuildError
from maglev.files.packages import IN_FMUS
from maglev.fmi.compiler import compiled, require_zig
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.freestanding import freestanding
from maglev.language.errors import ExportError
from maglev.user.build import Buildable, buildable
from maglev.user.source import PythonFile

# A Cortex-M7 with double precision, and the options that give the bits of the FMU. Each function has a section, so that
# the linker omits unused functions.
FLAGS = ("-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m7+fp_armv8d16", "-std=c99", "-O2", "-ffreestanding",
         "-ffp-contract=off", "-fno-math-errno", "-fno-sanitize=all", "-fno-unwind-tables",
         "-fno-asynchronous-unwind-tables", "-ffunction-sections", "-g0", "-I.", "-Iqemu")
BOARD = "qemu/board_qemu.c"
SCRIPT = "qemu/mps2_an500.ld"


def generated(controller: str | Path | PythonFile) -> tuple[FmuDefinition, dict[str, str]]:
    """A controller, by the name of an FMU or in a Python file, and its freestanding C: files by name.

    MaglevError if there is none, or it is not what C can have, with file and line.
    """
    with buildable(controller, native=True) if isinstance(controller, PythonFile) else nullcontext(
            Buildable(definition(str(controller)), {})) as built:
        described = built.definition
        if not described.sampled:
            raise BuildError(f"{controller}: has no sample_time, expected a controller, or another block that samples")
        try:
            return described, freestanding(described, IN_FMUS, f"{OWN_TOOL} {version('maglev-fmus')}")
        except ExportError as error:
            raise BuildError(f"{controller}: {error}") from None


@dataclass(frozen=True)
class Image:
    """An executable, and how much of it is the controller with the example over it: bytes of flash and of RAM.

    The board of the emulator is not counted; nor is the stack, which only a run shows.
    """

    path: Path
    flash: int
    ram: int
    compiler: str


def linked(name: str, files: Mapping[str, str], folder: Path) -> Image:
    """Compile and link the files of a controller in a folder; ExportError without ziglang, or where it refuses them."""
    require_zig()
    for file, text in files.items():
        place = folder / file
        place.parent.mkdir(exist_ok=True)
        place.write_text(text, encoding="utf-8", newline="\n")
    compiled(folder, [*FLAGS, "-Wl,--gc-sections", "-Wl,--entry=reset", f"-Wl,--wrap={name}_start",
                      f"-Wl,--wrap={name}_sample", "-T", SCRIPT, f"{name}.c", "main.c", BOARD, "-o", f"{name}.elf"])
    path = folder / f"{name}.elf"
    sizes = sections(path.read_bytes())
    return Image(path, sum(sizes.get(section, 0) for section in (".vectors", ".text", ".data")),
                 sum(sizes.get(section, 0) for section in (".data", ".bss")), f"zig {version('ziglang')} -O2")


def sections(elf: bytes) -> dict[str, int]:
    """Sizes of the sections of an executable in the 32-bit ELF format, bytes, by name."""
    table, = struct.unpack_from("<I", elf, 32)
    size, count, names = struct.unpack_from("<HHH", elf, 46)
    headers = [struct.unpack_from("<10I", elf, table + size * k) for k in range(count)]
    text = headers[names][4]
    return {elf[text + header[0]:elf.index(b"\0", text + header[0])].decode("ascii"): header[5] for header in headers}
