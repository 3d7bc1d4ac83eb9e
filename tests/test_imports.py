"""Imports point down only: which package may know which other one."""

import ast
import re
import tomllib
from collections.abc import Iterator
from importlib.util import resolve_name
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

# What each package may import of the others. A plant and a controller share the motor's description, never each other.
BELOW: dict[str, set[str]] = {
    "messages": set(),
    "pmlsm": set(),
    "sampling": set(),
    "fmi_export": set(),
    "plant_fmu": {"pmlsm", "fmi_export"},
    "controller_fmu": {"pmlsm", "sampling", "fmi_export"},
    "estimator_fmu": {"pmlsm", "sampling", "fmi_export"},
    "identification": {"pmlsm", "sampling", "estimator_fmu", "messages"},
    "scenarios": {"identification", "messages", "fmi_export", "pmlsm", "sampling"}}

# scenarios runs FMU files; one module of it builds them from the blocks.
BUILDS = ROOT / "scenarios" / "catalogue.py"
BLOCKS = ("plant_fmu", "controller_fmu", "estimator_fmu")

# Blocks are translated to C: only the modules that describe an FMU know what an FMU is.
DESCRIBES = re.compile(r"variables|\w+_fmu|plant_\ddof")

PACKAGE = re.compile(rf"({'|'.join(BELOW)})(\.\w+)*")


def imported(path: Path) -> Iterator[tuple[int, str]]:
    """Lines and names of the modules that a file imports: at the top, in functions, and by name as text."""
    package = ".".join(path.relative_to(ROOT).parent.parts)
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.lineno, resolve_name("." * node.level + (node.module or ""), package)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and "_fmu" in node.value:
            # Such as "plant_fmu.plant_2dof" of import_module; the names of the other packages are plain words.
            yield node.lineno, node.value


def sources(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


@pytest.mark.parametrize("package", BELOW)
def test_imports_point_down(package: str) -> None:
    wrong = []
    for path in sources(package):
        allowed = {package} | BELOW[package] | (set(BLOCKS) if path == BUILDS else set())
        for line, name in imported(path):
            if PACKAGE.fullmatch(name) and name.split(".")[0] not in allowed:
                wrong.append(f"{path.relative_to(ROOT)}:{line}: {name}")
    assert sources(package)
    assert not wrong


@pytest.mark.parametrize("package", BLOCKS)
def test_blocks_know_no_fmu(package: str) -> None:
    wrong = [f"{path.relative_to(ROOT)}:{line}: {name}" for path in sources(package)
             if not DESCRIBES.fullmatch(path.stem)
             for line, name in imported(path) if name.split(".")[0] == "fmi_export"]
    assert not wrong


def test_every_package_is_here() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folders = {file.parent.relative_to(ROOT) for name in BELOW for file in (ROOT / name).rglob("*.py")}
    importable = {".".join(folder.parts) for folder in folders if (ROOT / folder / "__init__.py").exists()}
    assert set(project["tool"]["setuptools"]["packages"]) == importable
    assert {name.split(".")[0] for name in importable} == set(BELOW)
