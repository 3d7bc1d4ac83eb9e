"""Tuning: a search for the parameters of a controller that minimise metrics on many plants."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Unpack

from maglev.api.studying import made_ready
from maglev.descriptions.writer import render
from maglev.files.errors import ScenarioError, key_path, option
from maglev.files.side_by_side import Say, Watch, processes, unwatched, warn
from maglev.files.whole_file import write_whole
from maglev.linear.parameters import controllers
from maglev.many.batches import runners
from maglev.many.study_parts import Parts
from maglev.many.tuning_plan import PlannedTuning, load_tuning, plan_tuning
from maglev.many.tuning_search import SearchResult, gains_toml, search, show_result
from maglev.scenario.loading import load_plan
from maglev.scenario.options import SampleOptions, takes_options
from maglev.user.new_stage import seen_from, toml_file, write_new
from maglev.user.source import PythonFile, file_source


@dataclass(frozen=True)
class Tuned:
    """The result of a tuning.

    Attributes
    ----------
    parameters : mapping of str to float
        By `fmu.variable`, SI: `maglev.run(name, set=tuned.parameters)` takes them.
    path : Path
        The same as a file that a scenario extends.
    found : SearchResult
        Costs, and metrics on every plant before and after.
    planned : PlannedTuning
        The searched parameters, and the columns of the metrics.
    """

    parameters: Mapping[str, float]
    path: Path
    found: SearchResult
    planned: PlannedTuning

    def __repr__(self) -> str:
        found = ", ".join(f"{name} = {value:g}" for name, value in self.parameters.items())
        return f"<Tuned {self.planned.tuning.name}: {found}, in {self.path}>"

    def show(self, console: Any) -> None:
        """Print it on a console of rich."""
        show_result(console, self.planned.tuning, self.planned.cost, self.found)


def new_tuning(path: str | Path, scenario: str | Path, controller: str | Path | None = None) -> Path:
    """Write a tuning file that runs, to begin with; nothing is overwritten. Returns the file.

    Parameters
    ----------
    path : path
        The file, NAME or NAME.toml; its result is named after it.
    scenario : str or path
        The run to repeat: one of the package by its name, or your own scenario, without variants.
    controller : path, optional
        A Python file with your controller, whose parameters are searched; if not given, the poles of the scenario's
        regulator.

    Raises
    ------
    MaglevError
        If the file is there already, its name is not allowed, the scenario or the controller does not exist, or it has
        no parameter to search.

    Examples
    --------
    >>> import maglev
    >>> maglev.new_tuning("quicker.toml", "3dof-setpoints").name
    'quicker.toml'
    """
    file, plan = toml_file(path), load_plan(scenario)
    if plan.stage is None or not {"plant", "controller"} <= plan.fmus.keys():
        raise ScenarioError(f"{scenario}: fmus = {key_path(list(plan.fmus))}: expected a scenario with plant and "
                            "controller of a stage")
    searched = [] if controller is None else searched_of(Path(controller))
    model = plan.fmus["controller"].model
    if controller is None and (model not in controllers() or "Regulator" not in model):
        raise ScenarioError(f"{scenario}: controller = {model or plan.fmus['controller'].file}: expected an output "
                            f"regulator, whose poles are tuned, or {option('controller', 'FILE')}, a Python file")
    name = seen_from(file, scenario) if str(scenario).endswith(".toml") else str(scenario)
    write_new(file, render("new/tuning.toml.j2", plan.stage, file=file.name, name=file.stem, scenario=name,
                           controller=controller and seen_from(file, controller), searched=searched))
    return file


def searched_of(controller: Path) -> list[tuple[str, float, float]]:
    """Parameters of a controller in Python with half and twice the value that each begins with."""
    source = file_source(controller)
    if not isinstance(source, PythonFile):
        raise ScenarioError(f"{option('controller', str(controller))}: expected a Python file, such as lqi.py")
    definition = source.load().definition
    starts = {variable.name: definition.start_value(variable) for variable in definition.variables
              if variable.causality == "parameter" and variable.name != "sample_time"}
    found = [(name, min(0.5 * start, 2.0 * start), max(0.5 * start, 2.0 * start)) for name, start in starts.items()
             if isinstance(start, float) and start != 0.0]
    if not found:
        raise ScenarioError(f"{controller}: parameters = {', '.join(starts) or 'none'}: expected at least one nonzero "
                            "number to tune")
    return found


@takes_options
def tune(file: str | Path, *, out: str | Path = "results", jobs: int | None = None, scheduler: str | None = None,
         resume: bool = False, watch: Watch | None = None, say: Say | None = None,
         **options: Unpack[SampleOptions]) -> Tuned:
    """Search the parameters that a tuning file asks for, and write them as a file that a scenario extends.

    Parameters
    ----------
    file : str or Path
        A tuning file of the package by its name, or a TOML file (docs/studies.md).
    out : path
        Folder for NAME.toml.
    jobs, scheduler : optional
        See `study`.
    resume : bool
        Continue an interrupted search, also with more `generations`.
    watch, say : callable, optional
        See `run_all`.
    **options
        See `run`.

    Returns
    -------
    Tuned
        The same, bit for bit, whoever ran it.

    Raises
    ------
    MaglevError
        If an argument cannot be used; raised before the first run.
    """
    tuning, path = load_tuning(file)
    with made_ready(tuning, str(path), path.parent, options, scheduler, say or warn,
                    watch or unwatched) as (experiment, _):
        planned = plan_tuning(tuning, experiment, str(path))
        with (watch or unwatched)([tuning.name]) as watcher:
            found = search(planned, Parts(Path(out) / f"{tuning.name}.parts", planned.job.key),
                           partial(runners, scheduler, processes(jobs)), resume,
                           partial(watcher, tuning.name), say or warn)
    written = Path(out) / f"{tuning.name}.toml"
    write_whole(written, gains_toml(tuning, found))
    return Tuned(found.parameters, written, found, planned)
