"""The runs that a command selects, those that they start from or compare with, and the values that they take over."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Protocol, TypeVar

from maglev.cosim.master import Recording
from maglev.files.errors import Interrupted, ScenarioError, key_path, nearest
from maglev.files.side_by_side import Stopped, Task, Watcher, kept_processes, side_by_side
from maglev.runs.preparation import Experiment, prepare
from maglev.runs.replacement import Replacement
from maglev.scenario.layers import Scenario, ScenarioSource, packaged_files
from maglev.scenario.loading import load_plan, load_plans
from maglev.scenario.options import RunOptions
from maglev.scenario.run_plan import RunPlan, StartValue

Scenarios = Scenario | Iterable[Scenario]
Ends = Mapping[str, Mapping[str, float]]   # every output at the end of a run, by name of the run; empty if it failed


class Ended(Protocol):
    """The result of a run, as far as others start from it."""

    @property
    def ends(self) -> Mapping[str, float]:
        """Every output at the end, empty if the run did not complete."""
        ...


T = TypeVar("T", bound=Ended)


def chained(needs: Mapping[str, set[str]], task: Callable[[str, Ends], Task[T]], jobs: int,
            died: Callable[[str, str], T], watch: Watcher, here: bool = False) -> dict[str, T]:
    """Do the tasks of runs, each after those that it needs, otherwise side by side; return results by name, as in
    `needs`.

    `needs` lists, by name of a run, the runs that it starts from. `task` makes a task of a name and the ends of the
    needed runs. `here` runs them one after the other in this process. See `side_by_side` for the other parameters.
    ScenarioError if runs need each other, or one that does not exist; Interrupted after Ctrl-C or SIGTERM.
    """
    results: dict[str, T] = {}
    with kept_processes() as idle:   # a process takes as long to start as some runs to run
        for ready in waves(needs):
            ends = {name: {other: results[other].ends for other in needs[name]} for name in ready}
            if here:
                results |= {name: task(name, ends[name])(partial(watch, name)) for name in ready}
                continue
            try:
                results |= side_by_side({name: task(name, ends[name]) for name in ready}, jobs, died, watch, idle)
            except Stopped as stopped:
                done = len(results) + len(stopped.results)
                raise Interrupted("; ".join([f"{stopped.what}: {done} of {len(needs)} runs were done",
                                             *(f"{name} {left}" for name, left in stopped.left.items())]),
                                  stopped.number) from None
    return {name: results[name] for name in needs}


def waves(needs: Mapping[str, set[str]]) -> Iterator[list[str]]:
    """Return the runs that can go side by side after those of the waves before; see `chained` for arguments and errors.
    """
    for name, others in needs.items():
        if others - needs.keys():
            raise cannot_go_before(name, *sorted(others - needs.keys()))
    sorter = TopologicalSorter(needs)
    try:
        sorter.prepare()
    except CycleError as error:
        *_, needed, name = error.args[1]   # each of the circle before the one that needs it
        raise cannot_go_before(name, needed) from None
    while sorter.is_active():
        ready = set(sorter.get_ready())
        yield [name for name in needs if name in ready]
        sorter.done(*ready)


def cannot_go_before(name: str, *needed: str) -> ScenarioError:
    return ScenarioError(f"{name}: start_from needs {', '.join(needed)}, expected a run that can go before it")


def ends_of(recording: Recording) -> dict[str, float]:
    """Every output at the end of a run."""
    return {name: float(values[-1]) for name, values in recording.columns.items()}


def started(plan: RunPlan, ends: Ends) -> RunPlan:
    """Plan with the start values that it takes from the ends of other runs; ScenarioError if one did not end."""
    fmus = {}
    for name, fmu in plan.fmus.items():
        taken = {}
        for variable, source in fmu.start_from.items():
            values = ends.get(source.run)
            if not values:
                raise ScenarioError(f"{name}.{variable} starts from {source.output} of {source.run}, which did not "
                                    "complete, or was not run to its end")
            taken[variable] = StartValue(values[source.output], None, values[source.output])
        fmus[name] = fmu.model_copy(update={"start": {**fmu.start, **taken}, "start_from": {}})
    return plan.model_copy(update={"fmus": fmus})


def select(names: Scenarios | None) -> list[RunPlan]:
    """Runs of scenarios, variants or files by name, or of tables, each once; all of the package if none is named.

    ScenarioError if a name does not exist, or results of two runs or procedures would have one name.
    """
    runs: dict[str, RunPlan] = {}
    for name in packaged_files() if names is None else [names] if isinstance(names, str | Path | Mapping) else names:
        for run in load_plans(name):
            if runs.setdefault(run.name, run).source != run.source:
                raise ScenarioError(f"{run.source}: name = {run.name!r}: {runs[run.name].source} has it too, expected "
                                    "another name: results are named after it")
    sources: dict[str, ScenarioSource] = {}   # of procedures by name
    for run in runs.values():
        if run.procedure is None:
            continue
        name = run.procedure.name
        other = runs[name].source if name in runs else sources.setdefault(name, run.source)
        if name in runs or other != run.source:
            raise ScenarioError(f"{run.source}: procedure.name = {name!r}: {other} uses it, expected another name: "
                                "results are named after it")
    return list(runs.values())


def compared_with(runs: Sequence[RunPlan]) -> list[RunPlan]:
    """Runs that claims of the given ones compare with, and that are not among them."""
    names = {run.name for run in runs}
    named = [name for run in runs for claim in run.claims for name in claim.other_runs]
    missing = dict.fromkeys(name for name in named if name not in names)
    sources = dict.fromkeys(run.source for run in runs) if missing else ()
    siblings = {sibling.name: sibling for source in sources for sibling in load_plans(source)}
    return [*(siblings[name] for name in missing if name in siblings),
            *(other for name in missing if name not in siblings for other in load_plans(name))]


def needed(runs: Sequence[RunPlan]) -> list[RunPlan]:
    """Runs that the given ones start from, directly or through others, and that are not among them."""
    known = {run.name: run for run in runs}
    waiting = list(runs)
    while waiting:
        run = waiting.pop()
        siblings = {sibling.name: sibling for sibling in load_plans(run.source)} if run.needs - known.keys() else {}
        for name in sorted(run.needs - known.keys()):
            known[name] = siblings.get(name) or load_plan(name)
            waiting.append(known[name])
    return list(known.values())[len(runs):]


def prepare_all(runs: Iterable[RunPlan], fmus: Path, replaced: Mapping[str, Replacement],
                settings: Mapping[str, StartValue], options: RunOptions | None = None) -> list[Experiment]:
    """Return the experiments of the runs; see `prepare` for arguments and errors.

    A run that starts from an output which the other run does not have is refused, too.
    """
    experiments = [prepare(run, fmus, replaced, settings, options) for run in runs]
    by_name = {experiment.plan.name: experiment for experiment in experiments}
    for experiment in experiments:
        if experiment.plan.needs:
            experiment.check()   # what it refuses shows before the runs that it waits for
        for fmu, entry in experiment.plan.fmus.items():
            for variable, source in entry.start_from.items():
                outputs = by_name[source.run].outputs()
                key = key_path(["fmus", fmu, "start_from", variable, "output"])
                if source.output not in outputs:
                    raise ScenarioError(f"{experiment.plan.source}: {key} = {source.output!r}: {source.run} has no "
                                        f"such output; {nearest(source.output, outputs)}")
                own, theirs = experiment.units([taker := f"{fmu}.{variable}"])[taker], outputs[source.output]
                if own and theirs and own != theirs:
                    raise ScenarioError(f"{experiment.plan.source}: {key} = {source.output!r}: is in {theirs}, "
                                        f"expected an output in {own} for {fmu}.{variable}")
    return experiments
