"""Claims about runs: the values of a run's metrics that they are judged on."""

import math
from collections.abc import Mapping, Sequence

from maglev.errors import MeasurementError, nearest
from maglev.judging.metrics import Metrics
from maglev.judging.verdicts import ClaimResult, MeasuredValue, Sides, judge
from maglev.schema.claims import RunClaim
from maglev.schema.quantities import METRICS


def judge_run(claims: Sequence[RunClaim], metrics: Metrics | None,
              others: Mapping[str, Metrics | None]) -> list[ClaimResult]:
    """Judge the claims about a run; see `judge`.

    Parameters
    ----------
    claims : sequence of RunClaim
    metrics : Metrics or None
        Of the run; None if it did not complete.
    others : mapping of str to Metrics or None
        Of the runs that claims compare with, by name.

    Raises
    ------
    MeasurementError
        If the run has nothing that a claim could be judged on.
    """
    return [judge(claim, *measured(claim, metrics, others)) for claim in claims]


def measured(claim: RunClaim, metrics: Metrics | None, others: Mapping[str, Metrics | None]) -> Sides:
    """Values that a claim is about and, if it is comparative, those that it compares with, as `judge` takes them."""
    other = metrics if claim.than is None else others.get(claim.than)
    if claim.quantity is None or metrics is None or other is None:
        return None, None
    if claim.columns is not None:
        drawn = [metrics, *(others.get(run) for run in claim.together_with or ())]
        return None if None in drawn else [MeasuredValue(extreme(claim, [each for each in drawn if each]))], None
    here = metric_values(claim, metrics, claim.axes)
    if not here:
        hint = "" if claim.own else "; `claims = []` in the file leaves out the claims of what it extends"
        raise MeasurementError(f"claim {claim.text!r}: the run has no {claim.quantity} to judge it on{hint}")
    if not claim.comparative:
        return here, None
    if claim.than_axis is None:
        return here, metric_values(claim, other, None)
    # What is compared with another axis has its counterpart there, at the same step.
    return ([MeasuredValue(value, (claim.than_axis, time)) for value, (_, time) in here],
            metric_values(claim, other, [claim.than_axis]))


def extreme(claim: RunClaim, drawn: Sequence[Metrics]) -> float:
    """Extreme of the claim's columns over runs; MeasurementError if one was not recorded."""
    found = []
    for name in claim.columns or ():
        for metrics in drawn:
            if name not in metrics.extremes:
                raise MeasurementError(f"claim from {claim.source}: column = {name!r} was not recorded, nearest is "
                                       f"{nearest(name, metrics.extremes)}")
            found.append(metrics.extremes[name])
    lowest, highest = min(low for low, _ in found), max(high for _, high in found)
    return {"lowest": lowest, "highest": highest, "largest": max(-lowest, highest)}[str(claim.quantity)]


def metric_values(claim: RunClaim, metrics: Metrics, axes: Sequence[str] | None) -> list[MeasuredValue]:
    """Values of the claim's metric on the given axes or on the claim's motors; None for all."""
    name = str(claim.quantity)
    on = METRICS[name].on
    if on == "step":
        return [MeasuredValue(step.settling[claim.band] if claim.band is not None else getattr(step, name),
                              (step.axis, step.time)) for step in metrics.steps if axes is None or step.axis in axes]
    if on == "tracking":
        return [MeasuredValue(getattr(axis, name.removeprefix("tracking_")), (axis.axis, 0.0))
                for axis in metrics.tracking if axes is None or axis.axis in axes]
    if on == "motor":
        return [MeasuredValue(getattr(motor, name), (motor.motor, 0.0)) for motor in metrics.motors
                if claim.motors is None or motor.motor in claim.motors]
    return [MeasuredValue({"trip_time": math.inf if metrics.tripped is None else metrics.tripped,
                           "lost_setpoints": float(len(metrics.lost)),
                           "stop_contact": metrics.stop_contact is not None, "tripped": metrics.tripped is not None,
                           "failed": metrics.failed}[name])]
