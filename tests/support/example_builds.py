"""The examples, and what it takes to build them."""

import importlib.util
import shutil
import sys
from pathlib import Path
from types import ModuleType

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


def script(path: Path) -> ModuleType:
    """A script as a module."""
    specification = importlib.util.spec_from_file_location(f"example_{path.parent.name}", path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def require_compiler() -> list[str]:
    """Command of a C compiler; skip where there is none."""
    found = shutil.which("cc")
    if found is None and importlib.util.find_spec("ziglang") is None:
        pytest.skip("there is no C compiler: neither cc nor the package ziglang")
    return [found] if found is not None else [sys.executable, "-m", "ziglang", "cc"]
