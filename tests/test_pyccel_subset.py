"""The blocks stay in the subset of Python that pyccel translates to C."""

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("pmlsm", "plant_fmu", "controller_fmu")
FORBIDDEN_CALLS = {"min", "max", "abs", "round", "dict", "list", "set", "print", "open", "getattr", "setattr"}


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
    paths = {f"{path.parent.name}.{path.stem}": path for package in PACKAGES
             for path in sorted((ROOT / package).glob("*.py")) if path.stem not in ("__init__", "icon")}
    ordered: dict[str, Path] = {}
    while True:
        ready = {name: path for name, path in paths.items()
                 if name not in ordered and imports(path) <= {"math", *ordered}}
        if not ready:
            return ordered
        ordered.update(ready)


BLOCKS = block_modules()


def test_blocks_are_found() -> None:
    assert {"plant_fmu.stage_2dof", "plant_fmu.stage_3dof", "controller_fmu.regulator_2dof",
            "controller_fmu.regulator_3dof"} <= set(BLOCKS)


def test_module_names_are_unique_across_packages() -> None:
    """C prefixes and includes are flat."""
    names = [name.rpartition(".")[2] for name in BLOCKS]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("name", BLOCKS)
def test_only_what_c_needs_no_library_for(name: str) -> None:
    for node in ast.walk(ast.parse(BLOCKS[name].read_text(encoding="utf-8"))):
        where = f"{name}:{getattr(node, 'lineno', 0)}"
        assert not isinstance(node, (ast.Raise, ast.Try, ast.Lambda, ast.Dict, ast.List, ast.ListComp, ast.With)), where
        assert not isinstance(node, (ast.Pow, ast.FloorDiv, ast.Mod)), where
        assert not (isinstance(node, ast.ClassDef) and (node.bases or node.decorator_list)), where
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in FORBIDDEN_CALLS, where


def test_pyccel_translates_every_block(tmp_path: Path) -> None:
    pytest.importorskip("pyccel", reason="the extra `native` is not installed")
    for package in PACKAGES:
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pyc*"))
    pyccel = Path(sys.executable).parent / "pyccel"
    # pyccel names its output folder after the worker of a parallel test run.
    environment = {name: value for name, value in os.environ.items() if name != "PYTEST_XDIST_WORKER"}
    for name in BLOCKS:
        package, _, module = name.partition(".")
        done = subprocess.run([str(pyccel), "-t", "--language", "c", f"{package}/{module}.py"], cwd=tmp_path,
                              env={**environment, "PYTHONPATH": str(tmp_path)}, capture_output=True, text=True)
        assert done.returncode == 0, f"{name}\n{done.stdout}{done.stderr}"
        assert (tmp_path / package / "__pyccel__" / f"{module}.c").is_file(), name
