"""C of the blocks of native FMUs of this installation, from which loops without FMI's calls are compiled.

The calls of a step go through FMI: a function for each, a table for each variable, checks. FMUs of this installation
carry their blocks as C, so that frequent runs can replace the calls with these blocks, compiled together.
"""

from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from string import Template
from typing import NamedTuple

from maglev.cosim.fmu import Fmu
from maglev.descriptions.own_fmus import definition, files_in, own_build
from maglev.files.cache import digest_at
from maglev.fmi.block_code import BLOCK, prefixed
from maglev.fmi.native_build import PREFIX, SOURCES
from maglev.user.blocks import Variables
from maglev.user.source import FmuFile

HERE = Path(__file__).parent   # with the C around the blocks
# Parts of blocks become part of their callers up to this size; an FMU's step takes no longer without it.
PARTS_INLINED = ("-mllvm", "-inline-threshold=1000")
EXPORT_FILE = "export.h"

INSTANCE = {"instance.h", "model.h"}   # headers of an instance


class Part(NamedTuple):
    """An FMU in the loop: its place among the instances, and its variables by their value references."""

    number: int
    variables: Variables

    @property
    def block(self) -> str:
        return f"block{self.number}"

    @property
    def header(self) -> str:
        """Name of the header with its C, whose names begin with the block's."""
        return f"{self.block}.h"

    @property
    def type(self) -> str:
        return f"{self.block}_Block"


def native_parts(fmus: Iterable[Fmu], written: Mapping[str, Variables] | None = None
                 ) -> tuple[dict[str, str], dict[int, Part]] | None:
    """C files of blocks by name, and FMUs by identity, where each is a native one of this installation, or written."""
    parts: dict[int, Part] = {}
    files: dict[str, str] = {PREFIX: "/* Everything is one translation unit: no name is shared. */\n",
                             EXPORT_FILE: filled_in(HERE / EXPORT_FILE)}
    for number, fmu in enumerate(fmus):
        if not isinstance(fmu.source, FmuFile):
            return None
        path = fmu.source.path
        build, variables = own_build(path), (written or {}).get(fmu.name)
        if build is not None and build.kind == "native":
            variables = definition(build.name).native_variables
        if variables is None or fmu.scales:
            return None
        parts[id(fmu)] = part = Part(number, variables)
        code, instance = block_files(path, digest_at(path), f"{part.block}_")
        files |= {**instance, part.header: code}
    return files, parts


@lru_cache(maxsize=16)
def block_files(path: Path, _sha256: str, prefix: str) -> tuple[str, dict[str, str]]:
    """C of the block in an FMU, with a prefix for its names, and the headers, by name, of its instances.

    Read once for each content of the file: every batch asks for them. Nothing may be changed in them.
    """
    carried = {name.removeprefix(SOURCES): data.decode("utf-8") for name, data in files_in(path).items()
               if name.startswith(SOURCES)}
    return prefixed(carried[BLOCK], prefix), {name: carried[name] for name in INSTANCE}


def filled_in(file: Path, **what: object) -> str:
    """Text of a file of C, with values instead of its `$names`."""
    return Template(file.read_text(encoding="utf-8")).substitute(what)


def indented(lines: Iterable[str], by: int) -> str:
    return "\n".join(" " * by + line for line in lines)
