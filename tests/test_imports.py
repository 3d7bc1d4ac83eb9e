"""Imports point down only: which package may know which other one."""

import ast
import re
import tomllib
from functools import cache
from graphlib import TopologicalSorter
from importlib.util import resolve_name
from pathlib import Path

import pytest

from maglev.files.packages import BLOCKS, PACKAGES
from maglev.fmi.native_build import EXTERNAL, PARTS, SHELLS

ROOT = Path(__file__).parents[1]

# The packages from the lowest to the highest: each knows some of those before it. CONTRIBUTING.md says what each is.
FLOORS = ("maglev.language", "maglev.files", "maglev.fmi", "pmlsm", "plant_fmu", "controller_fmu",
          "maglev.closed_loop", "maglev.descriptions", "maglev.linear", "maglev.user", "maglev.identification",
          "maglev.cosim", "maglev.scenario", "maglev.runs", "maglev.many", "maglev.pages", "maglev.analysis",
          "maglev.api", "maglev", "maglev.cli")

# A plant and a controller share the motor's description, never each other. The packages that run, check, pack and
# compare any FMU know no part of a stage.
APART = {("controller_fmu", "plant_fmu"), ("maglev.cosim", "pmlsm"), ("maglev.cosim", "plant_fmu"),
         ("maglev.cosim", "controller_fmu"), ("maglev.cosim", "maglev.linear")}

# Blocks are translated to C: only the modules that describe an FMU know what an FMU is.
DESCRIBES = re.compile(r"\w*variables|continuous|\w*drawings|block_diagrams|icons|\w*definitions?|places")

C_LAYER = ROOT / "maglev/fmi/c"
LOWEST = ("prefix", "model", "instance")   # headers that every C file of the layer may know


def sources(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


@cache
def imported_lines(path: Path) -> list[tuple[int, str]]:
    """Lines and names of the modules that a file imports: at the top, in functions, and by name as text."""
    package, found = ".".join(path.relative_to(ROOT).parent.parts), []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            module = resolve_name("." * node.level + (node.module or ""), package)
            found += [(node.lineno, f"{module}.{alias.name}" if module == "maglev" else module) for alias in node.names]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and "_fmu" in node.value:
            found.append((node.lineno, node.value))   # such as "plant_fmu.definition.plant" of the registry
    return found


def package_of(module: str) -> str:
    """Package of a module; "" of one that is not ours. Modules of maglev itself are of "maglev"."""
    parts = module.split(".")
    if parts[0] != "maglev":
        return parts[0] if parts[0] in PACKAGES else ""
    package = ".".join(parts[:2])
    return "maglev.cli" if parts[1:] == ["__main__"] else package if package in FLOORS else "maglev"


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)


def test_imports_point_down() -> None:
    """An order of the packages in which every arrow points down has no circle either."""
    wrong = []
    for path in (path for package in PACKAGES for path in sources(package)):
        package = package_of(module_of(path))
        for line, name in imported_lines(path):
            other = package_of(name) if re.fullmatch(r"[\w.]+", name) else ""
            up = other and other != package and FLOORS.index(other) > FLOORS.index(package) and name not in PACKAGES
            if up or (package, other) in APART:
                wrong.append(f"{path.relative_to(ROOT)}:{line}: {name}")
    assert not wrong


def test_the_master_reaches_nothing_that_writes_or_completes_a_stage() -> None:
    """Not through other modules either: whether an FMU is one of this project, names and sources of FMUs tell.

    Those come of the descriptions of this project's stages, which are read.
    """
    files = {module_of(path).removesuffix(".__init__"): path for path in sources("maglev")}
    reached, waiting = set(), [name for name in files if name.startswith("maglev.cosim.")]
    while waiting:
        if (name := waiting.pop()) not in reached:
            reached.add(name)
            waiting += [other for _, other in imported_lines(files[name]) if other in files]
    assert "maglev.descriptions.own_fmus" in reached
    others = ("maglev.descriptions.writer", "maglev.descriptions.data_sheet", "maglev.user.gain", "maglev.linear")
    assert not {name for name in reached if name.startswith(others)}


def test_modules_have_no_circles() -> None:
    """Not within a package either, types and what is imported in functions included."""
    files = {module_of(path): path for package in PACKAGES for path in sources(package)}
    TopologicalSorter({module: {name for _, name in imported_lines(path)} & files.keys() - {module}
                       for module, path in files.items()}).prepare()   # CycleError has their names


def included(name: str) -> list[str]:
    """Headers of the C layer that a file of it includes, by their stems."""
    return re.findall(r'^#include "(?!fmi\d)(\w+)\.h"', (C_LAYER / name).read_text(encoding="utf-8"), re.MULTILINE)


def test_c_files_point_down() -> None:
    """A part of the layer over a block knows those before it, the shells of FMI's versions know parts, none a shell."""
    files = {path.name for path in C_LAYER.iterdir()}
    shells = {"webassembly_host.c", *(name for shell in SHELLS.values() for name in shell.layer if name[:3] == "fmi")}
    assert files == {"model.h", "instance.h"} | {f"{part}.{ending}" for part in PARTS for ending in "ch"} | shells
    assert included("model.h") == ["prefix"] and set(included("instance.h")) == {"prefix", "model"}
    for n, part in enumerate(PARTS):
        assert set(included(f"{part}.h")) <= {*LOWEST, *PARTS[:n]}
        assert set(included(f"{part}.c")) <= {*LOWEST, *PARTS[:n + 1]}
        assert included(f"{part}.c")[0] == part
    assert all(set(included(name)) <= {*LOWEST, *PARTS} for name in shells)


def test_c_files_have_what_their_headers_declare() -> None:
    """So that an include tells who calls whom; from below only what a version of FMI words is asked of its shell."""
    texts = {path.name: path.read_text(encoding="utf-8") for path in C_LAYER.iterdir()}

    def defined(name: str) -> set[str]:
        return set(re.findall(r"^(?!static|typedef)\w[\w ]*[ *](\w+)\([^;{}]*\)\n\{", texts[name], re.MULTILINE))

    for part in PARTS:
        assert set(EXTERNAL.findall(texts[f"{part}.h"])) == defined(f"{part}.c"), part
    asked = {"tell", "phase_name", "real_type", "readable_phases"}
    assert set(EXTERNAL.findall(texts["instance.h"])) == asked
    assert asked <= defined("fmi2.c") and asked <= defined("fmi3.c")


def test_files_stay_small() -> None:
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for package in PACKAGES
             for path in sources(package)}
    assert {path: n for path, n in lines.items() if n > 500} == {}


@pytest.mark.parametrize("package", BLOCKS)
def test_blocks_know_no_fmu(package: str) -> None:
    wrong = [f"{path.relative_to(ROOT)}:{line}: {name}" for path in sources(package)
             if not DESCRIBES.fullmatch(path.stem)
             for line, name in imported_lines(path) if package_of(name).startswith("maglev")]
    assert not wrong


def test_every_package_is_here() -> None:
    """What is installed has no name that a user's own module could have."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folders = {file.parent.relative_to(ROOT) for name in PACKAGES for file in (ROOT / name).rglob("*.py")}
    assert all((ROOT / folder / "__init__.py").exists() for folder in folders)
    listed = set(project["tool"]["setuptools"]["packages"])
    assert listed == {".".join(folder.parts) for folder in folders} | {"maglev.stages", "maglev.scenarios"}
    assert set(FLOORS) == {".".join(folder.parts) for folder in folders}
    assert {name.split(".")[0] for name in listed} == set(PACKAGES)
