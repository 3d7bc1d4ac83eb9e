"""Native FMUs of users' classes that this process has built, whose C can take the place of their calls."""

from collections.abc import Mapping
from pathlib import Path

from maglev.files.cache import digest_at
from maglev.fmi.definition import Variable

Variables = tuple[Variable, ...]   # of an FMU, by their value references

# By SHA-256 of a file that this process has built of a class, whose steps always end.
BUILT: dict[str, Variables] = {}


def built_blocks(files: Mapping[str, Path]) -> dict[str, Variables]:
    """Of FMUs by name, the variables of those that this process has built of users' classes."""
    built = {name: BUILT.get(digest_at(path)) for name, path in files.items()} if BUILT else {}
    return {name: variables for name, variables in built.items() if variables is not None}
