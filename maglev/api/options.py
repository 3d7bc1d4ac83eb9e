"""Options that the functions share: what is put in place of a plan's FMUs, values and step."""

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TypedDict

from maglev.catalogue.for_runs import fmus_for_runs
from maglev.cosim.open import read_description
from maglev.cosim.order import Order
from maglev.cosim.other_process.run import TIMEOUT
from maglev.cosim.port_map import PortMap, read_port_maps
from maglev.errors import ScenarioError, nearest
from maglev.experiment.ports.parameter_file import ParameterFiles, parameter_values
from maglev.experiment.ports.replacement import Replacement, named_or_path
from maglev.experiment.preparation import Experiment, know_stage_of
from maglev.experiment.selection import prepare_all
from maglev.identification.model_file import model_settings
from maglev.kinds import KindName
from maglev.own_fmus import own_fmu
from maglev.processes.watching import Say, Watch, unwatched, warn
from maglev.schema.run_plan import RunPlan, StartValue
from maglev.schema.settings import Settings, start_values
from maglev.units import positive_time
from maglev.user_controllers.source import Given, copy_of, is_written

Value = float | int | bool | str


class FlightOptions(TypedDict, total=False):
    """How runs differ from their plans; see `maglev.run`."""

    set: Settings
    parameters: ParameterFiles
    model: str | Path | None
    plant: Given | None
    controller: Given | None
    ports: str | Path | None
    step: float | str | None
    order: Order
    fmus: str | Path | None
    kind: KindName | None
    fmi: int
    timeout: float | str
    keep_settings: bool


def experiments_of(plans: Sequence[RunPlan], options: FlightOptions, say: Say = warn, watch: Watch = unwatched,
                   everywhere: bool = False) -> list[Experiment]:
    """Runs made ready, arguments also as of `fmus_for_runs`; MaglevError if an option or a plan cannot be used."""
    for name in options.keys() - FlightOptions.__annotations__.keys():
        raise ScenarioError(f"{name}: unknown option, nearest is {nearest(name, FlightOptions.__annotations__)}")
    for plan in plans:
        know_stage_of(plan)
    step, timeout, settings = seconds("step", options.get("step")), timeout_of(options), starts(plans, options)
    given = {name: named_or_path(name, each, plans) for name, each in
             (("plant", options.get("plant")), ("controller", options.get("controller"))) if each is not None}
    maps = port_maps(given, options)
    for name, path in given.items():
        if isinstance(path, Path) and is_written(path):
            read_description(name, copy_of(path), timeout)   # its import may take that, too
    needed = [fmu.model for plan in plans for name, fmu in plan.fmus.items() if fmu.model and name not in given]
    needed += [each for each in given.values() if isinstance(each, str)]
    folder = fmus_for_runs(needed, options.get("fmus"), options.get("kind"), options.get("fmi", 2),
                           everywhere=everywhere, say=say, watch=watch)
    replaced = {name: Replacement(own_fmu(each, folder) if isinstance(each, str) else each,
                                  maps.get(name, PortMap()), options.get("keep_settings", False))
                for name, each in given.items()}
    return prepare_all(plans, folder, replaced, settings, step, options.get("order", "sequential"), timeout,
                       str(options.get("model")) == "plant")


def port_maps(given: Collection[str], options: FlightOptions) -> dict[str, PortMap]:
    """Maps of the FMUs that take the place of a plan's, by name in the run."""
    ports = options.get("ports")
    maps = {} if ports is None else read_port_maps(Path(ports))
    for name in maps:
        if name not in given:
            raise ScenarioError(f"{ports}: [{name}]: expected --{name} with it")
    if ports is not None and not maps:
        raise ScenarioError(f"--map {ports}: expected a table [controller] or [plant] in it")
    if options.get("keep_settings") and not given:
        raise ScenarioError("--keep-settings: expected --controller or --plant with it, which gets the settings")
    return maps


def starts(plans: Sequence[RunPlan], options: FlightOptions) -> dict[str, StartValue]:
    """Start values of a model file and, over them, of parameter sets, and over these of the settings."""
    sets = parameter_values(options.get("parameters"), [name for plan in plans for name in plan.fmus])
    settings, model = sets | start_values(options.get("set")), options.get("model")
    if model is None or str(model) == "plant":   # which follows, see `following`
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


def timeout_of(options: FlightOptions) -> float:
    """Longest time (s) that a call of an FMU which is not of this project may take."""
    return seconds("timeout", options.get("timeout")) or TIMEOUT


def seconds(name: str, value: float | str | None) -> float | None:
    """An option that is a time (s), a number or text with a unit."""
    return None if value is None else positive_time(value, ScenarioError, f"--{name} {value}")
