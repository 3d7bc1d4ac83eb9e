"""Runs without friction: the runs of missed claims whose reasons blame friction are run again without it."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import NamedTuple

from maglev.runs.execution import RunResult
from maglev.runs.preparation import Experiment, with_unit
from maglev.runs.procedure_outcome import Outcome
from maglev.runs.procedures import evaluate_all, judge_procedure
from maglev.runs.verdicts import Judgements, judge_run, those_that_blame_friction
from maglev.scenario.run_plan import StartValue

FRICTION = (".friction.coulomb", ".friction.viscous")   # ends of the names of its parameters, of every axis


class Again(NamedTuple):
    """Results of the runs without friction: the runs, outcomes of procedures, and every claim with its verdict."""

    runs: Sequence[RunResult] = ()
    outcomes: Sequence[Outcome] = ()
    verdicts: Judgements = MappingProxyType({})


NOTHING = Again()


def run_frictionless(experiments: Sequence[Experiment], verdicts: Judgements,
                     run_all: Callable[[list[Experiment]], list[RunResult]]) -> Again:
    """Run again, without friction, the experiments of missed claims whose reasons blame it.

    The result has every verdict, by run or procedure, with the one `without` friction.
    """
    blamed = {name: missed for name, claims in verdicts.items() if (missed := those_that_blame_friction(claims))}
    again = [without_friction(experiment) for experiment in with_needed(experiments, blamed)]
    runs = run_all(again) if again else []
    outcomes = [outcome for outcome in evaluate_all(runs) if outcome.settings.name in blamed]
    metrics = {result.plan.name: result.metrics for result in runs}
    judged = {result.plan.name: judge_run(result.plan.claims, result.metrics, metrics) for result in runs
              if result.plan.name in blamed}
    judged |= {outcome.settings.name: judge_procedure(outcome) for outcome in outcomes}
    return Again(runs, outcomes, {
        name: [replace(claim, without=without) if those_that_blame_friction([claim]) else claim
               for claim, without in zip(claims, judged[name], strict=True)] if name in judged else claims
        for name, claims in verdicts.items()})


def without_friction(experiment: Experiment) -> Experiment:
    """Return the experiment with all Coulomb and viscous friction of its FMUs at 0, listed in its `changes`."""
    friction = {full: value for full, value in experiment.parameters().items() if full.endswith(FRICTION) and value}
    plan = experiment.plan
    fmus = {name: fmu.model_copy(update={"start": {
        **fmu.start, **{full.partition(".")[2]: StartValue(0.0, None, 0) for full in friction
                        if full.partition(".")[0] == name}}}) for name, fmu in plan.fmus.items()}
    units = experiment.units(friction)
    changes = tuple(f"{full} = 0 instead of {with_unit(value, units[full])}" for full, value in friction.items())
    return replace(experiment, plan=plan.model_copy(update={"fmus": fmus, "title": f"{plan.title}, without friction"}),
                   changes=(*experiment.changes, *changes))


def with_needed(experiments: Sequence[Experiment], blamed: Judgements) -> list[Experiment]:
    """Experiments that claims, by run or procedure, are judged on, and those that these start from."""
    plans = {experiment.plan.name: experiment.plan for experiment in experiments}
    procedures = {plan.procedure.name: plan.procedure for plan in plans.values() if plan.procedure is not None}
    names = set(blamed)
    for claims in blamed.values():
        names.update(run for judged in claims for run in getattr(judged.claim, "other_runs", ()))
    for name in blamed.keys() & procedures.keys():
        names.update(procedures[name].runs.values())   # of other procedures, too
    wanted = {plan.name for plan in plans.values()
              if plan.name in names or (plan.procedure is not None and plan.procedure.name in names)}
    waiting = list(wanted)
    while waiting:
        new = plans[waiting.pop()].needs - wanted
        wanted |= new
        waiting += new
    return [experiment for experiment in experiments if experiment.plan.name in wanted]
