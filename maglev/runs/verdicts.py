"""Verdicts on claims, from the measured values."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, TypeVar, get_args

from maglev.files.errors import MeasurementError, nearest
from maglev.runs.measures import measured_values
from maglev.runs.metrics import Metrics
from maglev.scenario.claims import CLAIM_KINDS, Claim, RunClaim

Verdict = Literal["reproduced", "within 10 %", "no difference", "not reproduced", "not testable", "not run",
                  "modified run", "met", "not met"]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)

# Verdicts of axis-range checks and of a user's own specification; the others are on the thesis's sentences.
MET_OR_NOT: tuple[Verdict, ...] = ("met", "not met")

ROUNDING = 1e-9   # m, A, or share of a limit or figure: rounding error of an encoder reading, a number of its steps

REPRODUCED = 0.05   # share of a figure within which it is reproduced: two significant digits round by no more
CLOSE = 0.1         # share of the target within which a missed claim is "within 10 %"
DIFFERENCE = 1.05   # ratio of two measured values from which on one of them is the larger one
MISSED: tuple[Verdict, ...] = ("within 10 %", "no difference", "not reproduced", "not met")

T = TypeVar("T")

Place = tuple[str, float]         # axis or motor, and time of the step (s), 0 where there is none
EVERYWHERE: Place = ("", 0.0)     # of a value that belongs to the whole run, or to all places together


class MeasuredValue(NamedTuple):
    """A measured value, SI or whether something happened, and where it was measured."""

    value: float | bool
    place: Place = EVERYWHERE


@dataclass(frozen=True)
class ClaimResult:
    """A claim, the measured value that decides it, and the verdict."""

    claim: Claim
    measured: float | bool | None   # None if the claim is not testable or a run is missing
    verdict: Verdict
    against: float | None = None   # what a comparative claim compares the measured value with
    # the same of runs without what the claim's reason blames; None if these were not run
    without: "ClaimResult | None" = None
    # whether it is one of the thesis's claims; not if the run is another reading of an experiment that has one
    counts: bool = True

    def __repr__(self) -> str:
        return f"<ClaimResult {self.verdict}: {self.claim.text}>"

    @property
    def measured_text(self) -> str:
        """The measured value with its unit, "not settled" where a band was not reached."""
        own = self.claim.printed(self.measured)
        return own if self.against is None else f"{own} against {self.claim.printed(self.against)}"

    @property
    def note(self) -> str:
        """Reason of the verdict, remark and the parameter that was fitted to the claim; empty if there is none."""
        evidence = "claim" if self.claim.figure is None else "figure"
        chosen = f"not independent: the {evidence} was used to choose {self.claim.chose}" if self.claim.chose else ""
        return "; ".join(filter(None, (self.explanation, chosen if self.verdict != "not run" else "")))

    @property
    def explanation(self) -> str:
        """The note without the parameter that was fitted to the claim."""
        if self.verdict == "not run":
            return ""
        why = {"not testable": self.claim.not_testable, "no difference": self.claim.reason,
               "not reproduced": self.claim.reason, "not met": self.claim.reason}.get(self.verdict)
        given = f"decided by a value given to the plant: {self.claim.given}" if self.claim.given else None
        other = None if self.counts else "another reading of the experiment, not counted"
        return "; ".join(part for part in (why, self.claim.remark, given, other) if part)


def those_that_blame_friction(claims: Iterable[ClaimResult]) -> list[ClaimResult]:
    """Return the missed claims whose reasons blame friction, which is assumed."""
    return [result for result in claims if result.claim.because == "friction" and result.verdict in MISSED]


# Measured values for a claim and, if it is comparative, for its other side.
Sides = tuple[Sequence[MeasuredValue] | None, Sequence[MeasuredValue] | None]
Judgements = Mapping[str, Sequence[ClaimResult]]   # claims with their verdicts, by name of the run or the procedure


def count_verdicts(claims: Iterable[ClaimResult]) -> dict[Verdict, int]:
    """Return the number of claims with each verdict, zeros included."""
    counts = Counter(claim.verdict for claim in claims)
    return {verdict: counts[verdict] for verdict in VERDICTS}


def those_that_count(claims: Iterable[ClaimResult]) -> list[ClaimResult]:
    """Return the claims without those of other readings, which would count an experiment twice."""
    return [claim for claim in claims if claim.counts]


def specification(claims: Iterable[ClaimResult]) -> list[ClaimResult]:
    """Return the user's own claims: requirements on a run, with any controller."""
    return [claim for claim in claims if claim.claim.own]


def sentences(claims: Iterable[ClaimResult]) -> list[ClaimResult]:
    """Return the claims that the thesis makes in words."""
    return [claim for claim in claims if claim.claim.figure is None and not claim.claim.own]


def bound_claims(claims: Iterable[ClaimResult]) -> list[ClaimResult]:
    """Return the axis-range checks: claims that the axes of the thesis's figures make."""
    return [claim for claim in claims if claim.claim.figure is not None and not claim.claim.own]


def by_kind(claims: Iterable[ClaimResult]) -> dict[str, list[ClaimResult]]:
    """Return the thesis's claims in words, by kind of statement: printed numbers first."""
    words = sentences(claims)
    kinds = {name: [claim for claim in words if claim.claim.kind == kind] for kind, name in CLAIM_KINDS.items()}
    return {name: of_kind for name, of_kind in kinds.items() if of_kind}


def met_of(claims: Iterable[ClaimResult]) -> str:
    """Return how many of the claims that are met or not met are met, such as "5 of 7"; empty without such claims."""
    counts = count_verdicts(claims)
    total = sum(counts[verdict] for verdict in MET_OR_NOT)
    return f"{counts['met']} of {total}" if total else ""


def bounds_met(claims: Iterable[ClaimResult]) -> str:
    """Return how many of the judged axis-range checks are met, such as "5 of 7"; empty if none was judged."""
    return met_of(bound_claims(claims))


def bounds_in_words(claims: Iterable[ClaimResult]) -> str:
    """Return the same in words, and how many of the met checks are not independent; empty if none was judged."""
    judged = bound_claims(claims)
    if not met_of(judged):
        return ""
    met = [claim for claim in judged if claim.verdict == "met"]
    chose = sum(claim.claim.chose is not None for claim in met)
    return f"{met_of(judged)} axis-range checks are met" + (
        f", {chose} of these {len(met)} with a figure that was used to choose a parameter" if chose else "")


def judge(claim: Claim, here: Sequence[MeasuredValue] | None,
          there: Sequence[MeasuredValue] | None = None) -> ClaimResult:
    """Judge a claim on its measured values, and on the values that it compares with; None means a missing run.

    One of several measured values decides and is in the result: with `over` "all" the worst one, with "any" the best
    one. With "mean" it is their mean, with "median" the middle one or the mean of the middle two. "about" allows a
    difference of at most 5 %, whatever the number of digits of the figure. A claim that is missed by at most 10 % of
    its target or factor is "within 10 %", unless that figure is assumed. "more" or "less" without a factor needs a
    difference above 5 %, otherwise the verdict is "no difference". An axis-range check, or a user's own claim, is met
    or not met, without a tolerance.

    Values are compared with those of the same place. Raises MeasurementError if no place has both.
    """
    if claim.quantity is None:
        return ClaimResult(claim, None, "not testable")
    if here is None or (claim.comparative and there is None):
        return ClaimResult(claim, None, "not run")
    if there is None:
        values, target = [value for value, _ in here], claim.target or 0.0
        if isinstance(target, tuple):
            return within(claim, values, target)
        measured = decisive(claim, values, mean, lambda value: miss(claim, value, target), float)
        return ClaimResult(claim, measured, figure_verdict(claim, meets(claim, measured, target), measured, target))
    counterparts = {place: value for value, place in there}
    pairs = [(value, counterparts[place]) for value, place in here if place in counterparts]
    if not pairs:
        raise MeasurementError(f"claim {claim.text!r}: {claim.elsewhere} has no {claim.quantity} at the same place")
    return against_each_other(claim, pairs)


def of_modified_runs(results: Iterable[ClaimResult]) -> list[ClaimResult]:
    """Return the results of modified runs, without verdicts on the thesis; a user's own claims keep theirs."""
    return [result if result.claim.own or result.verdict in ("not testable", "not run")
            else replace(result, verdict="modified run") for result in results]


def within(claim: Claim, values: Sequence[float], limits: tuple[float, float]) -> ClaimResult:
    """Judge an axis-range check on measured values.

    Automatic limits are the first ticks beyond the data. An extreme at the inner limit is not met, because the axis
    would then have ended there.
    """
    low, high = limits
    measured = decisive(claim, values, mean, lambda value: max(low - value, value - high), float)
    inner = {"lowest": high, "highest": low, "largest": low}.get(str(claim.quantity), math.inf)
    at_inner = math.isclose(measured, inner, rel_tol=ROUNDING, abs_tol=ROUNDING)
    return ClaimResult(claim, measured, "met" if low <= measured <= high and not at_inner else "not met")


def against_each_other(claim: Claim, pairs: Sequence[tuple[float, float]]) -> ClaimResult:
    """Judge a comparative claim on pairs of values from both places."""
    measured, against = decisive(
        claim, pairs, lambda all_pairs: (mean([own for own, _ in all_pairs]), mean([other for _, other in all_pairs])),
        lambda pair: miss(claim, ratio(*pair), claim.factor), lambda pair: ratio(*pair))
    share = ratio(measured, against)
    met = miss(claim, share, least_ratio(claim)) < 0.0
    return ClaimResult(claim, measured, figure_verdict(claim, met, share, claim.factor), against)


def least_ratio(claim: Claim) -> float:
    """Return the bound of the ratio of two measured values: the factor of the claim, or that of "more" or "less"."""
    if claim.own or claim.factor != 1.0:
        return claim.factor
    return DIFFERENCE if claim.relation == ">" else 1.0 / DIFFERENCE


def figure_verdict(claim: Claim, met: bool, value: float, figure: float) -> Verdict:
    """Return the verdict on a claim about a target or a factor that a value meets or misses."""
    if claim.own:
        return "met" if met else "not met"
    if claim.claims_a_difference and 1.0 / DIFFERENCE < value < DIFFERENCE:
        return "no difference"
    if met:
        return "reproduced"
    # Only a stated figure can be missed by little: "more" and "less" name none, and an assumed one does not count.
    named = not claim.assumed and claim.relation != "is" and not (claim.comparative and figure == 1.0)
    return "within 10 %" if named and abs(value - figure) <= CLOSE * abs(figure) else "not reproduced"


def decisive(claim: Claim, items: Sequence[T], average: Callable[[Sequence[T]], T],
             missed_by: Callable[[T], float], size: Callable[[T], float]) -> T:
    if claim.over == "mean":
        return average(items)
    if claim.over == "median":
        ordered = sorted(items, key=size)
        return average(ordered[(len(ordered) - 1) // 2:len(ordered) // 2 + 1])
    return (min if claim.over == "any" else max)(items, key=missed_by)


def mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


def ratio(value: float, other: float) -> float:
    """Return value / other; 1 if both are 0 or both infinite."""
    if value == other:
        return 1.0
    return value / other if other != 0.0 else math.inf


def miss(claim: Claim, value: float, target: float) -> float:
    """Return how far the value is on the wrong side of the target; the larger, the worse."""
    if claim.relation == "<":
        return value - target
    if claim.relation == ">":
        return target - value
    return abs(value - target)


def meets(claim: Claim, value: float, target: float) -> bool:
    if claim.relation == "is":
        return value == target
    if claim.relation == "about":
        # The factor accepts a value exactly at the edge in spite of binary rounding.
        return abs(value - target) <= REPRODUCED * abs(target) * (1.0 + ROUNDING)
    return miss(claim, value, target) < 0.0


def judge_run(claims: Sequence[RunClaim], metrics: Metrics | None,
              others: Mapping[str, Metrics | None]) -> list[ClaimResult]:
    """Judge the claims about a run, whose metrics are None if it did not complete; see `judge`.

    `others` are those of the runs that claims compare with, by name. MeasurementError if the run has nothing that a
    claim could be judged on.
    """
    return [judge(claim, *run_sides(claim, metrics, others)) for claim in claims]


def require_sides(claims: Sequence[RunClaim], expected: Metrics, others: Mapping[str, Metrics | None]) -> None:
    """Refuse a claim that nothing can be judged on in a run with the metrics that are expected; as of `judge_run`."""
    for claim in claims:
        if claim.columns is None:   # which may or may not be recorded
            run_sides(claim, expected, others)


def run_sides(claim: RunClaim, metrics: Metrics | None, others: Mapping[str, Metrics | None]) -> Sides:
    """Values that a claim is about and, if it is comparative, those that it compares with, as `judge` takes them."""
    other = metrics if claim.than is None else others.get(claim.than)
    if claim.quantity is None or metrics is None or other is None:
        return None, None
    if claim.columns is not None:
        drawn = [metrics, *(others.get(run) for run in claim.together_with or ())]
        return None if None in drawn else [MeasuredValue(extreme(claim, [run for run in drawn if run]))], None
    here = metric_values(claim, metrics, claim.axes)
    if not here:
        hint = "" if claim.own else "; `claims = []` in the file leaves out the claims of the files it extends"
        raise MeasurementError(f"claim {claim.text!r}: the run has no {claim.quantity} to judge it on{hint}")
    if not claim.comparative:
        return here, None
    if claim.than_axis is None:
        return here, metric_values(claim, other, None)
    # A value that is compared with another axis has its counterpart there, at the same step.
    return ([MeasuredValue(value, (claim.than_axis, time)) for value, (_, time) in here],
            metric_values(claim, other, [claim.than_axis]))


def extreme(claim: RunClaim, drawn: Sequence[Metrics]) -> float:
    """Extreme of the claim's columns over runs; MeasurementError if one was not recorded."""
    extremes = []
    for name in claim.columns or ():
        for metrics in drawn:
            if name not in metrics.extremes:
                raise MeasurementError(f"claim from {claim.source}: column = {name!r} was not recorded, "
                                       f"{nearest(name, metrics.extremes)}")
            extremes.append(metrics.extremes[name])
    lowest, highest = min(low for low, _ in extremes), max(high for _, high in extremes)
    return {"lowest": lowest, "highest": highest, "largest": max(-lowest, highest)}[str(claim.quantity)]


def metric_values(claim: RunClaim, metrics: Metrics, axes: Sequence[str] | None) -> list[MeasuredValue]:
    """Values of the claim's metric on the given axes or on the claim's motors; None for all."""
    chosen = claim.motors if axes is None else axes
    return [MeasuredValue(number.value, (number.of, number.time or 0.0))
            for number in measured_values(metrics, str(claim.quantity))
            if number.band == claim.band and (chosen is None or number.of in chosen)
            and (claim.event is None or number.event == claim.event)]
