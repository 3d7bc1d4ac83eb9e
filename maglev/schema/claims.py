"""Claims of the thesis about a run, or about one run against another, as a scenario states them."""

import math
from abc import abstractmethod
from typing import Any, Literal

from pydantic import Field, StrictBool, ValidationInfo, field_validator, model_validator

from maglev.schema.toml_table import Metres, Table, key_refused
from maglev.units import parse_quantity, to_unit

MetricName = Literal["settling_time", "overshoot", "steady_state_error", "tracking_mean", "tracking_peak",
                     "tracking_settling", "peak_current", "mean_current", "peak_command", "mean_command",
                     "trip_time", "lost_setpoints", "stop_contact", "tripped", "failed"]

# Metrics by what they are measured on, with the unit of plain numbers as targets; None: a count.
STEP_METRICS = {"settling_time": "s", "overshoot": "1", "steady_state_error": "m"}
TRACKING_METRICS = {"tracking_mean": "m", "tracking_peak": "m", "tracking_settling": "s"}
MOTOR_METRICS = {"peak_current": "A", "mean_current": "A", "peak_command": "A", "mean_command": "A"}
RUN_METRICS = {"trip_time": "s", "lost_setpoints": None}
YES_NO_METRICS = ("stop_contact", "tripped", "failed")
PRINTED_UNITS = {"s": "s", "1": "%", "m": "mm", "A": "A"}
UNITS = {**STEP_METRICS, **TRACKING_METRICS, **MOTOR_METRICS, **RUN_METRICS}


class Statement(Table):
    """What every claim has: words, where they stand, and a relation between what is measured and what is claimed.

    "<" and ">" compare with the target. "is" compares a yes-or-no metric. "about" means that the
    measured value rounds to the figure as printed: it differs from the target by at most half a unit of the
    last of its `digits` significant digits.
    """

    text: str
    source: str
    relation: Literal["<", ">", "is", "about"] | None = None
    digits: int | None = Field(default=None, ge=1)
    factor: float = Field(default=1.0, gt=0.0)
    over: Literal["all", "any", "mean"] = "all"
    reason: str | None = None         # why it is not reproduced
    remark: str | None = None         # what a reader should know whatever the verdict
    not_testable: str | None = None   # why

    @property
    @abstractmethod
    def comparative(self) -> bool:
        """Whether the claim compares two measured values."""

    @abstractmethod
    def printed(self, value: float | bool | None) -> str:
        """Print a measured value with its unit."""

    @property
    @abstractmethod
    def criterion(self) -> str:
        """What is measured and what it should be, such as "settling time to 0.1 mm < 5 s"; empty if not testable."""


class Claim(Statement):
    """One claim about a run: that a metric has a relation to a target, or to the same metric elsewhere.

    A claim with `than`, the name of another run, or `than_axis`, another axis, compares with `factor` times what was
    measured there: on the same axis (or that other one) at the same step, or by motor.
    """

    metric: MetricName | None = None
    axes: list[str] | None = None
    motors: list[str] | None = None
    band: Metres | None = None
    target: StrictBool | float | None = None
    than: str | None = None
    than_axis: str | None = None

    @model_validator(mode="before")
    @classmethod
    def single_names(cls, table: Any) -> Any:
        """Accept `axis` and `motor` for one name."""
        return listed(table, axis="axes", motor="motors")

    @field_validator("target", mode="before")
    @classmethod
    def target_to_si(cls, value: Any, info: ValidationInfo) -> Any:
        """Convert to SI."""
        metric = info.data.get("metric")
        if metric in UNITS:
            return parse_quantity(value, UNITS[metric] or "1")
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
        needed = set() if self.metric is None else {"relation"} if self.comparative else {"relation", "target"}
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
        expected = ("is",) if self.metric in YES_NO_METRICS else ("<", ">") if self.comparative else ("<", ">", "about")
        if self.metric is not None and self.relation not in expected:
            raise key_refused("relation", self.relation, f"expected {' or '.join(expected)} for {kind}")
        if self.comparative and (self.metric is None or self.metric in YES_NO_METRICS):
            raise key_refused("than", self.than or self.than_axis, "expected a metric that is a number")
        if self.than_axis is not None and not self.measured_by_axis:
            raise key_refused("than_axis", self.than_axis, f"has no meaning for {kind}")
        if self.factor != 1.0 and not self.comparative:
            raise key_refused("factor", self.factor, "has no meaning without than or than_axis")
        return self

    @property
    def comparative(self) -> bool:
        """Whether the claim compares two measured values."""
        return self.than is not None or self.than_axis is not None

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
            return "never" if self.metric == "trip_time" else "not settled"
        unit = UNITS[str(self.metric)]
        return f"{value:g}" if unit is None else f"{to_unit(value, PRINTED_UNITS[unit]):.3g} {PRINTED_UNITS[unit]}"

    @property
    def criterion(self) -> str:
        """What is measured and what it should be, such as "settling time to 0.1 mm < 5 s"; empty if not testable."""
        if self.metric is None:
            return ""
        band = "" if self.band is None else f" to {to_unit(self.band, 'mm'):g} mm"
        subject = f"{self.metric.replace('_', ' ')}{band} {self.relation}"
        if not self.comparative:
            return f"{subject} {self.printed(self.target)}"
        factor = "" if self.factor == 1.0 else f"{self.factor:g} × "
        place = " of ".join(([self.than_axis] if self.than_axis else []) + ([self.than] if self.than else []))
        return f"{subject} {factor}{place}"


def listed(table: Any, **plurals: str) -> Any:
    """Table of a claim with lists in place of single names, given as singular=plural; both are refused."""
    if not isinstance(table, dict):
        return table
    table = dict(table)
    for one, several in plurals.items():
        if one in table:
            if several in table:
                raise key_refused(one, table[one], f"expected {one} or {several}, got both")
            table[several] = [table.pop(one)]
    return table
