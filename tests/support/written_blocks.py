"""Blocks of the language that tests write to files."""

import linecache
import sys
from importlib.util import module_from_spec, spec_from_file_location
from itertools import count
from pathlib import Path
from typing import Any

NUMBERS = count()


def load_module(folder: Path, text: str, name: str = "tank.py") -> Any:
    """The module of a file with a text, under a name of its own."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    linecache.checkcache(str(path))
    spec = spec_from_file_location(f"written_{next(NUMBERS)}", path)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    sys.dont_write_bytecode, before = True, sys.dont_write_bytecode
    try:
        spec.loader.exec_module(module)
    finally:
        sys.dont_write_bytecode = before
    return module


def load_block(folder: Path, text: str, name: str) -> Any:
    """An instance of a class of a file with a text."""
    return getattr(load_module(folder, text), name)()
