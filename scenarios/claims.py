"""Claims of the thesis about one run, and the verdict on each."""

import math
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import Field, StrictBool, ValidationInfo, field_validator, model_validator

from scenarios.metrics import Metrics
from scenarios.quantity import parse_quantity, to_unit
from scenarios.toml_table import Metres, Table, key_refused

MetricName = Literal["settling_time", "overshoot", "steady_state_error", "tracking_mean", "tracking_peak",
                     "tracking_settling", "peak_current", "mean_current", "peak_command", "mean_command",
                     "stop_contact", "tripped", "failed"]
Verdict = Literal["reproduced", "within 10 %", "not reproduced", "not testable"]

# Metrics by what they are measured on, with the unit of plain numbers as targets.
STEP_METRICS = {"settling_time": "s", "overshoot": "1", "steady_state_error": "m"}
TRACKING_METRICS = {"tracking_mean": "m", "tracking_peak": "m", "tracking_settling": "s"}
MOTOR_METRICS = {"peak_current": "A", "mean_current": "A", "peak_command": "A", "mean_command": "A"}
RUN_METRICS = ("stop_contact", "tripped", "failed")
PRINTED_UNITS = {"s": "s", "1": "%", "m": "mm", "A": "A"}
UNITS = {**STEP_METRICS, **TRACKING_METRICS, **MOTOR_METRICS}

CLOSE = 0.1   # share of the target within which a missed claim is "within 10 %"


class Claim(Table):
    """One claim: that a metric has a relation to a target.

    "<" and ">" compare with the target. "is" compares a yes-or-no metric. "about" means that the
    measured value rounds to the figure as printed: it differs from the target by at most half a unit of the
    last of its `digits` significant digits.
    """

    text: str
    source: str
    metric: MetricName | None = None
    axes: list[str] | None = None
    motors: list[str] | None = None
    band: Metres | None = None
    relation: Literal["<", ">", "is", "about"] | None = None
    target: StrictBool | float | None = None
    digits: int | None = Field(default=None, ge=1)
    over: Literal["all", "any"] = "all"
    reason: str | None = None
    not_testable: str | None = None

    @model_validator(mode="before")
    @classmethod
    def single_names(cls, table: Any) -> Any:
        """Accept `axis` and `motor` for one name."""
        if not isinstance(table, dict):
            return table
        table = dict(table)
        for one, several in (("axis", "axes"), ("motor", "motors")):
            if one in table:
                if several in table:
                    raise key_refused(one, table[one], f"expected {one} or {several}, got both")
                table[several] = [table.pop(one)]
        return table

    @field_validator("target", mode="before")
    @classmethod
    def target_to_si(cls, value: Any, info: ValidationInfo) -> Any:
        """Convert to SI."""
        metric = info.data.get("metric")
        if metric in UNITS:
            return parse_quantity(value, UNITS[metric])
        if not isinstance(value, bool):
            raise ValueError(f"expected true or false for the metric {metric}")
        return value

    @model_validator(mode="after")
    def complete(self) -> "Claim":
        """Refuse a claim that lacks something its metric needs, or has something that means nothing to it."""
        if self.not_testable is None and self.metric is None:
            raise key_refused("metric", None, "expected a metric, or not_testable with the reason")
        if self.not_testable is not None and self.metric is not None:
            raise key_refused("not_testable", self.not_testable, "expected a metric or not_testable, got both")
        needed = set() if self.metric is None else {"relation", "target"}
        if self.metric == "settling_time":
            needed.add("band")
        if self.relation == "about":
            needed.add("digits")
        optional = {"motors"} if self.metric in MOTOR_METRICS else {"axes"} if self.measured_by_axis else set()
        kind = f"the metric {self.metric} {self.relation or ''}".rstrip()
        for key in ("relation", "target", "band", "digits", "axes", "motors"):
            value = getattr(self, key)
            if value is None and key in needed:
                raise key_refused(key, None, f"required for {kind}")
            if value is not None and key not in needed | optional:
                raise key_refused(key, value, f"has no meaning for {kind}")
        if self.metric is not None and (self.relation == "is") != (self.metric in RUN_METRICS):
            expected = "is" if self.metric in RUN_METRICS else "<, > or about"
            raise key_refused("relation", self.relation, f"expected {expected} for the metric {self.metric}")
        return self

    @property
    def measured_by_axis(self) -> bool:
        """Whether the metric belongs to an axis."""
        return self.metric in STEP_METRICS or self.metric in TRACKING_METRICS

    def printed(self, value: float | bool | None) -> str:
        """Print a value of the claim's metric with its unit."""
        if value is None:
            return ""
        if isinstance(value, bool):
            return "yes" if value else "no"
        if math.isinf(value):
            return "not settled"
        unit = PRINTED_UNITS[UNITS[str(self.metric)]]
        return f"{to_unit(value, unit):.3g} {unit}"

    @property
    def expectation(self) -> str:
        """What the claim says in short, such as "< 5 s"; empty if it is not testable."""
        return "" if self.metric is None else f"{self.relation} {self.printed(self.target)}"


@dataclass(frozen=True)
class ClaimResult:
    """A claim, the measured value that decides it (None if it is not testable), and the verdict."""

    claim: Claim
    measured: float | bool | None
    verdict: Verdict

    @property
    def measured_text(self) -> str:
        """The measured value with its unit, "not settled" where a band was not reached."""
        return self.claim.printed(self.measured)


def judge(claim: Claim, metrics: Metrics) -> ClaimResult:
    """Judge a claim on a run.

    Of several measured values (axes, motors, steps) the one that decides is reported: with `over` "all" the
    one that meets the claim worst, with "any" the one that meets it best. A numeric claim that is missed by at
    most 10 % of the target is "within 10 %".

    Raises
    ------
    ValueError
        If the run has nothing the claim could be judged on.
    """
    if claim.metric is None:
        return ClaimResult(claim, None, "not testable")
    if claim.metric in RUN_METRICS:
        happened = {"stop_contact": metrics.stop_contact is not None, "tripped": metrics.tripped is not None,
                    "failed": metrics.failed}[claim.metric]
        return ClaimResult(claim, happened, "reproduced" if happened == claim.target else "not reproduced")
    values = measured_values(claim, metrics)
    if not values:
        raise ValueError(f"claim {claim.text!r}: the run has no {claim.metric} to judge it on")
    target = float(claim.target or 0.0)
    measured = (max if claim.over == "all" else min)(values, key=lambda value: miss(claim, value, target))
    if meets(claim, measured, target):
        return ClaimResult(claim, measured, "reproduced")
    close = abs(measured - target) <= CLOSE * abs(target)
    return ClaimResult(claim, measured, "within 10 %" if close else "not reproduced")


def measured_values(claim: Claim, metrics: Metrics) -> list[float]:
    """Return the values of the claim's metric on its axes or motors."""
    name = str(claim.metric)
    if name in MOTOR_METRICS:
        return [getattr(motor, name) for motor in metrics.motors
                if claim.motors is None or motor.motor in claim.motors]
    if name in TRACKING_METRICS:
        attribute = name.removeprefix("tracking_")
        return [getattr(axis, attribute) for axis in metrics.tracking
                if claim.axes is None or axis.axis in claim.axes]
    steps = [step for step in metrics.steps if claim.axes is None or step.axis in claim.axes]
    if claim.band is not None:
        return [step.settling[claim.band] for step in steps]
    return [getattr(step, name) for step in steps]


def miss(claim: Claim, value: float, target: float) -> float:
    """Return how far the value is on the wrong side of the target; the larger, the worse."""
    if claim.relation == "<":
        return value - target
    if claim.relation == ">":
        return target - value
    return abs(value - target)


def meets(claim: Claim, value: float, target: float) -> bool:
    """Whether the value has the claimed relation to the target."""
    if claim.digits is None:
        return miss(claim, value, target) < 0.0
    if target == 0.0:
        return value == 0.0
    last_digit = 10.0 ** (math.floor(math.log10(abs(target))) - claim.digits + 1)
    # The factor lets a value exactly between two printed figures count in spite of binary rounding.
    return abs(value - target) <= 0.5 * last_digit * (1.0 + 1e-9)
