"""What was measured on a run as rows of one shape, for tables and comparisons."""

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from math import inf
from typing import Any

from maglev.judging.metrics import Metrics, StepResponse
from maglev.schema.run_plan import RunPlan
from maglev.units import to_unit


@dataclass(frozen=True)
class Measure:
    """One number that was measured on a run; of every one, less is better.

    Attributes
    ----------
    quantity : str
        Such as "settling to 10 µm" or "peak phase current".
    of : str
        The axis or the motor.
    time : float or None
        s, of the step that it is about; None of the whole run.
    value : float
        SI; inf for what never came to an end.
    unit : str
        "s", "m", "rad", "A", or empty text of a share.
    """

    quantity: str
    of: str
    time: float | None
    value: float
    unit: str


def measures(plan: RunPlan, metrics: Metrics) -> tuple[Measure, ...]:
    """Every number of the metrics of a run: those of the whole run first, then those of each step."""
    return (*of_the_run(plan, metrics), *(measure for step in metrics.steps
                                           for measure in of_a_step(step, plan.axes[step.axis].unit)))


def measures_data(found: Iterable[Measure]) -> list[dict[str, Any]]:
    """Measures as JSON has them; null for what never came to an end."""
    return [{**asdict(each), "value": each.value if each.value < inf else None} for each in found]


def of_the_run(plan: RunPlan, metrics: Metrics) -> Iterator[Measure]:
    """Errors and currents over the whole run, as far as they were recorded; tracking errors from where they count."""
    for axis, error in metrics.rms_errors.items():
        yield Measure("rms error", axis, None, error, plan.axes[axis].unit)
    for axis, error in metrics.end_errors.items():
        yield Measure("error at the end", axis, None, error, plan.axes[axis].unit)
    for tracking in metrics.tracking:
        unit = plan.axes[tracking.axis].unit
        yield Measure("mean tracking error", tracking.axis, None, tracking.mean, unit)
        yield Measure("peak tracking error", tracking.axis, None, tracking.peak, unit)
        yield Measure("transient of tracking", tracking.axis, None, tracking.settling, "s")
    for motor in metrics.motors:
        if plan.motors[motor.motor].currents:
            yield Measure("peak phase current", motor.motor, None, motor.peak_current, "A")
            yield Measure("mean phase current", motor.motor, None, motor.mean_current, "A")
        if plan.motors[motor.motor].commands:
            yield Measure("peak command", motor.motor, None, motor.peak_command, "A")


def of_a_step(step: StepResponse, unit: str) -> Iterator[Measure]:
    """What was measured on one step of one axis, which is in m or rad."""
    for band, settling in step.settling.items():
        yield Measure(f"settling to {to_unit(band, f'u{unit}'):g} µ{unit}", step.axis, step.time, settling, "s")
    yield Measure("overshoot", step.axis, step.time, step.overshoot, "")
    yield Measure("steady-state error", step.axis, step.time, step.steady_state_error, unit)
