"""Verdicts on the claims about a procedure."""

from maglev.judging.verdicts import ClaimResult, against_each_other, against_target, mean
from maglev.procedures.outcome import Outcome
from maglev.schema.procedure import ProcedureClaim


def judge_procedure(outcome: Outcome) -> list[ClaimResult]:
    """Claims of a procedure with their verdicts; "not run" where the runs behind a value are missing."""
    return [judge_claim(claim, outcome) for claim in outcome.settings.claims]


def judge_claim(claim: ProcedureClaim, outcome: Outcome) -> ClaimResult:
    """Judge one claim, as `verdicts.judge` does; a comparison is one of means."""
    if claim.value is None:
        return ClaimResult(claim, None, "not testable")
    values = outcome.select(claim, claim.epsilon, claim.gaps)
    if not values:
        return ClaimResult(claim, None, "not run")
    if claim.than is None:
        return against_target(claim, values, float(claim.target or 0.0))
    than = claim.than
    others = outcome.select(claim, claim.epsilon if than.epsilon is None else than.epsilon,
                            claim.gaps if than.gaps is None else than.gaps)
    if not others:
        return ClaimResult(claim, None, "not run")
    return against_each_other(claim, [(mean(values), mean(others))])
