"""Metrics of runs side by side, measured a chunk of samples at a time: while the runs are made, or on a recording.

Sums go in the order of the samples, so that neither chunks nor other runs change a bit.
"""

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import reduce
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

import numpy as np

from maglev.files.arrays import Array, Bools, Texts
from maglev.files.errors import MeasurementError
from maglev.runs.metrics import (
    Deviation,
    Effort,
    EventResponse,
    ManyMetrics,
    Metrics,
    MotorCurrents,
    StepResponse,
    TrackingError,
    axes_at_stops,
    axes_furthest_off,
    extremes_of,
    finite_column,
    larger_of,
    metrics_of_one,
    winding_of,
)
from maglev.scenario.run_plan import RunPlan
from plant_fmu.winding import COPPER

STEADY_SHARE = 0.1      # of a window, at its end
TRANSIENT = 1.1         # times the steady peak of the tracking error; a larger error belongs to the transient
TIME_TOLERANCE = 1e-9   # s
CHUNK = 8000            # samples of all runs together, which stay in the processor's cache

# Of many runs, numbers are arrays, shape (runs,).
currents_of: Callable[..., MotorCurrents] = MotorCurrents
deviation_of: Callable[..., Deviation] = Deviation
effort_of: Callable[..., Effort] = Effort
step_of: Callable[..., StepResponse] = StepResponse
tracking_of: Callable[..., TrackingError] = TrackingError

State = dict[str, Array]   # what is known of runs, by name; the last dimension is that of runs


class Measuring:
    """The metrics to compute on runs of a plan at points of `time` (s); every n-th point of `kept` signals is stored.

    `names` are the variables that are looked at, in the order of the columns of a row; of these the `optional` ones may
    be missing, and then count as 0. Of `amounts`, in A, rows are looked at where there are events; else their sizes are
    enough, of which whoever makes the samples has the largest and the sum.
    """

    def __init__(self, plan: RunPlan, time: Array, kept: Sequence[str] = (), every: int = 1):
        self.plan, self.time, self.kept, self.every = plan, time, kept, every
        axes, motors = plan.axes.values(), plan.motors.values()
        flags = [flag for flag in (plan.stop_flag, plan.trip_flag) if flag is not None]
        self.flag_numbers = {flag: number for number, flag in enumerate(flags)}
        self.amounts = [name for motor in motors for name in (*motor.currents, *motor.commands)]
        self.optional = [f"{winding_of(motor)}.rise" for motor in motors]
        groups = ([axis.position for axis in axes], [axis.reference for axis in axes],
                  flags, kept, self.amounts if plan.events else (), self.optional if plan.events else ())
        self.names = [name for group in groups for name in group]
        ends = [0, *accumulate(map(len, groups))]
        self.positions, self.references, self.flags, self.rest, self.amount_columns, self.rises = (
            slice(first, last) for first, last in pairwise(ends))
        self.bands = [plan.metrics.bands_of(axis) for axis in axes]
        self.band_rows = np.full((max(map(len, self.bands), default=0), len(self.bands), 1), math.inf)
        for number, bands in enumerate(self.bands):
            self.band_rows[:len(bands), number, 0] = bands
        self.motors: list[tuple[str, range, range]] = []   # with the numbers of its currents and commands
        last = 0
        for name, motor in plan.motors.items():
            first, middle = last, last + len(motor.currents)
            last = middle + len(motor.commands)
            self.motors.append((name, range(first, middle), range(middle, last)))


class Meter:
    """Measures runs with steps at the same samples, as `references` by axis have them, shape (points,).

    MeasurementError if the runs end before an event, or before the tracking error is to be measured.
    """

    def __init__(self, measuring: Measuring, references: Mapping[str, Array]):
        self.measuring = measuring
        plan, time = measuring.plan, measuring.time
        points = len(time)
        self.own_steps = {axis: step_samples(reference) for axis, reference in references.items()}
        self.cuts = disturbed_samples(plan, time)
        self.windows = step_windows(self.own_steps, self.cuts, points)
        self.steady = [max(1, round(STEADY_SHARE * (end - start))) for start, end in self.windows]
        tracking_from = plan.metrics.tracking_from
        self.tracked = points if tracking_from is None else first_sample(time, tracking_from)
        if tracking_from is not None and self.tracked == points:
            raise MeasurementError(f"the run ends at {time[-1]} s, expected samples after tracking_from = "
                                   f"{tracking_from} s")
        # The sample at the end of an event belongs to the next one, except at the end of the run.
        self.events = [(first_sample(time, event.time),
                        points if until >= time[-1] - TIME_TOLERANCE else first_sample(time, until))
                       for event, until in zip(plan.events, plan.event_ends, strict=True)]
        for event, (first, last) in zip(plan.events, self.events, strict=True):
            if first >= last:
                raise MeasurementError(f"the run ends at {time[-1]} s, expected samples after the event {event.name!r} "
                                       f"at {event.time} s")
        self.apart = np.diff(time, prepend=time[0])[:, None, None]   # s, from the sample before
        self.state: State = {}

    def begin(self, resistances: Sequence[Mapping[str, float]]) -> None:
        """Begin to measure runs, for each of which there are resistances of a cold phase by motor, ohm."""
        measuring, runs = self.measuring, len(resistances)
        self.resistances = np.array([[own.get(motor, math.nan) for own in resistances]
                                     for motor, _, _ in measuring.motors]).reshape(-1, runs)
        bands, axes, _ = measuring.band_rows.shape
        motors, amounts, flags = len(measuring.motors), len(measuring.amounts), len(measuring.flag_numbers)
        shapes: list[tuple[float, str, tuple[int, ...]]] = [
            (0.0, "squares end tracking", (axes,)), (-math.inf, "peak", (axes,)), (-1.0, "beyond", (axes,)),
            (-1.0, "flag", (flags,)), (0.0, "flag_position flag_error", (flags, axes))]
        windows, events = len(self.windows), len(self.events)
        shapes += [(0.0, "before target steady error_before error_at_end", (windows, axes)),
                   (-math.inf, "highest", (windows, axes)), (math.inf, "lowest", (windows, axes)),
                   (-1.0, "outside", (windows, bands, axes)),
                   (0.0, "flag_before flag_at_end flagged", (windows, flags))]
        shapes += [(-math.inf, "deviation", (events, axes)), (0.0, "integral", (events, axes)),
                   (-1.0, "away", (events, bands, axes)), (0.0, "current_squares loss", (events, motors)),
                   (0.0, "changes", (events, amounts))]
        self.state = {name: np.full((*shape, runs), value) for value, names, shape in shapes for name in names.split()}
        points = len(measuring.time)
        self.sizes = np.empty((points if self.tracked < points else 0, axes, runs))   # |e|
        self.kept = np.empty((-(-points // measuring.every), len(measuring.kept), runs))

    def take(self, first: int, rows: Array) -> None:
        """Take in the samples from `first` on, shape (1 + samples, columns, runs): the one before stands above them."""
        with np.errstate(all="ignore"):   # what is no number shows in the end
            Chunk(self, first, rows).measure()

    def found(self, run: int, sizes: Array) -> "Found":
        """Return the results of one of the finished runs.

        `sizes` has sum and largest of the sizes of amounts, shape (amounts, 2).
        """
        state = {name: values[..., run] for name, values in self.state.items()} | {"sizes": sizes}
        return Found(self, state, self.kept[..., run])

    def metrics(self, found: Sequence[State]) -> ManyMetrics:
        """Return the metrics of finished runs."""
        state = {name: np.stack([each[name] for each in found], axis=-1) for name in found[0]}
        measuring = self.measuring
        plan, points = measuring.plan, len(measuring.time)
        contact, trip = (self.first(state, flag) for flag in (plan.stop_flag, plan.trip_flag))
        ends = dict(zip(plan.axes, np.abs(state["end"]), strict=True))
        off = [error > fail_error for error, fail_error in zip(ends.values(), self.fail_errors, strict=True)]
        peaks, means = state["sizes"][:, 1], state["sizes"][:, 0] / points
        return ManyMetrics(
            steps=tuple(self.steps(state)),
            tracking=() if self.tracked == points else tuple(
                tracking_of(axis, state["tracking"][i] / (points - self.tracked), state["peak"][i],
                            self.transient(state["beyond"][i])) for i, axis in enumerate(plan.axes)),
            motors=tuple(currents_of(motor, *(largest(values[k] for k in group) for group in (currents, commands)
                                              for values in (peaks, means)))
                         for motor, currents, commands in measuring.motors),
            end_errors=ends,
            rms_errors=dict(zip(plan.axes, np.sqrt(state["squares"] / points), strict=True)),
            events=tuple(self.responses(state)), lost=self.lost(state), stop_contact_time=contact, trip_time=trip,
            failed=(contact < math.inf) | (trip < math.inf),
            ended_off=np.any([*off, np.zeros(len(found), bool)], 0),
            stop_axis=self.axis_at(state, plan.stop_flag), trip_axis=self.axis_at(state, plan.trip_flag))

    @property
    def fail_errors(self) -> list[float]:
        """Error (m, rad) of each axis that is a failure."""
        plan = self.measuring.plan
        return [plan.metrics.fail_error_of(axis) for axis in plan.axes.values()]

    def axis_at(self, state: State, flag: str | None) -> Texts:
        """Axes on which runs first had a flag, of a stop or of the trip; empty without one."""
        plan, runs = self.measuring.plan, state["end"].shape[-1]
        if flag is None or not plan.axes:
            return np.full(runs, "")
        number = self.measuring.flag_numbers[flag]
        positions, errors = (state[name][number].T for name in ("flag_position", "flag_error"))
        return np.where(state["flag"][number] >= 0.0, axes_at_stops(plan, positions, errors) if flag == plan.stop_flag
                        else axes_furthest_off(plan, errors), "")

    def first(self, state: State, flag: str | None) -> Array:
        """Times of the first samples with a flag, s; inf without one."""
        if flag is None:
            return np.full(state["end"].shape[-1], math.inf)
        samples = state["flag"][self.measuring.flag_numbers[flag]]
        return np.where(samples < 0.0, math.inf, times_at(self.measuring.time, samples))

    def transient(self, beyond: Array) -> Array:
        """Times (s) of the last samples beyond the transient of tracking; 0 without one."""
        return np.where(beyond < 0.0, 0.0, times_at(self.measuring.time, beyond) - self.measuring.time[0])

    def settling(self, outside: Array, span: tuple[int, int], axis: int) -> dict[float, Any]:
        """Return the settling times (s) to each band of an axis, from the last samples outside, shape
        (bands, axes, runs).
        """
        return {band: settling_times(self.measuring.time, own, *span)
                for band, own in zip(self.measuring.bands[axis], outside[:, axis], strict=False)}

    def steps(self, state: State) -> Iterator[StepResponse]:
        """Responses of each axis to its own steps, with which windows begin."""
        time = self.measuring.time
        for number, (start, end) in enumerate(self.windows):
            for i, axis in enumerate(self.own_steps):
                if start in self.own_steps[axis]:
                    before, target = state["before"][number, i], state["target"][number, i]
                    yield step_of(axis, float(time[start]), before, target,
                                  self.settling(state["outside"][number], (start, end), i),
                                  overshoots(state["highest"][number, i], state["lowest"][number, i], target - before),
                                  state["steady"][number, i] / self.steady[number],
                                  *window_end(time, end, self.own_steps, self.cuts))

    def lost(self, state: State) -> dict[float, Bools]:
        """Return, by times (s) of steps, whether a flag was set in its window or the error at the end was too large.

        A fall counts once: a step that finds the stage lost already, by a flag or by its error, is no failure of its
        own.
        """
        limits = np.array(self.fail_errors)[:, None]

        def lost_at(number: int, when: str) -> Bools:
            return np.asarray((state[f"flag_{when}"][number] != 0.0).any(0)
                              | (np.abs(state[f"error_{when}"][number]) > limits).any(0))

        return {float(self.measuring.time[start]): ~lost_at(number, "before") & (
                    lost_at(number, "at_end") | state["flagged"][number].any(0))
                for number, (start, _) in enumerate(self.windows)
                if any(start in steps for steps in self.own_steps.values())}   # not what follows a disturbance

    def responses(self, state: State) -> Iterator[EventResponse]:
        """Return the responses of runs in the windows of events."""
        measuring = self.measuring
        for number, (event, (start, end)) in enumerate(zip(measuring.plan.events, self.events, strict=True)):
            found, samples = {name: state[name][number] for name in OF_EVENTS}, end - start
            noise = np.sqrt(found["changes"] / max(1, samples - 1) / 2.0)
            yield EventResponse(
                event.name, event.time, float(measuring.time[end - 1]),
                tuple(deviation_of(axis, found["deviation"][i], self.settling(found["away"], (start, end), i),
                                   found["integral"][i] / 2.0) for i, axis in enumerate(measuring.plan.axes)),
                tuple(effort_of(motor, np.sqrt(found["current_squares"][i] / samples / max(1, len(currents))),
                                found["loss"][i] / 2.0, largest(noise[k] for k in commands))
                      for i, (motor, currents, commands) in enumerate(measuring.motors)))


OF_EVENTS = ("deviation", "integral", "away", "current_squares", "loss", "changes")


class Found(NamedTuple):
    """The results of a run with their meter, and the rows of kept signals, shape (rows, signals).

    The metrics of many runs are made together, because those of one take as long.
    """

    meter: Meter
    state: State
    kept: Array

    @property
    def complete(self) -> bool:
        """Return True if all results are numbers."""
        return bool(np.isfinite(self.state["squares"]).all() and np.isfinite(self.state["sizes"]).all())


class Chunk:
    """Samples of runs from `first` to before `last`, in rows that begin with the sample before."""

    def __init__(self, meter: Meter, first: int, rows: Array):
        self.meter, self.first, self.last, self.rows = meter, first, first + len(rows) - 1, rows
        measuring = meter.measuring
        self.positions, self.references = rows[:, measuring.positions], rows[:, measuring.references]
        self.flags = rows[:, measuring.flags]
        self.errors = self.positions - self.references
        needed = meter.events or meter.tracked < len(measuring.time)
        self.sizes = np.abs(self.errors) if needed else self.errors

    def part(self, start: int, end: int) -> slice:
        """Rows of the samples from start to before end that are here."""
        begin = max(start, self.first)
        return slice(begin - self.first + 1, max(begin, min(end, self.last)) - self.first + 1)

    def measure(self) -> None:
        meter, state, measuring = self.meter, self.meter.state, self.meter.measuring
        points = len(measuring.time)
        now = slice(1, None)
        state["squares"] = added(state["squares"], self.errors[now] ** 2)
        state["end"] = self.errors[-1]
        if self.flags[now].any():
            self.note_flags()
        if meter.tracked < points:
            meter.sizes[self.first:self.last] = self.sizes[now]
            self.track(self.sizes[self.part(meter.tracked, points)])
        for number, window in enumerate(meter.windows):
            if window[0] < self.last and window[1] > self.first:
                self.measure_window(number, *window)
        going = [(number, *event) for number, event in enumerate(meter.events)
                 if event[0] < self.last and event[1] > self.first]
        if going:
            self.measure_events(going)
        if measuring.kept:
            chosen = self.rows[1 + -self.first % measuring.every::measuring.every, measuring.rest]
            first_kept = -(-self.first // measuring.every)
            meter.kept[first_kept:first_kept + len(chosen)] = chosen

    def note_flags(self) -> None:
        """Note where each flag was first set."""
        state, is_set = self.meter.state, self.flags[1:] != 0.0
        at = is_set.argmax(0)
        for flag, run in np.argwhere(is_set.any(0) & (state["flag"] < 0.0)).tolist():
            k = at[flag, run]
            state["flag"][flag, run] = self.first + k
            state["flag_position"][flag, :, run] = self.positions[1 + k, :, run]
            state["flag_error"][flag, :, run] = self.errors[1 + k, :, run]

    def track(self, sizes: Array) -> None:
        """Take in |e| from the time on from which the tracking error is measured."""
        meter, state = self.meter, self.meter.state
        if len(sizes):
            state["peak"] = np.maximum(state["peak"], sizes.max(0))
            state["tracking"] = added(state["tracking"], sizes.copy())
        if self.last == len(meter.measuring.time):
            state["beyond"] = last_with(meter.sizes > TRANSIENT * state["peak"], 0, state["beyond"])

    def measure_window(self, number: int, start: int, end: int) -> None:
        """Measure the positions, less the references at the start of a window, and the flags."""
        meter, state = self.meter, self.meter.state
        part = self.part(start, end)
        if start >= self.first:
            above = part.start - 1
            state["before"][number], state["target"][number] = self.references[above], self.references[part.start]
            state["error_before"][number], state["flag_before"][number] = self.errors[above], self.flags[above]
        off = self.positions[part] - state["target"][number]
        high, low = off.max(0), off.min(0)
        state["highest"][number] = np.maximum(state["highest"][number], high)
        state["lowest"][number] = np.minimum(state["lowest"][number], low)
        self.note_outside(state["outside"][number], off, np.maximum(high, -low), part)
        late = self.part(end - meter.steady[number], end)
        if late.stop > late.start:
            state["steady"][number] = added(state["steady"][number], np.abs(off[late.start - part.start:]))
        state["flagged"][number] = (state["flagged"][number] != 0.0) | (self.flags[part] != 0.0).any(0)
        state["error_at_end"][number] = self.errors[part.stop - 1]
        state["flag_at_end"][number] = self.flags[part.stop - 1]

    def measure_events(self, going: Iterable[tuple[int, int, int]]) -> None:
        """Measure the windows of events, with their numbers."""
        meter, state, measuring = self.meter, self.meter.state, self.meter.measuring
        amounts = self.rows[:, measuring.amount_columns]
        squares = np.zeros_like(self.rows[:, :len(measuring.motors)])
        for motor, (_, currents, _) in enumerate(measuring.motors):
            for k in currents:
                squares[:, motor] += amounts[:, k] ** 2
        losses = meter.resistances * (1.0 + COPPER * self.rows[:, measuring.rises]) * squares
        for number, start, end in going:
            part, later = self.part(start, end), self.part(start + 1, end)
            earlier = slice(later.start - 1, later.stop - 1)
            reach = self.sizes[part].max(0)
            state["deviation"][number] = np.maximum(state["deviation"][number], reach)
            self.note_outside(state["away"][number], self.sizes[part], reach, part)
            state["current_squares"][number] = added(state["current_squares"][number], squares[part].copy())
            if later.stop > later.start:
                apart = meter.apart[self.first + later.start - 1:self.first + later.stop - 1]
                for name, values in (("integral", self.sizes), ("loss", losses)):
                    state[name][number] = added(state[name][number], (values[later] + values[earlier]) * apart)
                state["changes"][number] = added(state["changes"][number], (amounts[later] - amounts[earlier]) ** 2)

    def note_outside(self, last: Array, off: Array, reach: Array, part: slice) -> None:
        """Note the last samples outside of each band in `last`, shape (bands, axes, runs); `reach` is max |off|.
        """
        bands = self.meter.measuring.band_rows
        if (reach > bands).any():
            last[:] = last_with(np.abs(off)[:, None] > bands, self.first + part.start - 1, last)


def run_metrics(plan: RunPlan, time: Array, columns: Mapping[str, Array],
                resistances: Mapping[str, float] | None = None) -> Metrics:
    """Measure a run at ascending times, s, (n,), by recorded columns, SI, (n,), by full name ("plant.y.position").

    The plan names the columns of axes, motors and flags, and the bands; `resistances` are those of a cold phase by
    motor, ohm, for losses. MeasurementError if there is no sample, the run ends before an event, a column is missing,
    of another length than time, or not finite.
    """
    time = np.asarray(time, dtype=np.float64)
    if time.ndim != 1 or not len(time):
        raise MeasurementError(f"time has the shape {time.shape}, expected at least one sample")
    measuring = Measuring(plan, time)
    known = [finite_column(columns, name, len(time)) if name in columns or name not in measuring.optional else
             np.zeros(len(time)) for name in measuring.names]
    amounts = [np.abs(finite_column(columns, name, len(time))) for name in measuring.amounts]
    sizes = np.array([(np.add.accumulate(each)[-1], each.max()) for each in amounts]).reshape(-1, 2)
    meter = Meter(measuring, dict(zip(plan.axes, known[measuring.references], strict=True)))
    meter.begin([resistances or {}])
    rows = np.zeros((len(known), 1 + min(CHUNK, len(time))))
    for first in range(0, len(time), CHUNK):
        rows[:, 0] = rows[:, -1]
        rows = rows[:, :1 + len(time) - first]
        for row, values in zip(rows, known, strict=True):
            row[1:] = values[first:first + CHUNK]
        meter.take(first, rows.T[:, :, None])
    return metrics_of_one(plan, meter.metrics([meter.found(0, sizes).state]), extremes_of(columns))


def added(before: Array, values: Array) -> Array:
    """Sum of `before` and of values, one after the other along the first dimension; it changes the first of these.

    `reduce` would add pairwise where these follow each other in memory.
    """
    values[0] += before
    one_after_the_other = values.strides[0] == values.itemsize
    return np.asarray(np.add.accumulate(values)[-1] if one_after_the_other else np.add.reduce(values))


def last_with(truths: Bools, first: int, before: Array) -> Array:
    """Last sample of each run with a truth, of those from `first` on; `before` where there is none."""
    if not truths.any():
        return before
    return np.where(truths.any(0), first + len(truths) - 1 - truths[::-1].argmax(0), before)


def settling_times(time: Array, outside: Array, start: int, end: int) -> Array:
    """Return the times (s) from sample `start` to the last one outside a band, -1 for none; inf if that is the last
    before `end`.
    """
    return np.where(outside < 0.0, 0.0, np.where(outside == end - 1, math.inf, times_at(time, outside) - time[start]))


def overshoots(highest: Array, lowest: Array, steps: Array) -> Array:
    """Return the farthest ways beyond the reference as shares of the steps, from positions less the reference."""
    return np.asarray(np.maximum(np.where(steps > 0.0, highest, -lowest), 0.0) / np.abs(steps))


def times_at(time: Array, samples: Array) -> Array:
    """Times (s) of samples; of -1, which stands for none, that of the first."""
    return np.asarray(time[np.maximum(samples, 0.0).astype(np.int64)])


def largest(values: Iterable[Array]) -> Any:
    """The largest of each run; 0 without any."""
    return reduce(larger_of, values, 0.0)


def first_sample(time: Array, at: float) -> int:
    """First sample at a time (s) or later."""
    return int(np.searchsorted(time, at - TIME_TOLERANCE))


def step_samples(reference: Array) -> list[int]:
    """Return the samples at which a reference jumps from one held value to another.

    A reference that changes at neighbouring samples is moving, not stepping.
    """
    changed = np.diff(reference) != 0.0
    neighbours = np.zeros_like(changed)
    neighbours[1:] |= changed[:-1]
    neighbours[:-1] |= changed[1:]
    return [int(k) + 1 for k in np.flatnonzero(changed & ~neighbours)]


def disturbed_samples(plan: RunPlan, time: Array) -> dict[int, str]:
    """Return the samples with a disturbance of a run, with its name; for two at once that of the first."""
    cuts: dict[int, str] = {}
    for at, name in plan.disturbances:
        cuts.setdefault(first_sample(time, at), name)
    cuts.pop(len(time), None)   # after the end of the run
    return cuts


def step_windows(own_steps: Mapping[str, Collection[int]], cuts: Collection[int],
                 length: int) -> list[tuple[int, int]]:
    """Return the first sample of each stretch of a run from its first step on, and the one behind its last.

    A stretch begins with a step of any axis or with a cut, and ends where the next one begins.
    """
    steps = set().union(*own_steps.values())
    starts = sorted(steps | {cut for cut in cuts if cut > min(steps, default=length)})
    return list(zip(starts, [*starts[1:], length], strict=False))


def window_end(time: Array, end: int, own_steps: Mapping[str, Collection[int]],
               cuts: Mapping[int, str]) -> tuple[float, str]:
    """Return the time (s) at which a stretch ends, by the sample after it, and the name of its cut, or empty text."""
    cut = "" if any(end in steps for steps in own_steps.values()) else cuts.get(end, "")
    return float(time[min(end, len(time) - 1)]), cut
