"""TOML files of users, read with one-line errors."""

import tomllib
from pathlib import Path
from typing import Any

from maglev.errors import ScenarioError, in_one_line, nearest_file


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file; a byte-order mark at its start is no part of it.

    Raises
    ------
    ScenarioError
        If it cannot be read, is no UTF-8 text, or no TOML.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be read: {error.strerror}{nearest_file(path)}") from None
    except UnicodeDecodeError:
        raise ScenarioError(f"{path}: cannot be read: expected UTF-8 text") from None
    except ValueError as error:   # of TOML, or of a number with thousands of digits
        raise ScenarioError(f"{path}: TOML syntax: {in_one_line(error)}") from None
    except RecursionError:
        raise ScenarioError(f"{path}: TOML syntax: tables or lists nested too deeply, expected some levels") from None
