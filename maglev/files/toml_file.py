"""TOML files of users, read with one-line errors."""

import tomllib
from pathlib import Path
from typing import Any

from maglev.files.errors import ScenarioError, in_one_line, key_path, nearest_file, shortened, visible
from maglev.files.regular_file import regular

DEEPEST = 50   # tables or lists in each other
NESTED = "TOML syntax: tables or lists are nested too deeply, expected fewer levels"


def toml_text(path: Path) -> str:
    """Text of a file, without a byte-order mark; ScenarioError if it cannot be read, or is no UTF-8 text."""
    try:
        return regular(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be read: {error.strerror}{nearest_file(path, '.toml')}") from None
    except UnicodeDecodeError:
        raise ScenarioError(f"{path}: cannot be read: expected UTF-8 text") from None


def read_toml(path: Path, text: str | None = None) -> dict[str, Any]:
    """Read a TOML file, or its text; ScenarioError as in `text_of`, or if it is no TOML, or has control characters."""
    try:
        table = tomllib.loads(toml_text(path) if text is None else text)
    except ValueError as error:   # of TOML, or of a number with thousands of digits
        raise ScenarioError(f"{path}: TOML syntax: {in_one_line(error)}") from None
    except RecursionError:
        raise ScenarioError(f"{path}: {NESTED}") from None
    require_showable(path, table)
    return table


def require_showable(path: Path, value: object, keys: tuple[str | int, ...] = ()) -> None:
    """Raise if a message could not show a value: control characters, and tables in tables without end."""
    if len(keys) > DEEPEST:
        raise ScenarioError(f"{path}: {NESTED}")
    if isinstance(value, str) and visible(value) != value:
        raise ScenarioError(f"{path}: {key_path(keys)} = {shortened(value)}: expected text without control characters")
    if isinstance(value, dict):
        for key in value:
            require_showable(path, key, (*keys, visible(key)))
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, entry in entries:
        require_showable(path, entry, (*keys, key))
