"""Runs next to each other: the same references under several controllers, or any runs that you have."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack, cast

import numpy as np

from maglev.api.options import experiments_of
from maglev.api.run import Run
from maglev.api.running import say_notes
from maglev.cosim.master import RunFailed
from maglev.descriptions.registry import known_stages
from maglev.files.errors import FAILURES, ScenarioError, extra, in_one_line, shortened
from maglev.files.pictures import require_matplotlib
from maglev.files.side_by_side import Progress, Say, Watch, unwatched, warn
from maglev.pages.comparison_files import compared_rows, comparison_data, show_comparison, write_comparison
from maglev.pages.comparison_table import Row
from maglev.pages.picture import overlay
from maglev.pages.run_text import Printable
from maglev.runs.chain import Ends, needed, started
from maglev.runs.execution import RunResult, failed_run, run_each, simulate, thinned
from maglev.runs.preparation import Experiment, know_stage_of
from maglev.scenario.layers import Scenario
from maglev.scenario.loading import load_plan
from maglev.scenario.options import CompareOptions, RunOptions, takes_options
from maglev.scenario.run_plan import RunPlan
from maglev.user.source import Given, file_source, name_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.console import Console

Controllers = Mapping[str, Given] | Iterable[Given]


@dataclass(frozen=True)
class Comparison(Printable):
    """Runs side by side.

    Attributes
    ----------
    name, title : str
        Those of the compared scenario, or of the first run.
    runs : mapping of str to Run
        By label, those that completed, also those that failed.
    failures : mapping of str to str
        Why the others did not complete, by label.
    results : mapping of str to RunResult
        All of them, in order.
    """

    name: str
    title: str
    runs: Mapping[str, Run]
    failures: Mapping[str, str]
    results: Mapping[str, RunResult]

    def __repr__(self) -> str:
        runs = ", ".join(f"{label} {run.ending}" for label, run in self.results.items())
        return f"<Comparison {self.name}: {runs}>"

    def show(self, console: "Console") -> None:
        """Print the tables on a console of rich."""
        show_comparison(console, self.name, self.title, self.results)

    @property
    def rows(self) -> list[Row]:
        """Return the measured values side by side: quantity, axis or motor, time of the step, values by label, best."""
        return compared_rows(self.results)

    def as_data(self) -> dict[str, Any]:
        """Return the comparison in JSON form."""
        return comparison_data(self.name, self.title, self.results)

    def to_pandas(self) -> Any:
        """Table with a line for each row and a column for each run, a pandas.DataFrame, SI."""
        rows = self.rows
        index = [(row.quantity, row.of, row.time) for row in rows]
        pandas = extra("pandas", "data")
        return pandas.DataFrame([dict(row.values) for row in rows], columns=list(self.runs),
                                index=pandas.MultiIndex.from_tuples(index, names=["quantity", "of", "time"]))

    def plot(self) -> "Figure":
        """The runs over each other, a matplotlib Figure: positions, errors, commands, currents."""
        results = {label: run.result for label, run in self.runs.items()}
        if not results:
            raise ScenarioError(f"{self.name}: no run completed, so there is nothing to draw")
        return overlay(f"{self.name}: {self.title}", results)

    def write(self, folder: str | Path = "results", *, picture: bool = True, page: bool = True) -> list[Path]:
        """Write columns and JSON of each run, and the comparison as JSON, text, PNG and HTML; returns the paths."""
        if picture:
            require_matplotlib()
        return write_comparison(Path(folder), self.name, self.title, self.results, picture=picture, page=page)


@takes_options
def compare(runs: Scenario | Iterable[Run] | Mapping[str, Run], controllers: Controllers | None = None, *,
            watch: Watch | None = None, say: Say | None = None, **options: Unpack[CompareOptions]) -> Comparison:
    """Simulate a run with each of several controllers, or put completed runs side by side.

    Parameters
    ----------
    runs : str, Path, table, iterable of Run or mapping of str to Run
        The run for each controller, as in `run`; or runs under the same references.
    controllers : iterable, or mapping of str to these, optional
        Names of FMUs of this project, "PID3DOF", files ("lqi.py", "lqi.fmu"), classes or objects of them. The label is
        the name, "label=file", or the mapping's key.
    watch, say : callable, optional
        See `run_all`.
    **options
        See `run`.

    Returns
    -------
    Comparison
        Failed runs are in it, too, with their reasons.

    Raises
    ------
    MaglevError
        If an argument cannot be used, or the runs differ in axes or references.
    KeyboardInterrupt
        After Ctrl-C; no files are written.

    Examples
    --------
    >>> import maglev
    >>> comparison = maglev.compare("2dof-smooth-nonlinear", ["Regulator2DOF", "PID2DOF"])
    >>> [row.best for row in comparison.rows if row.quantity == "rms error" and row.of == "v"]
    [('Regulator2DOF',)]
    """
    if isinstance(runs, Run) or not isinstance(runs, str | Path | Mapping) or (
            isinstance(runs, Mapping) and (not runs or any(isinstance(run, Run) for run in runs.values()))):
        if controllers is not None or options:
            raise ScenarioError(f"{', '.join(options) or 'controllers'}: needs the name of a run to make, got "
                                "finished runs")
        return comparison_of(cast("Iterable[Run] | Mapping[str, Run]", runs))
    plan = load_plan(runs)
    chosen = labelled(controllers or ())
    if not chosen:
        raise ScenarioError("controllers: the list is empty, expected controllers to compare, such as 'PID3DOF' or a "
                            "file")
    before = needed([plan])
    say, watch = say or warn, watch or unwatched
    first = experiments_of(before, {**options, "keep_settings": False}, say, watch) if before else []
    experiments = {label: put_in(plan, label, controller, options, say, watch) for label, controller in chosen.items()}
    for experiment in experiments.values():
        experiment.drives(experiment.check())   # what these refuse shows before the others run
    say_notes([*first, *experiments.values()], say)
    results = run_compared([*first, *experiments.values()], watch)
    for note in dict.fromkeys(f"{name}: {note}" for name, result in results.items() for note in result.recording.notes):
        say(note)
    by_label = {label: results[experiment.plan.name] for label, experiment in experiments.items()}
    return Comparison(plan.name, plan.title,
                      {label: Run(result, experiments[label].units(result.columns))
                       for label, result in by_label.items() if result.failure is None},
                      {label: result.failure for label, result in by_label.items() if result.failure is not None},
                      by_label)


def is_file(path: Path) -> bool:
    """Return True if a path, perhaps with the name of a class, names an existing file."""
    return file_source(path).path.is_file()


def labelled(controllers: Controllers) -> dict[str, Given]:
    """Controllers by label; of two with one name, the second is "NAME-2"."""
    if isinstance(controllers, Mapping):
        pairs: list[tuple[str, Given]] = list(controllers.items())
    else:
        pairs = []
        alone = isinstance(controllers, str | Path) or not isinstance(controllers, Iterable)
        for given in [controllers] if alone else controllers:
            if not isinstance(given, str | Path):
                pairs.append((name_of(given), given))
                continue
            label, equals, path = (str(given), "", "") if is_file(Path(given)) else str(given).partition("=")
            if equals:
                pairs.append((label, path))
            else:   # "lqi" of "a/lqi.fmu", "LQI" of "a/lqi.py:LQI"
                head, colon, name = label.rpartition(":")
                pairs.append((name if colon and head.endswith(".py") else Path(label).stem, given))
    by_label: dict[str, Given] = {}
    for label, controller in pairs:
        if controller is None:
            raise ScenarioError("controllers: the list has None, expected names, files, classes or objects")
        if not isinstance(label, str) or not label or set(label) & set('/\\\0<>:"|?*') or label.startswith("."):
            raise ScenarioError(f"controller {controller}: label = {label!r}, expected a label that can be part of a "
                                "file name")
        number = 2
        unique = label
        while unique in by_label:
            unique, number = f"{label}-{number}", number + 1
        by_label[unique] = controller
    return by_label


def put_in(plan: RunPlan, label: str, controller: Given, options: CompareOptions, say: Say = warn,
           watch: Watch = unwatched) -> Experiment:
    """Return the run with a controller, under a name of its own; the plan's own controller does not change the run.

    A map of ports is for the plant and for controllers that are files: this project's need none.
    """
    know_stage_of(plan)
    own = plan.fmus.get("controller")
    chosen = cast("RunOptions", {**options})
    named = str(controller) if isinstance(controller, str | Path) else ""
    if named in known_stages().definitions() and options.get("plant") is None:
        chosen.pop("ports", None)
    if own is None or own.model != named:
        chosen["controller"] = controller
    elif chosen.get("plant") is None:
        chosen["keep_settings"] = False   # nothing is put in
    experiment, = experiments_of([plan], chosen, say, watch)
    return replace(experiment, plan=experiment.plan.model_copy(update={"name": f"{plan.name}@{label}"}))


def run_compared(experiments: Sequence[Experiment], watch: Watch) -> dict[str, RunResult]:
    """Make runs here, one after the other; results by name, also of one that fails."""
    def run_or_fail(experiment: Experiment, ends: Ends, progress: Progress) -> RunResult:
        try:
            return simulate(replace(experiment, plan=started(experiment.plan, ends)), progress)
        except RunFailed as error:   # what was recorded until then can be drawn
            return replace(failed_run(experiment, in_one_line(error)),
                           recording=thinned(error.recording, experiment.output_every()))
        except FAILURES as error:
            return failed_run(experiment, in_one_line(error))

    with watch([experiment.plan.name for experiment in experiments]) as watcher:
        return {result.plan.name: result
                for result in run_each(experiments, run_or_fail, failed_run, 1, watcher, here=True)}


def comparison_of(runs: Iterable[Run] | Mapping[str, Run]) -> Comparison:
    """Return the comparison of runs; ScenarioError if the list is empty, or they differ in axes or references."""
    if isinstance(runs, Run):
        raise ScenarioError(f"runs: one run, {runs.name}, expected two or more in a list, or the name of a run to make")
    runs = runs if isinstance(runs, Mapping) else [*runs]
    for run in runs.values() if isinstance(runs, Mapping) else runs:
        if not isinstance(run, Run):
            raise ScenarioError(f"runs: {shortened(run)}, expected finished runs, or the name of a run with "
                                "controllers=[…]")
    labels = runs if isinstance(runs, Mapping) else dict(zip(labelled([run.name for run in runs]), runs, strict=True))
    if not labels:
        raise ScenarioError("runs: the list is empty, expected two or more")
    (first, one), *others = labels.items()
    for label, other in others:
        same = list(one.plan.axes) == list(other.plan.axes) and np.array_equal(one.time, other.time) and all(
            np.array_equal(one[axis.reference], other[other.plan.axes[name].reference])
            for name, axis in one.plan.axes.items())
        if not same:
            raise ScenarioError(f"{label} and {first} differ in axes, times or references, expected runs under the "
                                "same references")
    results = {label: replace(run.result, plan=run.plan.model_copy(update={"name": f"{one.name}@{label}"}))
               for label, run in labels.items()}
    return Comparison(one.name, one.plan.title, dict(labels), {}, results)
