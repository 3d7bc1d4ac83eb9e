"""The axis of a run that touched a stop or made the controller trip."""

from collections.abc import Sequence
from math import inf

import numpy as np

from maglev.files.arrays import Array, Texts
from maglev.scenario.run_plan import Axis, RunPlan


def axes_furthest_off(plan: RunPlan, errors: Array, of: Sequence[bool] | None = None) -> Texts:
    """Return the axis of each run with the largest ratio of error to allowed error, by errors, shape (runs, axes).

    If `of` is given, only axes for which it is true count.
    """
    limits = np.array([plan.metrics.fail_error_of(axis) for axis in plan.axes.values()])
    shares = np.where([True] * len(limits) if of is None else of, np.abs(errors) / limits, -1.0)
    return np.array([*plan.axes], np.str_).take(shares.argmax(axis=1)) if len(limits) else np.repeat("", len(errors))


def axes_at_stops(plan: RunPlan, positions: Array, errors: Array) -> Texts:
    """Return the axis of each run that is at a stop, by positions and errors (m, rad) there, shape (runs, axes).

    It is the one nearest to its stops, or furthest beyond them. If none is beyond and other axes have their stops at
    the motors, it is the one of these that is furthest off.
    """
    stops = end_stops(plan)
    if not any(stops.values()):
        return axes_furthest_off(plan, errors)
    room = np.stack([np.minimum(positions[:, k] - stop[0], stop[1] - positions[:, k]) if stop else
                     np.full(len(positions), inf) for k, stop in enumerate(stops.values())], axis=1)
    nearest_stop: Texts = np.array([*plan.axes], np.str_).take(room.argmin(axis=1))
    if all(stops.values()):
        return nearest_stop
    others = axes_furthest_off(plan, errors, [stop is None for stop in stops.values()])
    return np.where(room.min(axis=1) <= 0.0, nearest_stop, others)


def end_stops(plan: RunPlan) -> dict[str, tuple[float, float] | None]:
    """Ends of travel (m) by axis, as a run starts with or as the description of the stage has it; None if not known."""
    described = {} if plan.stage is None else {axis.name: axis.stop for axis in plan.stage.axes}

    def ends(name: str, axis: Axis) -> tuple[float, float] | None:
        stop = described.get(name)
        if stop is None:
            return None
        fmu, _, variable = axis.position.partition(".")
        starts = plan.fmus[fmu].start if fmu in plan.fmus else {}
        lower, upper = (float(starts[key].value) if (key := f"{variable.rpartition('.')[0]}.stop.{end}") in starts else
                        value for end, value in (("lower", stop.lower), ("upper", stop.upper)))
        return lower, upper

    return {name: ends(name, axis) for name, axis in plan.axes.items()}
