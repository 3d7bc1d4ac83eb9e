"""What the thesis says against what was measured: residuals for the fit, verdicts for the counts."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from maglev.judging.verdicts import ClaimResult, count_verdicts, least_ratio, miss, ratio, sentences

SHARE = 0.05      # standard deviation of a number that a run should have, as a share of it
DECADES = 3.0     # of what a number is that has nothing to do with the model
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
    if claim.quantity is None or (result.verdict in ("reproduced", "met") and claim.relation != "about"):
        return 0.0
    if measured is None:
        return largest   # the run failed
    if isinstance(claim.target, tuple):
        low, high = claim.target
        missed = max(low - measured, measured - high, 0.0) / (high - low)
    elif result.against is not None:
        missed = miss(claim, ratio(float(measured), result.against), least_ratio(claim)) / (MARGIN * claim.factor)
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


def log_likelihood(results: Sequence[ClaimResult], outliers: float) -> float:
    """Logarithm of how likely a sentence is, by what is measured for it on several tracks.

    A number: the density, for its logarithm, of a normal distribution with the mean and the variance of the tracks, and
    `SHARE` more, for it is printed with few digits; but a number may have nothing to do with the model, with the
    probability of `outliers`, and then be anything over three decades. Anything else: the share of tracks on which it
    reproduces, by Jeffreys's rule.
    """
    if results[0].claim.relation != "about":
        good = sum(result.verdict == "reproduced" for result in results)
        return math.log((good + 0.5) / (len(results) + 1.0))
    stated = results[0].claim.target
    target = math.log(stated) if isinstance(stated, float) else 0.0
    found = [math.log(value) if value is not None and 0.0 < value < math.inf else target + DECADES * math.log(10.0)
             for value in (result.measured for result in results)]
    mean = math.fsum(found) / len(found)
    variance = math.fsum((each - mean) ** 2 for each in found) / len(found) + SHARE ** 2
    density = math.exp(-(target - mean) ** 2 / (2.0 * variance)) / math.sqrt(2.0 * math.pi * variance)
    return math.log((1.0 - outliers) * density + outliers / (DECADES * math.log(10.0)))


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
    return Counts((words["reproduced"], words["within 10 %"],
                   words["no difference"] + words["not reproduced"]), (axes["met"], axes["not met"]))
