"""Measured values of a run as rows of one shape, for claims, tables, comparisons and studies."""

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from math import inf
from typing import Any, NamedTuple

import numpy as np

from maglev.runs.metrics import ManyMetrics, Metrics
from maglev.scenario.quantities import METRICS, metric_text, printed
from maglev.scenario.run_plan import RunPlan


@dataclass(frozen=True)
class Measure:
    """One measured number of a run. For all numbers of an axis or a motor, less is better.

    Attributes
    ----------
    quantity : str
        Name as in the table of quantities, with the band of a settling time, such as "settling time to 10 µm".
    of : str
        The axis or the motor; empty of the whole run.
    time : float or None
        s, of the step or event that it is about; None of the whole run.
    value : float
        SI; inf for a time without end, or of an event that never happened; 1 and 0 for yes and no.
    unit : str
        "s", "m", "rad", "m.s", "A", "1" of a share, …, or empty text of a count and of yes and no.
    event : str
        Name of the event that it is about; empty otherwise.
    """

    quantity: str
    of: str
    time: float | None
    value: float
    unit: str
    event: str = ""

    @property
    def text(self) -> str:
        """Value with its unit."""
        return metric_text(self.quantity, self.value, self.unit)


class Value(NamedTuple):
    """A value of a metric of the table: of which axis or motor, at which step or event (s), to which band.

    Of many runs it is an array, shape (runs,).
    """

    of: str
    value: Any
    time: float | None = None
    band: float | None = None
    event: str = ""


def measured_values(metrics: Metrics | ManyMetrics, name: str) -> Iterator[Value]:
    """Every value, SI, of a metric of the table but those of columns; name as Python has it."""
    on = METRICS[name].on
    if on == "axis":
        yield from (Value(axis, error) for axis, error in getattr(metrics, f"{name}s").items())
    elif on == "tracking":
        yield from (Value(tracking.axis, getattr(tracking, name)) for tracking in metrics.tracking)
    elif on == "motor":
        yield from (Value(motor.motor, getattr(motor, name)) for motor in metrics.motors)
    elif on == "step":
        for step in metrics.steps:
            measured = getattr(step, name)
            yield from (Value(step.axis, value, step.time, band) for band, value in
                        (measured.items() if name == "settling_time" else [(None, measured)]))
    elif on in ("event", "effort"):
        for event in metrics.events:
            for part in event.deviations if on == "event" else event.efforts:
                measured = getattr(part, name)
                yield from (Value(part.of, value, event.time, band, event.name) for band, value in
                            (measured.items() if name == "recovery_time" else [(None, measured)])
                            if not np.isnan(value).all())
    elif on == "run":
        yield Value("", getattr(metrics, name) if isinstance(metrics, ManyMetrics) else {
            "failed": metrics.failed, "ended_off": bool(metrics.ended_off),
            "trip_time": inf if metrics.tripped is None else metrics.tripped,
            "stop_contact_time": inf if metrics.stop_contact is None else metrics.stop_contact,
            "lost_setpoints": float(len(metrics.lost)), "tripped": metrics.tripped is not None,
            "stop_contact": metrics.stop_contact is not None}[name])


def measures_of(plan: RunPlan, metrics: Metrics) -> tuple[Measure, ...]:
    """Every number of the metrics of a run, in the order of the table; of currents as far as they were recorded."""
    return tuple(Measure(words, of, time, float(value), unit, event)
                 for words, of, time, value, unit, event in numbers(plan, metrics))


def numbers(plan: RunPlan, metrics: Metrics | ManyMetrics) -> Iterator[tuple[str, str, float | None, Any, str, str]]:
    """Yield the fields of each `Measure`; for many runs the value is an array, shape (runs,)."""
    for name, quantity in METRICS.items():
        if name in ("tripped", "stop_contact"):   # in the times of stop and trip
            continue
        for of, value, time, band, event in measured_values(metrics, name):
            axis_unit = plan.axes[of].unit if quantity.of_axes else ""
            if not quantity.of_motors or getattr(plan.motors[of], quantity.recorded):
                yield (quantity.words + ("" if band is None else f" to {printed(band, axis_unit)}"), of, time, value,
                       quantity.unit_on(axis_unit), event)


def measures_data(measures: Iterable[Measure]) -> list[dict[str, Any]]:
    """Return measures in JSON form; null for a time without end, or of an event that never happened."""
    return [{**asdict(measure), "value": measure.value if measure.value < inf else None} for measure in measures]
