"""The FMUs that this project builds."""

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from difflib import get_close_matches
from importlib import import_module
from importlib.metadata import distribution
from pathlib import Path

from fmi_export.build import build_fmu
from fmi_export.container import Container, build_container
from fmi_export.definition import FmuDefinition
from fmi_export.native import build_native_fmu
from scenarios.processes import processors
from scenarios.scenario import load_scenario

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

# Controller and plant as one FMU: the loop of a scenario, whose start values are those that the FMUs have anyway.
CONTAINERS = {"ClosedLoop2DOF": "2dof-setpoints", "ClosedLoop3DOF": "3dof-setpoints-improved"}


def definition(name: str) -> FmuDefinition:
    """Definition of an FMU by its name; ValueError with the nearest name if there is none."""
    if name in CONTAINERS:
        raise ValueError(f"{name} is made of native FMUs, expected --native with it")
    if name not in DEFINITIONS:
        nearest = get_close_matches(name, DEFINITIONS, 1, 0.0)[0]
        raise ValueError(f"there is no FMU {name}, expected one of {', '.join(DEFINITIONS)}; nearest is {nearest}")
    module, attribute = DEFINITIONS[name]
    found: FmuDefinition = getattr(import_module(module), attribute)
    return found


def build(names: Iterable[str], folder: Path) -> list[Path]:
    """Build FMUs that run in the importer's Python into a folder; returns their paths."""
    chosen = [(definition(name), *DEFINITIONS[name]) for name in names]
    version, licence = project()
    return [build_fmu(*item, version=version, licence=licence, packages=PACKAGES, destination=folder)
            for item in chosen]


def build_native(names: Iterable[str], folder: Path, host_only: bool = False) -> list[Path]:
    """Build FMUs that need no Python into a folder; returns their paths.

    Errors and `host_only` as of `build_native_fmu`.
    """
    chosen = [definition(name) for name in names]
    version, licence = project()
    # Most of the time goes to the compiler, in processes of its own.
    with ThreadPoolExecutor(processors()) as pool:
        return list(pool.map(
            lambda each: build_native_fmu(each, version, licence, PACKAGES, folder, host_only), chosen))


def build_containers(names: Iterable[str], natives: Path, folder: Path) -> list[Path]:
    """Build containers into a folder, of the native FMUs in the folder `natives`; returns their paths.

    Errors as of `build_container`.
    """
    version, licence = project()
    return [build_container(container(name), natives, version, licence, folder) for name in names]


def container(name: str) -> Container:
    """Container by its name: the FMUs, order, connections, step and stop time of its scenario."""
    scenario = load_scenario(CONTAINERS[name])
    models = {part: fmu.model or "" for part, fmu in scenario.fmus.items()}
    description = f"Closed loop of {models['plant']} and {models['controller']}, stepped in sequence, controller first"
    return Container(name, description, models, tuple(scenario.connections), scenario.step, scenario.stop_time)


def project() -> tuple[str, str]:
    """Version and licence text of this project."""
    installed = distribution("maglev-fmus")
    return installed.version, next(path.read_text() for path in installed.files or [] if path.name == "LICENSE")
