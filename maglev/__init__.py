"""Magnetically levitated stages as FMUs: build the FMUs, run the scenarios, judge, compare.

>>> import maglev
>>> run = maglev.run("3dof-smooth-nonlinear")
>>> gap = run["plant.y.position"]        # numpy, SI

Each function does the same as the command of its name.
"""

import ast
from importlib import import_module
from pathlib import Path
from typing import Any

from maglev.files.packages import require_own_packages
from maglev.language.sources import parsed

# Modules of the public names, from the file in which type checkers read them. Whoever needs one function does not wait
# for the imports of all.
MODULES = dict(sorted((name.name, str(statement.module))
                      for statement in parsed(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")).body
                      if isinstance(statement, ast.ImportFrom) for name in statement.names))
__all__ = list(MODULES)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("maglev-fmus")
    if name not in MODULES:
        raise AttributeError(f"module 'maglev' has no attribute {name!r}")
    require_own_packages()
    return getattr(import_module(MODULES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)   # what is for users, and not what their imports have brought in
