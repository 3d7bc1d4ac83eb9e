"""What the thesis says against what was measured: residuals for the fit, verdicts for the counts."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from maglev.judging.verdicts import ClaimResult, Verdict, count_verdicts, miss, ratio, sentences

SHARE = 0.05      # standard deviation of a number that a run should have, as a share of it
MARGIN = 0.1      # standard deviation of how far a limit or factor is missed, as a share of it


@dataclass(frozen=True)
class Judged:
    """A claim with its verdict, and the run or procedure that it is about."""

    owner: str
    result: ClaimResult

    @property
    def key(self) -> str:
        """What tells it from all others."""
        claim = self.result.claim
        return f"{self.owner} | {claim.source} | {claim.text if claim.figure is None else claim.criterion}"


def residual(result: ClaimResult, largest: float) -> float:
    """How far a claim is missed, in standard deviations; approaches `largest`; 0 where it is met or not testable.

    "about" a figure: half of its last digit or 5 %, whatever is more, is one standard deviation. A limit or a factor:
    10 % of it, on the wrong side. A bound by an axis: the distance of its ticks, by which it was read. Yes or no, and
    what never settles: 1.
    """
    claim, measured = result.claim, result.measured
    if claim.quantity is None or result.verdict in ("reproduced", "met") and claim.relation != "about":
        return 0.0
    if measured is None:
        return largest   # the run failed
    if isinstance(claim.target, tuple):
        low, high = claim.target
        missed = max(low - measured, measured - high, 0.0) / (high - low)
    elif result.against is not None:
        missed = miss(claim, ratio(float(measured), result.against), claim.factor) / (MARGIN * claim.factor)
    elif claim.relation == "is":
        missed = 1.0
    else:
        target = float(claim.target or 0.0)
        missed = miss(claim, float(measured), target) / (MARGIN * abs(target))
        if claim.relation == "about":
            missed = (float(measured) - target) / max(SHARE * abs(target), half_digit(target, claim.digits or 1))
    # What never happens has no distance: whether a mover comes to rest in a band of 10 µm is decided by the last bits.
    return largest * math.tanh(missed / largest) if math.isfinite(missed) else math.copysign(1.0, missed)


def half_digit(target: float, digits: int) -> float:
    """Half a unit of the last significant digit of a printed figure; 0 for 0."""
    return 0.0 if target == 0.0 else 0.5 * 10.0 ** (math.floor(math.log10(abs(target))) - digits + 1)


@dataclass(frozen=True)
class Counts:
    """Verdicts on sentences (reproduced, within 10 %, not reproduced) and on bounds (met, not met)."""

    sentences: tuple[int, int, int]
    bounds: tuple[int, int]

    @property
    def text(self) -> tuple[str, str]:
        """Sentences as "3 / 1 / 2", bounds as "5 of 7"."""
        return " / ".join(map(str, self.sentences)), f"{self.bounds[0]} of {sum(self.bounds)}"


def counts(judged: Iterable[Judged]) -> Counts:
    results = [each.result for each in judged]
    words, axes = count_verdicts(sentences(results)), count_verdicts(results)
    return Counts((words["reproduced"], words["within 10 %"], words["not reproduced"]), (axes["met"], axes["not met"]))


def changed(before: Sequence[Judged], after: Sequence[Judged]) -> list[tuple[Judged, Judged]]:
    """Claims whose verdict differs, before and after; both in the same order."""
    return [(old, new) for old, new in zip(before, after, strict=True) if old.result.verdict != new.result.verdict]


def better(old: Verdict, new: Verdict) -> bool:
    order: tuple[Verdict, ...] = ("not run", "not reproduced", "not met", "within 10 %", "reproduced", "met")
    return order.index(new) > order.index(old)
