"""Native FMUs of users' classes that this process has built, whose C can take the place of their calls."""

from collections.abc import Mapping
from pathlib import Path

from maglev.files.cache import digest_at
from maglev.fmi.definition import FmuDefinition, Variable

Variables = tuple[Variable, ...]   # of an FMU, by their value references

# By SHA-256 of a file that this process has built of a class, whose steps always end.
BUILT: dict[str, FmuDefinition] = {}


def built_definition(path: Path) -> FmuDefinition | None:
    """Definition of an FMU that this process has built of a user's class."""
    return BUILT.get(digest_at(path)) if BUILT else None


def built_blocks(files: Mapping[str, Path]) -> dict[str, Variables]:
    """Variables by the name of the FMU, for users' classes that this process has built."""
    built = {name: built_definition(path) for name, path in files.items()}
    return {name: own.native_variables for name, own in built.items() if own is not None}
