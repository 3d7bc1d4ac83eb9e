"""Verdicts on claims."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar

from maglev.errors import MeasurementError
from maglev.judging.metrics import Metrics
from maglev.schema.claims import MOTOR_METRICS, RUN_METRICS, TRACKING_METRICS, YES_NO_METRICS, Claim, Statement

Verdict = Literal["reproduced", "within 10 %", "not reproduced", "not testable", "not run"]
VERDICTS: tuple[Verdict, ...] = ("reproduced", "within 10 %", "not reproduced", "not testable", "not run")

CLOSE = 0.1   # share of the target within which a missed claim is "within 10 %"

T = TypeVar("T")

Place = tuple[str, float]      # axis or motor, and time of the step (s), 0 where there is none
Placed = tuple[Place, float]   # a measured value and where


@dataclass(frozen=True)
class ClaimResult:
    """A claim, the measured value that decides it, and the verdict.

    Attributes
    ----------
    claim : Statement
    measured : float, bool or None
        None if the claim is not testable or a run is missing.
    verdict : str
    against : float or None
        What a comparative claim compares the measured value with.
    """

    claim: Statement
    measured: float | bool | None
    verdict: Verdict
    against: float | None = None

    @property
    def measured_text(self) -> str:
        """The measured value with its unit, "not settled" where a band was not reached."""
        own = self.claim.printed(self.measured)
        return own if self.against is None else f"{own} against {self.claim.printed(self.against)}"

    @property
    def note(self) -> str:
        """Why the claim is not reproduced or not testable, and a remark; empty if nothing is known or needed."""
        if self.verdict == "not run":
            return ""
        why = {"not testable": self.claim.not_testable, "not reproduced": self.claim.reason}.get(self.verdict)
        return "; ".join(part for part in (why, self.claim.remark) if part)


Judgements = Mapping[str, Sequence[ClaimResult]]   # claims with their verdicts, by name of the run


def judge(claim: Claim, metrics: Metrics | None, others: Mapping[str, Metrics | None] | None = None) -> ClaimResult:
    """Judge a claim on a run.

    Of several measured values (axes, motors, steps) the one that decides is reported: with `over` "all" the
    one that meets the claim worst, with "any" the one that meets it best; with "mean" it is their mean. A numeric
    claim that is missed by at most 10 % of its figure, the target or the factor, is "within 10 %".

    Parameters
    ----------
    claim : Claim
    metrics : Metrics or None
        Of the run; None if it did not complete.
    others : mapping of str to Metrics or None
        Of the runs that claims compare with, by name.

    Raises
    ------
    MeasurementError
        If the run has nothing the claim could be judged on.
    """
    if claim.metric is None:
        return ClaimResult(claim, None, "not testable")
    other = metrics if claim.than is None else (others or {}).get(claim.than)
    if metrics is None or other is None:
        return ClaimResult(claim, None, "not run")
    if claim.metric in YES_NO_METRICS:
        happened = {"stop_contact": metrics.stop_contact is not None, "tripped": metrics.tripped is not None,
                    "failed": metrics.failed}[claim.metric]
        return ClaimResult(claim, happened, "reproduced" if happened == claim.target else "not reproduced")
    values = measured_values(claim, metrics, claim.axes)
    if not values:
        raise MeasurementError(f"claim {claim.text!r}: the run has no {claim.metric} to judge it on")
    if claim.comparative:
        return compare(claim, values, measured_values(claim, other, [claim.than_axis] if claim.than_axis else None))
    return against_target(claim, [value for _, value in values], float(claim.target or 0.0))


def against_target(claim: Statement, values: Sequence[float], target: float) -> ClaimResult:
    """Judge a claim with a target on measured values."""
    measured = decisive(claim, values, mean, lambda value: miss(claim, value, target))
    if meets(claim, measured, target):
        return ClaimResult(claim, measured, "reproduced")
    close = abs(measured - target) <= CLOSE * abs(target)
    return ClaimResult(claim, measured, "within 10 %" if close else "not reproduced")


def compare(claim: Claim, values: Sequence[Placed], others: Sequence[Placed]) -> ClaimResult:
    """Judge a comparative claim on what was measured here and there."""
    there = dict(others)
    pairs = [(value, there[claim.than_axis or name, time]) for (name, time), value in values
             if (claim.than_axis or name, time) in there]
    if not pairs:
        raise MeasurementError(f"claim {claim.text!r}: {claim.than or 'the run'} has no {claim.metric} at the same "
                               "place")
    return against_each_other(claim, pairs)


def against_each_other(claim: Statement, pairs: Sequence[tuple[float, float]]) -> ClaimResult:
    """Judge a comparative claim on pairs of what was measured here and there."""
    measured, against = decisive(
        claim, pairs, lambda all_pairs: (mean([own for own, _ in all_pairs]), mean([other for _, other in all_pairs])),
        lambda pair: miss(claim, ratio(*pair), claim.factor))
    share = ratio(measured, against)
    if miss(claim, share, claim.factor) < 0.0:
        return ClaimResult(claim, measured, "reproduced", against)
    # "More" and "less" name no figure that could be missed by little.
    close = claim.factor != 1.0 and abs(share - claim.factor) <= CLOSE * claim.factor
    return ClaimResult(claim, measured, "within 10 %" if close else "not reproduced", against)


def decisive(claim: Statement, items: Sequence[T], average: Callable[[Sequence[T]], T],
                missed_by: Callable[[T], float]) -> T:
    """Return the item that decides a claim."""
    if claim.over == "mean":
        return average(items)
    return (max if claim.over == "all" else min)(items, key=missed_by)


def mean(values: Sequence[float]) -> float:
    """Return the mean."""
    return sum(values) / len(values)


def ratio(value: float, other: float) -> float:
    """Return value / other; 1 if both are 0 or both infinite."""
    if value == other:
        return 1.0
    return value / other if other != 0.0 else math.inf


def measured_values(claim: Claim, metrics: Metrics, axes: Sequence[str] | None) -> list[Placed]:
    """Return the values of the claim's metric and their places, on the given axes or the claim's motors (None: all)."""
    name = str(claim.metric)
    if name in RUN_METRICS:
        value = len(metrics.lost) if name == "lost_setpoints" else metrics.tripped
        return [(("", 0.0), math.inf if value is None else float(value))]
    if name in MOTOR_METRICS:
        return [((motor.motor, 0.0), getattr(motor, name)) for motor in metrics.motors
                if claim.motors is None or motor.motor in claim.motors]
    if name in TRACKING_METRICS:
        attribute = name.removeprefix("tracking_")
        return [((axis.axis, 0.0), getattr(axis, attribute)) for axis in metrics.tracking
                if axes is None or axis.axis in axes]
    steps = [step for step in metrics.steps if axes is None or step.axis in axes]
    return [((step.axis, step.time), step.settling[claim.band] if claim.band is not None else getattr(step, name))
            for step in steps]


def miss(claim: Statement, value: float, target: float) -> float:
    """Return how far the value is on the wrong side of the target; the larger, the worse."""
    if claim.relation == "<":
        return value - target
    if claim.relation == ">":
        return target - value
    return abs(value - target)


def meets(claim: Statement, value: float, target: float) -> bool:
    """Whether the value has the claimed relation to the target."""
    if claim.digits is None:
        return miss(claim, value, target) < 0.0
    if target == 0.0:
        return value == 0.0
    last_digit = 10.0 ** (math.floor(math.log10(abs(target))) - claim.digits + 1)
    # The factor lets a value exactly between two printed figures count in spite of binary rounding.
    return abs(value - target) <= 0.5 * last_digit * (1.0 + 1e-9)
