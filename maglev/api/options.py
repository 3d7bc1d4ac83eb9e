"""Runs made ready with their options: replaced FMUs, values and step."""

from collections.abc import Collection, Sequence
from pathlib import Path

from maglev.cosim.open import describe
from maglev.cosim.port_map import PortMap, read_port_maps
from maglev.descriptions.own_fmus import own_fmu
from maglev.files.errors import ScenarioError, option
from maglev.files.side_by_side import Say, Watch, unwatched, warn
from maglev.identification.model_file import model_settings
from maglev.runs.chain import prepare_all
from maglev.runs.preparation import Experiment, know_stage_of
from maglev.runs.replacement import Replacement, named_or_source
from maglev.runs.starts import parameter_values
from maglev.scenario.fmus_for_runs import fmus_for_runs
from maglev.scenario.options import RunOptions, SomeOptions, completed_options
from maglev.scenario.run_plan import RunPlan, StartValue
from maglev.scenario.settings import start_values
from maglev.user.source import FmuFile, PythonFile


def experiments_of(plans: Sequence[RunPlan], options: SomeOptions, say: Say = warn, watch: Watch = unwatched,
                   everywhere: bool = False) -> list[Experiment]:
    """Return the runs made ready; see `fmus_for_runs` for arguments. MaglevError if an option or a plan cannot be used.
    """
    options = completed_options(options)
    for plan in plans:
        know_stage_of(plan)
    settings = starts(plans, options)
    given = {name: named_or_source(name, fmu, plans) for name, fmu in
             (("plant", options["plant"]), ("controller", options["controller"])) if fmu is not None}
    maps = port_maps(given, options)
    for name, source in given.items():
        if isinstance(source, PythonFile):
            describe(name, source.copy(), float(options["timeout"]))   # its import may take that, too
    needed = [fmu.model for plan in plans for name, fmu in plan.fmus.items() if fmu.model and name not in given]
    needed += [name for name in given.values() if isinstance(name, str)]
    folder = fmus_for_runs(needed, options["fmus"], options["kind"], options["fmi"], everywhere=everywhere, say=say,
                           watch=watch)
    replaced = {name: Replacement(FmuFile(own_fmu(fmu, folder)) if isinstance(fmu, str) else fmu,
                                  maps.get(name, PortMap()), options["keep_settings"])
                for name, fmu in given.items()}
    return prepare_all(plans, folder, replaced, settings, options)


def port_maps(given: Collection[str], options: RunOptions) -> dict[str, PortMap]:
    """Maps of the FMUs that take the place of a plan's, by name in the run."""
    ports = options["ports"]
    maps = {} if ports is None else read_port_maps(Path(ports))
    for name in maps:
        if name not in given:
            raise ScenarioError(f"{ports}: [{name}]: needs {option(name)}")
    if ports is not None and not maps:
        raise ScenarioError(f"{ports}: expected a table [controller] or [plant]")
    if options["keep_settings"] and not given:
        raise ScenarioError(f"{option('keep_settings')}: needs {option('controller')} or {option('plant')}, which "
                            "gets the settings")
    return maps


def starts(plans: Sequence[RunPlan], options: RunOptions) -> dict[str, StartValue]:
    """Start values of a model file and, over them, of parameter sets, and over these of the settings."""
    sets = parameter_values(options["parameters"], [name for plan in plans for name in plan.fmus])
    settings, model = sets | start_values(options["set"]), options["model"]
    if model is None or str(model) == "plant":   # which follows, see `following`
        return settings
    asked = option("model", str(model))
    stages = {plan.stage.name: plan.stage for plan in plans if plan.stage is not None}
    if len(stages) != 1:
        raise ScenarioError(f"{asked}: expected runs of one stage, got {' and '.join(sorted(stages)) or 'none'}")
    constants = start_values(model_settings(Path(model), *stages.values()))
    for plan in plans:
        for name, fmu in plan.fmus.items():
            for variable, source in fmu.start_from.items():
                if f"{name}.{variable}" in constants:
                    raise ScenarioError(f"{asked}: {plan.name} takes {name}.{variable} from {source.run}, "
                                        "expected only runs that take no constants from others")
    return constants | settings
