"""Runs with other defaults than the FMUs have, flown one after the other in this process, and judged."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from maglev.api.options import experiments_of
from maglev.errors import FAILURES
from maglev.experiment.chain import started, waves
from maglev.experiment.execution import RunResult, failed, fly
from maglev.experiment.preparation import Experiment
from maglev.experiment.selection import compared, needed, select
from maglev.judging.run_claims import judge_run
from maglev.procedures.evaluate import evaluate_all, judge_procedure
from maglev.schema.run_plan import RunPlan, StartValue
from studies.estimation.evidence import Judged
from studies.estimation.settings import Defaults


def prepare(names: Iterable[str] | None) -> list[Experiment]:
    """Runs by name, all that make claims or procedures if none is named, and those that they need or compare with."""
    plans = [plan for plan in select(names) if names is not None or not plan.check_only]
    plans = [*plans, *compared(plans)]
    return experiments_of([*plans, *needed(plans)], {})


def with_defaults(plan: RunPlan, defaults: Defaults, following: Defaults) -> RunPlan:
    """Plan in which variables that it does not give start at other defaults; those that follow, only if it gives them.

    Both are by `model.variable`. A value of 0 is an effect that the scenario has turned off, and stays.
    """
    fmus = {}
    for name, fmu in plan.fmus.items():
        given = {*fmu.start, *fmu.start_from}
        start = {**of_model(defaults, fmu.model, absent=given), **fmu.start}
        start |= {variable: value for variable, value in of_model(following, fmu.model).items()
                  if variable in fmu.start and fmu.start[variable].value != 0}
        fmus[name] = fmu.model_copy(update={"start": start})
    return plan.model_copy(update={"fmus": fmus})


def of_model(values: Defaults, model: str | None, absent: Iterable[str] = ()) -> dict[str, StartValue]:
    """Values of one model's variables, without those that are named."""
    split = {key: key.partition(".") for key in values}
    return {variable: StartValue(values[key], None, repr(values[key])) for key, (own, _, variable) in split.items()
            if own == model and variable not in {*absent}}


def fly_all(experiments: Sequence[Experiment], defaults: Defaults, following: Defaults) -> list[RunResult]:
    """Fly runs, those that others start from first; one that fails says why."""
    by_name = {each.plan.name: each for each in experiments}
    results: dict[str, RunResult] = {}
    for ready in waves({name: each.plan.needs for name, each in by_name.items()}):
        for name in ready:
            experiment = by_name[name]
            try:
                plan = started(with_defaults(experiment.plan, defaults, following),
                               {other: results[other].ends for other in experiment.plan.needs})
                results[name] = fly(replace(experiment, plan=plan))
            except FAILURES as error:
                results[name] = failed(experiment, str(error))
    return [results[each.plan.name] for each in experiments]


def judge(results: Sequence[RunResult], owners: Iterable[str] | None = None) -> list[Judged]:
    """Verdicts on the claims about runs and procedures, in a fixed order; of the runs and procedures named, or all.

    Other readings of an experiment are no further evidence.
    """
    metrics = {each.plan.name: each.metrics for each in results}
    wanted = None if owners is None else {*owners}
    found = [Judged(each.plan.name, result) for each in results
             if not each.plan.another_reading and (wanted is None or each.plan.name in wanted)
             for result in judge_run(each.plan.claims, each.metrics, metrics)]
    if wanted is None:
        found += [Judged(outcome.settings.name, result) for outcome in evaluate_all(results)
                  for result in judge_procedure(outcome)]
    return found
