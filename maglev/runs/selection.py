"""The runs that a command line selects, and the runs that their claims compare with."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from maglev.files.errors import ScenarioError, key_path, nearest
from maglev.runs.preparation import Experiment, prepare
from maglev.runs.replacement import Replacement
from maglev.scenario.layers import Scenario, ScenarioSource, packaged_files
from maglev.scenario.loading import load_plan, load_plans
from maglev.scenario.options import RunOptions
from maglev.scenario.run_plan import RunPlan, StartValue

Scenarios = Scenario | Iterable[Scenario]


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
