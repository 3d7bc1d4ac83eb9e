"""Options that the functions share: what is put in place of a plan's FMUs, values and step."""

from collections.abc import Sequence
from pathlib import Path
from typing import TypedDict

from maglev.cosim.open import read_description
from maglev.cosim.order import Order
from maglev.cosim.other_process.run import TIMEOUT
from maglev.cosim.port_map import PortMap, read_port_maps
from maglev.errors import ScenarioError, UnknownName, nearest
from maglev.experiment.ports.replacement import Replacement
from maglev.experiment.preparation import Experiment, know_stage_of
from maglev.experiment.selection import prepare_all
from maglev.identification.model_file import model_settings
from maglev.own_fmus import kind_folder, places
from maglev.schema.run_plan import RunPlan, StartValue
from maglev.schema.settings import Settings, start_values
from maglev.units import positive_time
from maglev.user_controllers.source import copy_of, is_written, path_of

Value = float | int | bool | str


class FlightOptions(TypedDict, total=False):
    """How runs differ from their plans; see `maglev.run`."""

    set: Settings
    model: str | Path | None
    plant: str | Path | type | None
    controller: str | Path | type | None
    ports: str | Path | None
    step: float | str | None
    order: Order
    fmus: str | Path
    native: bool
    fmi: int
    timeout: float | str
    keep_settings: bool


def experiments_of(plans: Sequence[RunPlan], options: FlightOptions) -> list[Experiment]:
    """Runs made ready; MaglevError if an option or a plan cannot be used."""
    for name in options.keys() - FlightOptions.__annotations__.keys():
        raise ScenarioError(f"{name}: unknown option, nearest is {nearest(name, FlightOptions.__annotations__)}")
    for plan in plans:
        know_stage_of(plan)
    replaced, timeout = replacements(options), timeout_of(options)
    for name, replacement in replaced.items():
        if is_written(replacement.path):
            read_description(name, copy_of(replacement.path), timeout)   # its import may take that, too
    return prepare_all(plans, folder_of(options), replaced, starts(plans, options),
                       seconds("step", options.get("step")), options.get("order", "sequential"), timeout,
                       follows(options))


def replacements(options: FlightOptions) -> dict[str, Replacement]:
    """FMUs that take the place of a plan's, by name in the run, with their maps."""
    plant, controller = options.get("plant"), options.get("controller")
    given = {name: path_given(name, each, options) for name, each in (("plant", plant), ("controller", controller))
             if each is not None}
    ports = options.get("ports")
    maps = {} if ports is None else read_port_maps(Path(ports))
    for name in maps:
        if name not in given:
            raise ScenarioError(f"{ports}: [{name}]: expected --{name} with it")
    if ports is not None and not maps:
        raise ScenarioError(f"--map {ports}: expected a table [controller] or [plant] in it")
    keep = options.get("keep_settings", False)
    if keep and not given:
        raise ScenarioError("--keep-settings: expected --controller or --plant with it, which gets the settings")
    return {name: Replacement(path, maps.get(name, PortMap()), keep) for name, path in given.items()}


def path_given(role: str, given: str | Path | type, options: FlightOptions) -> Path:
    """Path of what is put in as plant or controller: an FMU of this project may be given by its name.

    A bare name means one if no file has it; UnknownName if there is no such FMU.
    """
    if isinstance(given, type) or Path(given).exists() or not str(given) == Path(given).name == Path(given).stem:
        return path_of(given)
    if str(given) not in places():
        raise UnknownName(f"{role} {given}: is no FMU of this project and no file, nearest is "
                          f"{nearest(str(given), places())}")
    return folder_of(options) / f"{given}.fmu"


def follows(options: FlightOptions) -> bool:
    """Whether the controller's model is to follow the masses of the plant."""
    return str(options.get("model")) == "plant"


def starts(plans: Sequence[RunPlan], options: FlightOptions) -> dict[str, StartValue]:
    """Start values of a model file and, over them, of the settings."""
    settings, model = start_values(options.get("set")), options.get("model")
    if model is None or follows(options):
        return settings
    rigs = {plan.rig.name: plan.rig for plan in plans if plan.rig is not None}
    if len(rigs) != 1:
        raise ScenarioError(f"--model {model}: expected runs of one rig, got {' and '.join(sorted(rigs)) or 'none'}")
    constants = start_values(model_settings(Path(model), *rigs.values()))
    for plan in plans:
        for name, fmu in plan.fmus.items():
            for variable, source in fmu.start_from.items():
                if f"{name}.{variable}" in constants:
                    raise ScenarioError(f"--model {model}: {plan.name} takes {name}.{variable} from {source.run}, "
                                        "expected only runs that take no constants from others")
    return constants | settings


def folder_of(options: FlightOptions) -> Path:
    """Folder of the FMUs of this project."""
    return kind_folder(Path(options.get("fmus", "fmus")), options.get("native", False), options.get("fmi", 2))


def timeout_of(options: FlightOptions) -> float:
    """Longest time (s) that a call of an FMU which is not of this project may take."""
    return seconds("timeout", options.get("timeout")) or TIMEOUT


def seconds(name: str, value: float | str | None) -> float | None:
    """An option that is a time (s), a number or text with a unit."""
    return None if value is None else positive_time(value, ScenarioError, f"--{name} {value}")
