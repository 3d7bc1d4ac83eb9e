"""All that is written of a rig: its description as Python, its blocks, and their equations."""

from pathlib import Path

from maglev.rig.text import fitted
from maglev.rig.writer import TEMPLATES, render
from pmlsm.rig import Rig

PLATFORM = "controller_fmu/platform_{}.py"   # of a rig whose platform tilts

# By path, in which {} is the name of the rig. Each has a template, some a second one where the platform tilts.
MODULES = (
    "pmlsm/rig_{}.py",
    "plant_fmu/stage_{}.py",
    PLATFORM,
    "controller_fmu/regulator_{}.py",
    "controller_fmu/pid_{}.py",
    "controller_fmu/commutation_{}.py",
    "estimator_fmu/estimator_{}.py",
    "estimator_fmu/adaptive_regulator_{}.py",
    "measurement_fmu/measurement_{}.py",
    "closed_loop_fmu/closed_loop_{}.py",
    "closed_loop_fmu/adaptive_loop_{}.py")

# Equations, which are the same for all rigs whose platform tilts.
PAGES = (
    "plant_fmu/documentation/stage_{}.html",
    "controller_fmu/documentation/linearisation_{}.html",
    "controller_fmu/documentation/setpoint_{}.html",
    "estimator_fmu/documentation/rows_{}.html")


def paths(rig: Rig) -> tuple[str, ...]:
    """Paths of what is written of a rig."""
    return MODULES if rig.rotations else (*(path for path in MODULES if path != PLATFORM), *PAGES)


def template(path: str, tilting: bool) -> str:
    """Template of a module, by its path; of what is written for users too."""
    own = path.replace("{}", "tilting") + ".j2"
    return own if tilting and (TEMPLATES / own).is_file() else path.replace("_{}", "") + ".j2"


def module(path: str, rig: Rig) -> str:
    """Text of a module of a rig, by its path."""
    text = render(template(path, bool(rig.rotations)), rig)
    return fitted(text) if path.endswith(".py") else text


def written_class(kind: str, rig: Rig, name: str, file: str) -> str:
    """Text of a "controller" or a "plant" for a user of a rig to begin with: a class of a name, in a file."""
    return fitted(render(template(f"new/{kind}_{{}}.py", bool(rig.rotations)), rig, name=name, file=file))


def written(rig: Rig) -> dict[str, str]:
    """Text of every module of a rig, by its path from the folder of the packages."""
    return {path.format(rig.name): module(path, rig) for path in paths(rig)}


def write(rig: Rig, root: Path) -> None:
    """Write the modules of a rig below a folder that holds the packages."""
    for path, text in written(rig).items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text, encoding="utf-8")
