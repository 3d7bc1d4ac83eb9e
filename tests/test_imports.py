"""Imports point down only: which package may know which other one."""

import re
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from maglev.files.packages import OURS
from maglev.fmi.native_build import EXTERNAL, PARTS, SHELLS
from tools.house_map import drawing, imported_lines, map_page, room_of

ROOT = Path(__file__).parents[1]

# What each package may import of the others. A plant and a controller share the motor's description, never each other.
# The estimators run on the controller's real-time computer: same clock, same observer; it samples the measurements.
BELOW: dict[str, set[str]] = {
    "pmlsm": {"maglev.fmi"},
    "maglev.files": set(),
    "maglev.fmi": {"maglev.files"},
    "plant_fmu": {"pmlsm", "maglev.fmi"},
    "controller_fmu": {"pmlsm", "maglev.fmi"},
    "controller_fmu": {"pmlsm", "controller_fmu", "maglev.fmi"},
    "controller_fmu": {"pmlsm", "controller_fmu", "maglev.fmi"},
    "maglev.descriptions": {"pmlsm", "plant_fmu", "controller_fmu", "controller_fmu", "maglev.fmi"},
    "maglev": {"pmlsm", "maglev.fmi", "maglev.files"}}

# The tool runs FMU files; only these rooms of it reach what is below the FMUs.
REACHES = {"maglev.identification": {"controller_fmu", "controller_fmu", "plant_fmu"},
           "maglev.linear": {"plant_fmu", "controller_fmu", "controller_fmu"},
           # An environment reads velocities by the controllers' observer.
           "maglev.gym": {"controller_fmu"},
           "maglev.user": {"controller_fmu"},
           # What currents lose is a matter of the plant's windings.
           "maglev.runs": {"plant_fmu"},
           # All of them are imported before anything that could be called the same.
           "maglev.files.packages": {"plant_fmu", "controller_fmu", "controller_fmu", "controller_fmu", "maglev.descriptions"},
           # A controller of the user's can be made of any part.
           "maglev.user": {"plant_fmu", "controller_fmu", "controller_fmu", "controller_fmu",
                                       "maglev.descriptions"}}
BLOCKS = ("plant_fmu", "controller_fmu", "controller_fmu", "controller_fmu", "maglev.descriptions")

# The rooms of the tool, from the lowest to the highest: each knows those before it.
ROOMS = ("errors", "packages", "arrays", "waves", "units", "processes", "copies", "parameter", "time_grid",
         "quantities", "tables", "toml_file", "shown_figure", "pictures", "rig", "stages", "linear",
         "own_stage", "identification", "user_controllers", "kinds", "own_fmus", "cosim", "schema", "catalogue", "gym",
         "pages", "maps", "live", "judging", "experiment", "analysis", "baselines", "fmu_experiments", "procedures",
         "report", "comparison", "studies", "stability", "tuning", "api", "microcontroller", "__init__", "cli",
         "__main__")

# Rooms that run, check, pack and compare anybody's FMU, and those that know what a stage is.
GENERIC = ("processes", "cosim", "baselines", "fmu_experiments")
OF_STAGES = ("rig", "stages", "rigs", "linear", "own_stage", "identification", "stability", "gym", "maps", "live")

# Blocks are translated to C: only the modules that describe an FMU know what an FMU is.
DESCRIBES = re.compile(r"\w*variables|continuous|drawings|definitions?|places")

PACKAGE = re.compile(rf"({'|'.join(BELOW)})(\.\w+)*")


C_LAYER = ROOT / "maglev/fmi/c"
LOWEST = ("prefix", "model", "instance")   # headers that every C file of the layer may know


def sources(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


@pytest.mark.parametrize("package", BELOW)
def test_imports_point_down(package: str) -> None:
    wrong = []
    for path in sources(package):
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        reached = {name for room, names in REACHES.items() if module.startswith(room) for name in names}
        # The table of the FMUs, and what writes blocks, names their modules as text.
        reached |= set(BLOCKS) if module.startswith(("maglev.descriptions.registry", "maglev.descriptions.")) else set()
        for line, name in imported_lines(path):
            if PACKAGE.fullmatch(name) and name.split(".")[0] not in {package} | BELOW[package] | reached:
                wrong.append(f"{path.relative_to(ROOT)}:{line}: {name}")
    assert sources(package)
    assert not wrong


def room_arrows() -> dict[tuple[str, str], list[str]]:
    """Imports from one room of the tool to another, with the places where they stand."""
    found: dict[tuple[str, str], list[str]] = {}
    for path in sources("maglev"):
        room = room_of(".".join(path.relative_to(ROOT).with_suffix("").parts))
        for line, name in imported_lines(path):
            if name.split(".")[0] == "maglev" and room_of(name) != room:
                found.setdefault((room, room_of(name)), []).append(f"{path.relative_to(ROOT)}:{line}")
    return found


def test_rooms_point_down() -> None:
    """An order of the rooms in which every arrow points down has no circle either."""
    arrows = room_arrows()
    assert {room for arrow in arrows for room in arrow} <= set(ROOMS)
    up = {arrow: places for arrow, places in arrows.items() if ROOMS.index(arrow[0]) <= ROOMS.index(arrow[1])}
    assert not up


@pytest.mark.parametrize("room", GENERIC)
def test_what_runs_any_fmu_knows_no_stage(room: str) -> None:
    """Nor a motor, a rig or a law; of this project it may ask whether an FMU is one of it (`own_fmus`)."""
    files = sources(f"maglev/{room}")
    assert files
    for path in files:
        for line, name in imported_lines(path):
            known = room_of(name) if name.startswith("maglev.") else name.split(".")[0]
            assert known not in (*BLOCKS, "pmlsm", *OF_STAGES), f"{path.relative_to(ROOT)}:{line}: {name}"


def test_the_master_reaches_nothing_that_writes_or_completes_a_stage() -> None:
    """Not through other modules either: whether an FMU is one of this project, names and sources of FMUs tell.

    Those come of the descriptions of this project's stages, which are read.
    """
    files = {".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
             for path in sources("maglev")}
    reached, waiting = set(), [name for name in files if name.startswith("maglev.cosim.")]
    while waiting:
        if (name := waiting.pop()) not in reached:
            reached.add(name)
            waiting += [other for _, other in imported_lines(files[name]) if other in files]
    assert "maglev.descriptions.own_fmus" in reached
    others = ("maglev.descriptions.writer", "maglev.descriptions.data_sheet", "maglev.user", "maglev.linear")
    assert not {name for name in reached if name.startswith(others)}


def test_modules_have_no_circles() -> None:
    """Not within a room either, types and what is imported in functions included."""
    files = {".".join(path.relative_to(ROOT).with_suffix("").parts): path for package in BELOW
             for path in sources(package)}
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
    """What is written from the description of a rig does not count."""
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for package in BELOW for path in sources(package)
             if not re.search(r"_\ddof(_fmu)?$", path.stem)}
    assert {path: n for path, n in lines.items() if n > 500} == {}


def test_the_map_is_that_of_the_imports() -> None:
    for name, made in (("map.svg", drawing()), ("map.md", map_page())):
        assert (ROOT / "docs" / name).read_text(encoding="utf-8") == made, "`python tools/house_map.py` draws it anew"


@pytest.mark.parametrize("package", BLOCKS)
def test_blocks_know_no_fmu(package: str) -> None:
    wrong = [f"{path.relative_to(ROOT)}:{line}: {name}" for path in sources(package)
             if not DESCRIBES.fullmatch(path.stem) and path.parent.name != "drawings"
             for line, name in imported_lines(path) if name.split(".")[0] == "maglev.fmi"]
    assert not wrong


def test_every_package_is_here() -> None:
    """What is installed has no name that a user's own module could have."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folders = {file.parent.relative_to(ROOT) for name in BELOW for file in (ROOT / name).rglob("*.py")}
    assert all((ROOT / folder / "__init__.py").exists() for folder in folders)
    listed = set(project["tool"]["setuptools"]["packages"])
    assert listed == {".".join(folder.parts) for folder in folders} | {"maglev.stages", "maglev.scenarios"}
    assert {name.split(".")[0] for name in listed} == set(BELOW) == set(OURS)
