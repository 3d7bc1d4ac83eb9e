"""Claims about runs: the values of a run's metrics that they are judged on."""

from collections.abc import Mapping, Sequence

from maglev.files.errors import MeasurementError, nearest
from maglev.runs.measures import measured_values
from maglev.runs.metrics import Metrics
from maglev.runs.verdicts import ClaimResult, MeasuredValue, Sides, judge
from maglev.scenario.claims import RunClaim


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
