"""Blocks of native FMUs, as C that takes their place: names and variables. Of users' classes, those built here."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from fmi_export.definition import FmuDefinition, Variable
from maglev_files.cache import digest_at


class Block(NamedTuple):
    """Name of a block's struct, its header, and the FMU's variables by their value references."""

    struct: str
    header: str
    variables: tuple[Variable, ...]

    @classmethod
    def of(cls, definition: FmuDefinition) -> "Block":
        return cls(definition.block.__name__, f"{definition.block.__module__.rpartition('.')[2]}.h",
                   definition.native_variables)


# By SHA-256 of a file that this process has built of a class, whose steps always end, see `always_ends`.
BUILT: dict[str, Block] = {}


def built_blocks(files: Mapping[str, Path]) -> dict[str, Block]:
    """Of FMUs by name, the blocks of those that this process has built of users' classes."""
    built = {name: BUILT.get(digest_at(path)) for name, path in files.items()} if BUILT else {}
    return {name: block for name, block in built.items() if block is not None}
