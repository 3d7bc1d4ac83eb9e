"""Native FMUs of users' classes that this process has built, whose C can take the place of their calls."""

from collections.abc import Mapping
from pathlib import Path

from maglev.files.cache import digest_at
from maglev.files.session import SESSION
from maglev.fmi.definition import FmuDefinition, Variable

Variables = tuple[Variable, ...]   # of an FMU, by their value references


class BuiltClasses:
    """Definitions of users' classes whose steps always end, by SHA-256 of the files that this process has built."""

    def __init__(self) -> None:
        self.definitions: dict[str, FmuDefinition] = {}


def built_definition(path: Path) -> FmuDefinition | None:
    """Definition of an FMU that this process has built of a user's class."""
    definitions = SESSION.get(BuiltClasses).definitions
    return definitions.get(digest_at(path)) if definitions else None


def built_blocks(files: Mapping[str, Path]) -> dict[str, Variables]:
    """Variables by the name of the FMU, for users' classes that this process has built."""
    built = {name: built_definition(path) for name, path in files.items()}
    return {name: own.native_variables for name, own in built.items() if own is not None}
