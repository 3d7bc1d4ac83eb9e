"""The outcomes of the procedures from the runs that belong to them, and the verdicts on claims about these."""

from collections.abc import Callable, Collection, Sequence

from maglev.files.errors import MaglevError, in_one_line
from maglev.runs import complete_model, forgetting, parabolas
from maglev.runs.equilibrium_currents import evaluate_cogging, evaluate_currents
from maglev.runs.execution import RunResult
from maglev.runs.procedure_data import Runs
from maglev.runs.procedure_outcome import Outcome
from maglev.runs.verdicts import ClaimResult, Judgements, MeasuredValue, Sides, judge, mean, of_modified_runs
from maglev.scenario.claims import GapRange, ProcedureClaim
from maglev.scenario.procedure import Kind, ProcedureSettings

EVALUATIONS: dict[Kind, Callable[[ProcedureSettings, Runs], Outcome]] = {
    "parabolas": parabolas.evaluate, "equilibrium": evaluate_currents, "cogging": evaluate_cogging,
    "identification": complete_model.evaluate, "forgetting": forgetting.evaluate}

SAME = 1e-6   # m or s; gaps and ε are compared as written


def evaluate_all(results: Sequence[RunResult], asked: Collection[str] | None = None) -> list[Outcome]:
    """Return the outcomes of the procedures that have runs among the results, in the order of their names.

    `asked` are names of runs: only procedures with one of these are evaluated, because a run that only others start
    from does not make a procedure. Values that need failed or missing runs are left out of the outcome.
    """
    completed = {result.plan.name: result for result in results if result.failure is None}
    procedures = {result.plan.procedure.name: result.plan.procedure for result in results
                  if result.plan.procedure is not None and (asked is None or result.plan.name in asked)}
    return [evaluate(settings, completed) for _, settings in sorted(procedures.items())]


def evaluate(settings: ProcedureSettings, runs: Runs) -> Outcome:
    """Outcome of one procedure; runs from which nothing can be found are a note, and the claims stay "not run"."""
    try:
        return EVALUATIONS[settings.kind](settings, runs)
    except MaglevError as error:
        return Outcome(settings, (), notes=(f"nothing was found: {in_one_line(error)}",))


def judge_outcomes(outcomes: Sequence[Outcome], modified: Collection[str] = ()) -> Judgements:
    """Judge the claims of every procedure, by name; "not run" where the runs behind a value are missing.

    Those that rest on one of the modified runs, by name, have no verdict on the thesis.
    """
    return {outcome.settings.name: of_modified_runs(judge_procedure(outcome)) if {*outcome.runs} & {*modified}
            else judge_procedure(outcome) for outcome in outcomes}


def judge_procedure(outcome: Outcome) -> list[ClaimResult]:
    return [judge(claim, *procedure_sides(claim, outcome)) for claim in outcome.settings.claims]


def procedure_sides(claim: ProcedureClaim, outcome: Outcome) -> Sides:
    """Values that a claim is about and, if it is comparative, their mean and that of those it compares with."""
    here = values_at(claim, outcome, claim.epsilon, claim.gaps)
    than = claim.than
    if than is None:
        return here or None, None
    there = values_at(claim, outcome, claim.epsilon if than.epsilon is None else than.epsilon,
                     claim.gaps if than.gaps is None else than.gaps)
    return mean_of(here), mean_of(there)


def values_at(claim: ProcedureClaim, outcome: Outcome, epsilon: float | None,
             gaps: GapRange | None) -> list[MeasuredValue]:
    """Values that a claim is about, at ε (s), in a range of gaps (m); None for all."""
    return [MeasuredValue(value.value) for value in outcome.values
            if value.name == claim.quantity
            and claim.constant in (None, value.constant)
            and (claim.axes is None or value.axis in claim.axes)
            and (epsilon is None or (value.epsilon is not None and abs(value.epsilon - epsilon) < SAME))
            and (gaps is None or (value.gap is not None and gaps[0] - SAME <= value.gap <= gaps[1] + SAME))]


def mean_of(values: Sequence[MeasuredValue]) -> list[MeasuredValue] | None:
    """The mean as the only value; None if there is nothing to average."""
    return [MeasuredValue(mean([value for value, _ in values]))] if values else None
