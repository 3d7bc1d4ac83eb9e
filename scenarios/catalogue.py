"""The FMUs that this project builds."""

from collections.abc import Iterable
from difflib import get_close_matches
from importlib import import_module
from importlib.metadata import distribution
from pathlib import Path

from fmi_export.build import build_fmu
from fmi_export.definition import FmuDefinition

PACKAGES = ("pmlsm", "plant_fmu", "controller_fmu")

DEFINITIONS = {
    "Plant2DOF": ("plant_fmu.plant_2dof", "PLANT_2DOF"),
    "Plant3DOF": ("plant_fmu.plant_3dof", "PLANT_3DOF"),
    "Regulator2DOF": ("controller_fmu.regulator_2dof_fmu", "REGULATOR_2DOF"),
    "Regulator3DOF": ("controller_fmu.regulator_3dof_fmu", "REGULATOR_3DOF"),
    "LinearRegulator2DOF": ("controller_fmu.regulator_2dof_fmu", "LINEAR_REGULATOR_2DOF"),
    "LinearRegulator3DOF": ("controller_fmu.regulator_3dof_fmu", "LINEAR_REGULATOR_3DOF"),
    "ScheduledRegulator3DOF": ("controller_fmu.regulator_3dof_fmu", "SCHEDULED_REGULATOR_3DOF"),
    "PID2DOF": ("controller_fmu.pid_2dof_fmu", "PID_2DOF"),
    "PID3DOF": ("controller_fmu.pid_3dof_fmu", "PID_3DOF"),
}


def definition(name: str) -> FmuDefinition:
    """Definition of an FMU by its name; ValueError with the nearest name if there is none."""
    if name not in DEFINITIONS:
        nearest = get_close_matches(name, DEFINITIONS, 1, 0.0)[0]
        raise ValueError(f"there is no FMU {name}, expected one of {', '.join(DEFINITIONS)}; nearest is {nearest}")
    module, attribute = DEFINITIONS[name]
    found: FmuDefinition = getattr(import_module(module), attribute)
    return found


def build(names: Iterable[str], folder: Path) -> list[Path]:
    """Build FMUs into a folder; returns their paths."""
    project = distribution("maglev-fmus")
    licence = next(path.read_text() for path in project.files or [] if path.name == "LICENSE")
    chosen = [(definition(name), *DEFINITIONS[name]) for name in names]
    return [build_fmu(*item, version=project.version, licence=licence, packages=PACKAGES, destination=folder)
            for item in chosen]
