"""The blocks stay in the subset of Python that pyccel translates to C."""

import ast
import re
from pathlib import Path

import pytest

from fmi_export.native.translation import translate_modules
from fmi_export.sources import carried_modules
from maglev.own_fmus import DEFINITIONS, definition
from maglev.packages import PACKAGES

ROOT = Path(__file__).parents[1]
# Of `math` blocks use what is exact on every machine: the standard says all bits of a square root, and the rest are no
# computations. Everything else is another library's last bit elsewhere; pmlsm/elementary has it.
EXACT = {"sqrt", "fabs", "pi", "inf", "nan"}
TEMPLATES = ROOT / "maglev" / "rig" / "templates"   # blocks of a stage of the user's, and what a controller begins with
FORBIDDEN_CALLS = {"min", "max", "abs", "round", "pow", "sum", "divmod", "dict", "list", "set", "print",
                   "open", "getattr", "setattr"}
FORBIDDEN_SYNTAX = (ast.Raise, ast.Try, ast.TryStar, ast.With, ast.Assert, ast.Lambda, ast.Yield,
                    ast.YieldFrom, ast.Dict, ast.List, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp,
                    ast.GeneratorExp, ast.JoinedStr, ast.Pow, ast.FloorDiv, ast.Mod)


def imports(path: Path) -> set[str]:
    """Modules that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            found.add(node.module or "")
        elif isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
    return found


def block_modules() -> dict[str, Path]:
    """Modules that import nothing but math and each other, and define something to run: dependencies first."""
    paths = {".".join(path.relative_to(ROOT).with_suffix("").parts): path for package in PACKAGES
             for path in sorted((ROOT / package).rglob("*.py")) if path.stem not in ("__init__", "drawings")}
    needed = {name: imports(path) for name, path in paths.items()}
    ordered: dict[str, Path] = {}
    while True:
        ready = {name: path for name, path in paths.items()
                 if name not in ordered and needed[name] <= {"math", *ordered}}
        if not ready:
            return ordered
        ordered.update(ready)


BLOCKS = block_modules()


def test_blocks_are_found() -> None:
    """What becomes an FMU, and with it all that it imports; another import would drop a module silently."""
    assert {definition(name).block.__module__ for name in DEFINITIONS} <= set(BLOCKS)


def test_module_names_are_unique_across_packages() -> None:
    """C prefixes and includes are flat."""
    names = [name.rpartition(".")[2] for name in BLOCKS]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("name", DEFINITIONS)
def test_names_in_an_fmu_are_unique(name: str) -> None:
    """So are those of functions and constants in C."""
    defined: dict[str, str] = {}
    for module, text in carried_modules(definition(name).block.__module__, PACKAGES).items():
        for node in ast.parse(text).body:
            names = [node.name] if isinstance(node, (ast.ClassDef, ast.FunctionDef)) else [
                target.id for target in getattr(node, "targets", []) if isinstance(target, ast.Name)]
            for each in names:
                assert defined.setdefault(each, module) == module, each


@pytest.mark.parametrize("name", BLOCKS)
def test_only_what_c_needs_no_library_for(name: str) -> None:
    for node in ast.walk(ast.parse(BLOCKS[name].read_text(encoding="utf-8"))):
        where = f"{name}:{getattr(node, 'lineno', 0)}"
        assert not isinstance(node, FORBIDDEN_SYNTAX), where
        assert not (isinstance(node, ast.ClassDef) and (node.bases or node.decorator_list)), where
        if isinstance(node, ast.ImportFrom) and node.module == "math":
            assert {alias.name for alias in node.names} <= EXACT, where
        assert not (isinstance(node, ast.Import) and any(alias.name == "math" for alias in node.names)), where
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in FORBIDDEN_CALLS, where
        if isinstance(node, ast.Compare):
            # pyccel takes `dt != self.dt` for a comparison of dt with itself, and leaves out what follows.
            names = [getattr(side, "attr", getattr(side, "id", None)) for side in (node.left, *node.comparators)]
            assert len({name for name in names if name}) == sum(bool(name) for name in names), where


def from_math(text: str) -> set[str]:
    """Names that a text, Python or a template of it, takes from `math`, or `math` itself."""
    lines = re.findall(r"^\s*from math import (\([^)]*\)|.*)", text, re.MULTILINE)
    whole = re.findall(r"^\s*import (?:.*\b)?(math)\b", text, re.MULTILINE)
    return {*whole, *(name for line in lines for name in re.findall(r"[\w*]+", line))}


def test_blocks_take_from_math_what_is_exact_alone() -> None:
    """And all of it: each is allowed because it is needed."""
    assert set().union(*(from_math(path.read_text(encoding="utf-8")) for path in BLOCKS.values())) == EXACT


def test_templates_of_blocks_take_no_more() -> None:
    paths = [path for path in TEMPLATES.rglob("*.j2") if ".py" in path.suffixes or path.parent.name == "parts"]
    assert len(paths) > 30
    for path in paths:
        text = path.read_text(encoding="utf-8")
        assert from_math(text) <= {*EXACT, "isfinite"}, path.name   # of what a class of a user's has computed
        assert not re.search(r"^\s*(?:from|import) (?:numpy|scipy|cmath|statistics)\b", text, re.MULTILINE), path.name


@pytest.mark.parametrize(("text", "names"), [
    ("from math import pi, sin", {"pi", "sin"}), ("from math import (\n    sqrt,\n    exp,\n)", {"sqrt", "exp"}),
    ("import math", {"math"}), ("import os, math as m", {"math"}), ("    from math import *", {"*"}),
    ("{% if a %}\nfrom math import tanh\n{% endif %}", {"tanh"}), ("from maglev import math", set())])
def test_what_is_taken_from_math_is_found(text: str, names: set[str]) -> None:
    assert from_math(text) == names


@pytest.mark.usefixtures("slow")
def test_pyccel_translates_every_block() -> None:
    """Also those that no FMU is made of yet; the others have been translated for the native FMUs of the tests."""
    pytest.importorskip("pyccel", reason="the extra `native` is not installed")
    of_fmus = {module for name in DEFINITIONS
               for module in carried_modules(definition(name).block.__module__, PACKAGES)}
    for name in BLOCKS.keys() - of_fmus:
        assert f"{name.rpartition('.')[2]}.c" in translate_modules(carried_modules(name, PACKAGES))
