"""Metrics of a run computed while it runs: those of `run_metrics` on its recording, bit for bit, without a recording.

The C of `measuring.c` looks at the columns that metrics need, at every communication point. This module turns its
results into metrics.
"""

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from ctypes import Structure, c_double, c_int64, c_void_p
from functools import cached_property, reduce
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from maglev.files.arrays import Array, Texts
from maglev.runs.flagged_axes import axes_at_stops, axes_furthest_off
from maglev.runs.metrics import (
    COPPER,
    STEADY_SHARE,
    TIME_TOLERANCE,
    TRANSIENT,
    Deviation,
    Effort,
    EventResponse,
    ManyMetrics,
    MotorCurrents,
    StepResponse,
    TrackingError,
    disturbed_samples,
    larger_of,
    step_samples,
    step_windows,
    winding_of,
    window_end,
)
from maglev.scenario.run_plan import RunPlan

Structs = npt.NDArray[np.void]

SOURCE = Path(__file__).with_name("measuring.c")


# Of many runs, numbers are arrays, shape (runs,).
currents_of: Callable[..., MotorCurrents] = MotorCurrents
deviation_of: Callable[..., Deviation] = Deviation
effort_of: Callable[..., Effort] = Effort
step_of: Callable[..., StepResponse] = StepResponse
tracking_of: Callable[..., TrackingError] = TrackingError


class Observer(Structure):
    """The struct observer: the struct given of measuring.c, which describes its members, and the results."""

    _fields_ = (("points", c_int64), ("step", c_double), ("bands", c_void_p), ("windows", c_int64),
                ("starts", c_void_p), ("steady", c_void_p), ("tracking", c_int64), ("errors", c_void_p),
                ("events", c_int64), ("event_starts", c_void_p), ("event_ends", c_void_p), ("resistances", c_void_p),
                ("every", c_int64), ("kept", c_void_p), ("keeping", c_int64),
                ("meter", c_void_p), ("whole", c_void_p), ("of_windows", c_void_p), ("of_events", c_void_p))


class Measuring:
    """The metrics to compute on runs of a plan at points of `time` (s); every n-th point of `kept` signals is stored.
    """

    def __init__(self, plan: RunPlan, time: Array, kept: Sequence[str] = (), every: int = 1):
        self.plan, self.time, self.kept, self.every = plan, time, kept, every
        self.axes = list(plan.axes)
        self.flags = [flag for flag in (plan.stop_flag, plan.trip_flag) if flag is not None]
        self.amounts = [name for motor in plan.motors.values() for name in (*motor.currents, *motor.commands)]
        self.bands = [plan.metrics.bands_of(names) for names in plan.axes.values()]
        self.columns = max(map(len, self.bands), default=1) or 1   # of bands

    def motors(self) -> Iterator[tuple[str, range, range]]:
        """Each motor with the numbers of its currents and of its commands."""
        last = 0
        for name, motor in self.plan.motors.items():
            first, middle = last, last + len(motor.currents)
            last = middle + len(motor.commands)
            yield name, range(first, middle), range(middle, last)

    def source(self) -> str:
        """C of the observer, for `block_loop`."""
        sizes = {"AXES": len(self.axes), "BANDS": self.columns, "MOTORS": len(self.plan.motors),
                 "AMOUNTS": len(self.amounts), "FLAGS": len(self.flags), "KEPT": len(self.kept)}
        groups = [f"{{{currents.start}, {commands.start}, {commands.stop}}}" for _, currents, commands in self.motors()]
        defined = "".join(f"#define {name} {size or 1}\n" for name, size in sizes.items())
        text = SOURCE.read_text(encoding="utf-8").replace("{copper}", repr(COPPER)).replace(
            "{transient}", repr(TRANSIENT))
        return f"{defined}#define AMOUNTS_OF {{{', '.join(groups) or '{0, 0, 0}'}}}\n\n{text}"

    def seen(self, recorded: Collection[str]) -> dict[str, str]:
        """Variable by member of the struct seen; `recorded` are those that there are."""
        plan = self.plan
        fields = {f"{kind}[{i}]": getattr(axis, kind) for i, axis in enumerate(plan.axes.values())
                  for kind in ("position", "reference")}
        fields |= {f"amount[{i}]": name for i, name in enumerate(self.amounts)}
        fields |= {f"rise[{i}]": name for i, motor in enumerate(plan.motors.values())
                   if (name := f"{winding_of(motor)}.rise") in recorded}
        fields |= {f"flag[{i}]": name for i, name in enumerate(self.flags)}
        return fields | {f"kept[{i}]": name for i, name in enumerate(self.kept)}

    @cached_property
    def form(self) -> dict[str, np.dtype[np.void]]:
        """Return the forms of the structs of results, of numbers alone."""
        axes, motors, amounts, flags = (max(1, len(group)) for group in (self.axes, self.plan.motors, self.amounts,
                                                                         self.flags))
        banded = axes * self.columns

        def struct(**fields: int) -> np.dtype[np.void]:
            return np.dtype([(name, np.float64, (size,)) for name, size in fields.items()])

        window = struct(highest=axes, lowest=axes, steady=axes, outside=banded, end=axes, flagged=flags,
                        flag_at_end=flags)
        return {"whole": struct(squares=axes, end=axes, tracking=axes, peak=axes, beyond=axes, highest=amounts,
                                sum=amounts, flag=flags, flag_position=flags * axes, flag_error=flags * axes,
                                before=axes, flag_before=flags),
                "window": window,
                "event": struct(peak=axes, integral=axes, outside=banded, squares=motors, loss=motors, changes=amounts),
                "meter": np.dtype([("window", np.int64), ("present", window),
                                   ("rest", np.float64, (2 * axes + amounts + motors,))])}


class Meter:
    """Memory for the runs of one loop, one after the other: the inputs of the metrics, and their results.

    `references` are those of each axis, m or rad, shape (points,).
    """

    def __init__(self, measuring: Measuring, references: Mapping[str, Array]):
        self.measuring = measuring
        plan, time, form = measuring.plan, measuring.time, measuring.form
        points = len(time)
        self.own_steps = {axis: {start: (float(reference[start - 1]), float(reference[start]))
                                 for start in step_samples(reference)} for axis, reference in references.items()}
        self.cuts = disturbed_samples(plan, time)
        self.windows = step_windows(self.own_steps, self.cuts, points)
        self.steady = [max(1, round(STEADY_SHARE * (end - start))) for start, end in self.windows]
        self.tracked = int(np.searchsorted(time, plan.metrics.tracking_from - TIME_TOLERANCE)) \
            if plan.metrics.tracking_from is not None else points
        self.events = [(int(first), points if until >= time[-1] - TIME_TOLERANCE else int(last))
                       for event, until in zip(plan.events, plan.event_ends, strict=True)
                       for first, last in [np.searchsorted(time, [event.time - TIME_TOLERANCE,
                                                                  until - TIME_TOLERANCE])]]
        axes = max(1, len(measuring.axes))
        bands = np.full((axes, measuring.columns), np.inf)
        for row, own in zip(bands, measuring.bands, strict=False):   # there is a row where there is no axis, too
            row[:len(own)] = own
        whole = np.int64
        self.arrays: dict[str, npt.NDArray[Any]] = {
            "bands": bands, "starts": np.array([*(start for start, _ in self.windows), points], whole),
            "steady": np.array([end - steady for (_, end), steady in zip(self.windows, self.steady, strict=True)],
                               whole),
            "event_starts": np.array([first for first, _ in self.events], whole),
            "event_ends": np.array([last for _, last in self.events], whole),
            "resistances": np.full(max(1, len(plan.motors)), math.nan)}
        if self.tracked < points:
            self.arrays["errors"] = np.empty((axes, points))
        if measuring.kept:
            self.arrays["kept"] = np.empty((len(range(0, points, measuring.every)), len(measuring.kept)))
        self.whole = np.zeros(1, form["whole"])
        self.found_windows = np.zeros(len(self.windows), form["window"])
        self.found_events = np.zeros(len(self.events), form["event"])
        self.meter = np.zeros(1, form["meter"])
        self.observer = Observer(
            points, float(time[1] - time[0]) if points > 1 else 0.0, windows=len(self.windows), tracking=self.tracked,
            events=len(self.events), every=measuring.every, keeping=bool(measuring.kept),
            meter=self.meter.ctypes.data, whole=self.whole.ctypes.data, of_windows=self.found_windows.ctypes.data,
            of_events=self.found_events.ctypes.data, **{name: array.ctypes.data for name, array in self.arrays.items()})

    def resist(self, resistances: Mapping[str, float]) -> None:
        """Measure the next run with resistances of the phases by motor, ohm."""
        for i, motor in enumerate(self.measuring.plan.motors):
            self.arrays["resistances"][i] = resistances.get(motor, math.nan)

    def found(self) -> "Found | None":
        """Return the results of the finished run; None if one of them is not a number."""
        if not complete(self.whole).all():
            return None
        kept = self.arrays.get("kept")
        return Found(self, self.whole.copy(), self.found_windows[None, :].copy(), self.found_events[None, :].copy(),
                     None if kept is None else kept.copy())

    def metrics(self, whole: Structs, windows: Structs, events: Structs) -> ManyMetrics:
        """Return the metrics of runs, for each those of `run_metrics`.

        Of the forms of `Measuring`: shape (runs,), (runs, windows) and (runs, events).
        """
        measuring = self.measuring
        plan, points = measuring.plan, len(measuring.time)
        contact, trip = (self.first(whole, flag) for flag in (plan.stop_flag, plan.trip_flag))
        ends = {axis: np.abs(whole["end"][:, i]) for i, axis in enumerate(measuring.axes)}
        lost = [error > self.fail_error(axis) for axis, error in ends.items()]
        motors = [currents_of(motor, *(value for group in (currents, commands) for value in (
            largest(whole["highest"][:, i] for i in group), largest(whole["sum"][:, i] / points for i in group))))
            for motor, currents, commands in measuring.motors()]
        return ManyMetrics(
            steps=tuple(self.steps(windows)),
            tracking=() if self.tracked == points else tuple(
                tracking_of(axis, whole["tracking"][:, i] / (points - self.tracked), whole["peak"][:, i],
                            self.transient(whole["beyond"][:, i])) for i, axis in enumerate(measuring.axes)),
            motors=tuple(motors), end_errors=ends,
            rms_errors={axis: np.sqrt(whole["squares"][:, i] / points) for i, axis in enumerate(measuring.axes)},
            events=tuple(self.responses(events)),
            lost_setpoints=self.lost(whole, windows), stop_contact_time=contact, trip_time=trip,
            failed=(contact < math.inf) | (trip < math.inf), ended_off=np.any([*lost, np.zeros(len(whole), bool)], 0),
            stop_axis=self.axis_at(whole, plan.stop_flag), trip_axis=self.axis_at(whole, plan.trip_flag))

    def axis_at(self, whole: Structs, flag: str | None) -> Texts:
        """Axes on which runs first had a flag, of a stop or of the trip; empty without one."""
        if flag is None or not self.measuring.axes:
            return np.full(len(whole), "")
        number, plan, axes = self.measuring.flags.index(flag), self.measuring.plan, len(self.measuring.axes)
        positions, errors = (whole[name].reshape(len(whole), -1, axes)[:, number]
                             for name in ("flag_position", "flag_error"))
        is_set = whole["flag"][:, number] >= 0.0
        positions, errors = (np.where(is_set[:, None], values, 0.0) for values in (positions, errors))
        return np.where(is_set, axes_at_stops(plan, positions, errors) if flag == plan.stop_flag else
                        axes_furthest_off(plan, errors), "")

    def fail_error(self, axis: str) -> float:
        """Error (m, rad) of an axis that is a failure."""
        plan = self.measuring.plan
        return plan.metrics.fail_error_of(plan.axes[axis])

    def first(self, whole: Structs, flag: str | None) -> Array:
        """Times of the first samples with a flag, s; inf without one."""
        if flag is None:
            return np.full(len(whole), math.inf)
        samples = whole["flag"][:, self.measuring.flags.index(flag)]
        return np.where(samples < 0.0, math.inf, self.measuring.time[as_indices(samples)])

    def transient(self, beyond: Array) -> Array:
        """Times (s) of the last samples beyond the transient of tracking; 0 without one."""
        time = self.measuring.time
        return np.where(beyond < 0.0, 0.0, time[as_indices(beyond)] - time[0])

    def settling(self, outside: Array, spans: Sequence[tuple[int, int]]) -> list[list[dict[float, Any]]]:
        """Settling times (s) of spans, of axes, by band, from the last samples outside, shape (runs, spans, …)."""
        measuring, time = self.measuring, self.measuring.time
        starts, ends = np.array(spans, np.int64).reshape(-1, 2, 1).transpose(1, 0, 2)
        settled = np.where(outside < 0.0, 0.0, np.where(outside == ends - starts - 1, math.inf,
                                                        time[starts + as_indices(outside)] - time[starts]))
        return [[{band: settled[:, k, axis * measuring.columns + i] for i, band in enumerate(bands)}
                 for axis, bands in enumerate(measuring.bands)] for k in range(len(spans))]

    def steps(self, windows: Structs) -> Iterator[StepResponse]:
        """Responses of each axis to its own steps, with which windows begin."""
        settled = self.settling(windows["outside"], self.windows)
        steady = windows["steady"] / np.array(self.steady)[:, None]
        for number, (start, end) in enumerate(self.windows):
            for i, axis in enumerate(self.measuring.axes):
                if start in self.own_steps[axis]:
                    before, target = self.own_steps[axis][start]
                    beyond = windows["highest"][:, number, i] if target > before else -windows["lowest"][:, number, i]
                    yield step_of(axis, float(self.measuring.time[start]), before, target, settled[number][i],
                                  larger_of(0.0, beyond) / abs(target - before), steady[:, number, i],
                                  *window_end(self.measuring.time, end, self.own_steps, self.cuts))

    def lost(self, whole: Structs, windows: Structs) -> Array:
        """Return the number of steps after which the stage was lost."""
        limits = np.array([self.fail_error(axis) for axis in self.measuring.axes])

        def is_lost(errors: Array, flags: Array) -> npt.NDArray[np.bool_]:
            return np.asarray((flags != 0.0).any(1) | (np.abs(errors) > limits).any(1))

        count, was_lost = np.zeros(len(whole)), is_lost(whole["before"], whole["flag_before"])
        for (start, _), window in zip(self.windows, windows.T, strict=True):
            now_lost = is_lost(window["end"], window["flag_at_end"])
            if any(start in steps for steps in self.own_steps.values()):   # not what follows a disturbance
                count += ~was_lost & (now_lost | window["flagged"].any(1))
            was_lost = now_lost
        return count

    def responses(self, windows: Structs) -> Iterator[EventResponse]:
        """Return the responses of runs in the windows of events."""
        measuring, recovered = self.measuring, self.settling(windows["outside"], self.events)
        for number, (event, (start, end)) in enumerate(zip(measuring.plan.events, self.events, strict=True)):
            found, samples = windows[:, number], end - start
            yield EventResponse(
                event.name, event.time, float(measuring.time[end - 1]),
                tuple(deviation_of(axis, found["peak"][:, i], recovered[number][i], found["integral"][:, i] / 2.0)
                      for i, axis in enumerate(measuring.axes)),
                tuple(effort_of(motor, np.sqrt(found["squares"][:, i] / samples / max(1, len(currents))),
                                found["loss"][:, i] / 2.0,
                                largest(np.sqrt(found["changes"][:, k] / (samples - 1) / 2.0) for k in commands
                                        if samples > 1))
                      for i, (motor, currents, commands) in enumerate(measuring.motors())))


class Found(NamedTuple):
    """The results of a run with their meter, in the forms that `Meter.metrics` takes, and the rows of kept signals.

    The metrics of many runs are made together, because those of one take as long.
    """

    meter: Meter
    whole: Structs
    windows: Structs
    events: Structs
    kept: Array | None


def complete(whole: Structs) -> npt.NDArray[np.bool_]:
    """Return True for each run of which all results are numbers."""
    return np.asarray(np.isfinite(whole["squares"]).all(1) & np.isfinite(whole["sum"]).all(1))


def largest(values: Iterable[Array]) -> Any:
    """The largest of each run; 0 without any."""
    return reduce(larger_of, values, 0.0)


def as_indices(samples: Array) -> npt.NDArray[np.int64]:
    """Samples as indices; -1, for none, as 0."""
    return np.maximum(samples, 0.0).astype(np.int64)
