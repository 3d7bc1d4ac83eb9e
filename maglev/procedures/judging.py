"""Claims about procedures: the values that a procedure found that they are judged on."""

from collections.abc import Collection, Sequence

from maglev.judging.verdicts import ClaimResult, Judgements, MeasuredValue, Sides, judge, mean, of_modified_runs
from maglev.procedures.outcome import Outcome
from maglev.schema.claims import GapRange, ProcedureClaim

SAME = 1e-6   # m or s; gaps and ε are compared as written


def judge_outcomes(outcomes: Sequence[Outcome], modified: Collection[str] = ()) -> Judgements:
    """Judge the claims of every procedure, by name; "not run" where the runs behind a value are missing.

    Those that rest on one of the modified runs, by name, have no verdict on the thesis.
    """
    return {outcome.settings.name: of_modified_runs(judge_procedure(outcome)) if {*outcome.runs} & {*modified}
            else judge_procedure(outcome) for outcome in outcomes}


def judge_procedure(outcome: Outcome) -> list[ClaimResult]:
    """Judge the claims about a procedure; see `judge`."""
    return [judge(claim, *measured(claim, outcome)) for claim in outcome.settings.claims]


def measured(claim: ProcedureClaim, outcome: Outcome) -> Sides:
    """Values that a claim is about and, if it is comparative, their mean and that of those it compares with."""
    here = found_at(claim, outcome, claim.epsilon, claim.gaps)
    than = claim.than
    if than is None:
        return here or None, None
    there = found_at(claim, outcome, claim.epsilon if than.epsilon is None else than.epsilon,
                     claim.gaps if than.gaps is None else than.gaps)
    return mean_of(here), mean_of(there)


def found_at(claim: ProcedureClaim, outcome: Outcome, epsilon: float | None,
             gaps: GapRange | None) -> list[MeasuredValue]:
    """Values that a claim is about, at ε (s), in a range of gaps (m); None for all."""
    return [MeasuredValue(found.value) for found in outcome.values
            if found.name == claim.quantity
            and claim.constant in (None, found.constant)
            and (claim.axes is None or found.axis in claim.axes)
            and (epsilon is None or (found.epsilon is not None and abs(found.epsilon - epsilon) < SAME))
            and (gaps is None or (found.gap is not None and gaps[0] - SAME <= found.gap <= gaps[1] + SAME))]


def mean_of(values: Sequence[MeasuredValue]) -> list[MeasuredValue] | None:
    """The mean as the only value; None if there is nothing to average."""
    return [MeasuredValue(mean([value for value, _ in values]))] if values else None
