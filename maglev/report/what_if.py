"""What if friction were zero: the runs behind claims whose reasons blame it, run again without it."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

from maglev.experiment.execution import RunResult
from maglev.experiment.preparation import Experiment
from maglev.judging.run_claims import judge_run
from maglev.judging.verdicts import ClaimResult, Judgements, blames
from maglev.procedures.evaluate import judge_procedure
from maglev.procedures.outcome import Outcome
from maglev.schema.run_plan import StartValue

FRICTION = (".friction.coulomb", ".friction.viscous")   # ends of the names of its parameters, of every axis

Fly = Callable[[list[Experiment]], list[RunResult]]
Evaluate = Callable[[list[RunResult]], list[Outcome]]


class Again(NamedTuple):
    """What runs without friction gave: the runs, what procedures found in them, and every claim with the verdict."""

    runs: list[RunResult]
    outcomes: list[Outcome]
    verdicts: Judgements


def fly_frictionless(experiments: Sequence[Experiment], verdicts: Judgements, fly: Fly,
                     evaluate: Evaluate) -> Again:
    """Run again, of experiments that were run, what claims rest on that were missed and whose reasons blame friction.

    The verdicts, by run or procedure, are given back with what comes out `without` it.
    """
    blamed = {name: missed for name, claims in verdicts.items() if (missed := blames(claims, "friction"))}
    again = [without_friction(each) for each in with_needed(experiments, blamed)]
    runs = fly(again) if again else []
    outcomes = [found for found in evaluate(runs) if found.settings.name in blamed] if runs else []
    metrics = {result.plan.name: result.metrics for result in runs}
    found = {result.plan.name: judge_run(result.plan.claims, result.metrics, metrics) for result in runs
             if result.plan.name in blamed}
    found |= {outcome.settings.name: judge_procedure(outcome) for outcome in outcomes}
    return Again(runs, outcomes, {name: [beside(*pair) for pair in zip(claims, found[name], strict=True)]
                                         if name in found else claims for name, claims in verdicts.items()})


def without_friction(experiment: Experiment) -> Experiment:
    """The experiment with all Coulomb and viscous friction of its FMUs at 0; what differs is in its `changes`."""
    found = {full: value for full, value in experiment.parameters().items() if full.endswith(FRICTION) and value}
    plan = experiment.plan
    fmus = {name: fmu.model_copy(update={"start": {
        **fmu.start, **{full.partition(".")[2]: StartValue(0.0, None, 0) for full in found
                        if full.partition(".")[0] == name}}}) for name, fmu in plan.fmus.items()}
    changes = tuple(f"{full} = 0 instead of {value:g}" for full, value in found.items())
    return replace(experiment, plan=plan.model_copy(update={"fmus": fmus, "title": f"{plan.title}, without friction"}),
                   changes=(*experiment.changes, *changes))


def beside(result: ClaimResult, without: ClaimResult) -> ClaimResult:
    """The result with that of the same claim without friction, if its reason blames this."""
    return replace(result, without=without) if blames([result], "friction") else result


def with_needed(experiments: Sequence[Experiment], blamed: Judgements) -> list[Experiment]:
    """Experiments that claims, by run or procedure, are judged on, and those that these start from."""
    plans = {each.plan.name: each.plan for each in experiments}
    procedures = {plan.procedure.name: plan.procedure for plan in plans.values() if plan.procedure is not None}
    names = set(blamed)
    for claims in blamed.values():
        names.update(run for each in claims for run in getattr(each.claim, "other_runs", ()))
    for name in blamed.keys() & procedures.keys():
        names.update(procedures[name].runs.values())   # of other procedures, too
    wanted = {plan.name for plan in plans.values()
              if plan.name in names or (plan.procedure is not None and plan.procedure.name in names)}
    waiting = list(wanted)
    while waiting:
        new = plans[waiting.pop()].needs - wanted
        wanted |= new
        waiting += new
    return [each for each in experiments if each.plan.name in wanted]
