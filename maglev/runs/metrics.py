"""Metrics of a recorded run: settling, overshoot, tracking errors, disturbances, currents, losses, failure."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from maglev.files.arrays import Array, Bools, Texts
from maglev.files.errors import MeasurementError, nearest
from maglev.runs.flagged_axes import axes_at_stops, axes_furthest_off
from maglev.scenario.run_plan import Motor, RunPlan
from plant_fmu.winding import COPPER as COPPER

STEADY_SHARE = 0.1      # of a window, at its end
TRANSIENT = 1.1         # times the steady peak of the tracking error; what is beyond belongs to the transient
TIME_TOLERANCE = 1e-9   # s


@dataclass(frozen=True)
class StepResponse:
    """Response of one axis to one step of its own reference, from it to the next step of any axis or disturbance."""

    axis: str
    time: float                     # s, of the step
    start: float                    # m, of a rotation rad, reference before
    target: float                   # m, reference after
    settling_time: Mapping[float, float]   # band (m): s from the step to the last sample outside, inf = not settled
    overshoot: float                # share of the step size, 0.3 = 30 %
    steady_state_error: float       # m, mean |e| over the last 10 % of the window
    end: float = math.inf           # s, of the window: where the next one begins, or the last sample of the run
    cut_by: str = ""                # the event or input that ended the window; empty if the next step or the run did


@dataclass(frozen=True)
class TrackingError:
    axis: str
    mean_tracking_error: float   # m, mean |e| from `tracking_from` on
    peak_tracking_error: float   # m, largest |e| from `tracking_from` on
    tracking_transient: float    # s, last time |e| was beyond 1.1 times that peak; 0 if never


@dataclass(frozen=True)
class MotorCurrents:
    """Currents of one motor over the whole run, absolute values."""

    motor: str
    peak_current: float   # A, largest of the delivered phase currents
    mean_current: float   # A, mean of the phase with the largest mean
    peak_command: float   # A, largest command
    mean_command: float   # A, mean of the command with the largest mean


@dataclass(frozen=True)
class Deviation:
    """The effect of an event on one axis; the error is the position minus the reference."""

    of: str
    peak_deviation: float                  # m, of a rotation rad, largest |e|
    recovery_time: Mapping[float, float]   # band (m): s from the event to the last sample outside, inf = not back
    integral_absolute_error: float         # m s, ∫ |e| dt


@dataclass(frozen=True)
class Effort:
    """Currents and commands of a motor after an event."""

    of: str
    rms_current: float      # A, over the phases and the time
    ohmic_loss: float       # J, of all phases; NaN where their resistance is not known
    command_noise: float    # A, rms change from sample to sample over √2, of the command that changes most


@dataclass(frozen=True)
class EventResponse:
    """The response of a run in the window of an event, from its time to its end."""

    name: str
    time: float   # s
    end: float    # s, the last sample
    deviations: tuple[Deviation, ...]   # of each axis
    efforts: tuple[Effort, ...]         # of each motor


@dataclass(frozen=True)
class Metrics:
    """Everything measured on one run."""

    steps: tuple[StepResponse, ...]
    tracking: tuple[TrackingError, ...]   # empty without `tracking_from`
    motors: tuple[MotorCurrents, ...]
    end_errors: Mapping[str, float]       # m, |e| of each axis at the end
    stop_contact: float | None            # s, first time an end stop was touched, None = never
    tripped: float | None                 # s, first time the controller had tripped, None = never
    failed: bool                          # touched a stop, or tripped
    lost: tuple[float, ...] = ()          # s, times of the steps to setpoints that failed; a fall counts once
    rms_errors: Mapping[str, float] = field(default_factory=dict)   # m, of each axis over the whole run
    extremes: Mapping[str, tuple[float, float]] = field(default_factory=dict)   # lowest and highest by column, SI
    events: tuple[EventResponse, ...] = ()
    ended_off: Mapping[str, float] = field(default_factory=dict)    # m, end errors beyond `fail_error` by axis
    stop_axis: str = ""                   # the axis at the stop that was touched first, empty if none was
    trip_axis: str = ""                   # the axis that was furthest off at the trip


@dataclass(frozen=True)
class ManyMetrics:
    """The metrics of many runs with the same steps and events: each number is an array, shape (runs,)."""

    steps: tuple[StepResponse, ...]
    tracking: tuple[TrackingError, ...]
    motors: tuple[MotorCurrents, ...]
    end_errors: Mapping[str, Array]
    rms_errors: Mapping[str, Array]
    events: tuple[EventResponse, ...]
    stop_contact_time: Array   # s, inf = never
    trip_time: Array           # s, inf = never
    lost_setpoints: Array      # how many
    failed: Bools
    ended_off: Bools
    stop_axis: Texts           # as of `Metrics`
    trip_axis: Texts


def metrics_data(metrics: Metrics) -> dict[str, Any]:
    """Return metrics in JSON form, SI; null for a time without end, or of an event that never happened; bands as text.
    """
    def plain(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {str(key): plain(entry) for key, entry in value.items()}
        if isinstance(value, list | tuple):
            return [plain(entry) for entry in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    data: dict[str, Any] = plain(asdict(metrics))
    return data


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
    settings = plan.metrics
    positions = {axis: column(columns, names.position, len(time)) for axis, names in plan.axes.items()}
    references = {axis: column(columns, names.reference, len(time)) for axis, names in plan.axes.items()}
    bands = {axis: settings.bands_of(names) for axis, names in plan.axes.items()}
    fail_errors = {axis: settings.fail_error_of(names) for axis, names in plan.axes.items()}
    errors = {axis: positions[axis] - references[axis] for axis in plan.axes}
    end_errors = {axis: float(abs(error[-1])) for axis, error in errors.items()}
    flags = {flag: column(columns, flag, len(time)) != 0.0 for flag in (plan.stop_flag, plan.trip_flag) if flag}
    first_times = {flag: float(time[np.argmax(is_set)]) for flag, is_set in flags.items() if is_set.any()}
    stop_contact, tripped = first_times.get(plan.stop_flag or ""), first_times.get(plan.trip_flag or "")
    own_steps = {axis: step_samples(reference) for axis, reference in references.items()}
    cuts = disturbed_samples(plan, time)
    windows = step_windows(own_steps, cuts, len(time))
    return Metrics(
        steps=step_responses(time, positions, references, bands, own_steps, cuts, windows),
        lost=lost_setpoints(time, positions, references, [*flags.values()], fail_errors,
                            [window for window in windows if any(window[0] in steps for steps in own_steps.values())]),
        tracking=() if settings.tracking_from is None else tuple(
            tracking_error(axis, time, positions[axis], references[axis], settings.tracking_from)
            for axis in plan.axes),
        motors=tuple(MotorCurrents(motor,
                                   *peak_and_mean([column(columns, name, len(time)) for name in names.currents]),
                                   *peak_and_mean([column(columns, name, len(time)) for name in names.commands]))
                     for motor, names in plan.motors.items()),
        end_errors=end_errors,
        rms_errors={axis: math.sqrt(total(error ** 2) / len(time)) for axis, error in errors.items()},
        extremes=extremes_of(columns),
        events=event_responses(plan, time, columns, errors, resistances or {}) if plan.events else (),
        stop_contact=stop_contact,
        tripped=tripped,
        failed=stop_contact is not None or tripped is not None,
        ended_off={axis: error for axis, error in end_errors.items() if error > fail_errors[axis]},
        stop_axis="" if stop_contact is None else str(axes_at_stops(
            plan, at_first(flags[str(plan.stop_flag)], positions), at_first(flags[str(plan.stop_flag)], errors))[0]),
        trip_axis="" if tripped is None else str(axes_furthest_off(
            plan, at_first(flags[str(plan.trip_flag)], errors))[0]))


def at_first(flag: Bools, signals: Mapping[str, Array]) -> Array:
    """Signals of the axes at the first sample with a flag, shape (1, axes)."""
    return np.array([[values[np.argmax(flag)] for values in signals.values()]])


def columns_needed(plan: RunPlan) -> set[str]:
    """Names of the columns that `run_metrics` asks for; all others have extremes alone."""
    motors = plan.motors.values()
    return {*(name for axis in plan.axes.values() for name in (axis.position, axis.reference)),
            *(name for motor in motors for name in (*motor.currents, *motor.commands)),
            *(f"{winding_of(motor)}.rise" for motor in motors),
            *(flag for flag in (plan.stop_flag, plan.trip_flag) if flag is not None)}


def extremes_of(columns: Mapping[str, Array]) -> dict[str, tuple[float, float]]:
    """Lowest and highest value of each column of finite numbers; one that is not finite shows in them."""
    ends = {name: (float(values.min()), float(values.max())) for name, values in columns.items()
            if values.dtype == np.float64 and len(values)}
    return {name: both for name, both in ends.items() if all(map(math.isfinite, both))}


def column(columns: Mapping[str, Array], name: str, length: int) -> Array:
    """A column as float64; MeasurementError if it is missing, too short or long, or not finite."""
    if name not in columns:
        raise MeasurementError(f"missing column {name!r}; {nearest(name, columns)}")
    values = np.asarray(columns[name], dtype=np.float64)
    if values.shape != (length,):
        raise MeasurementError(f"column {name!r} has the shape {values.shape}, expected ({length},) as time has")
    # A NaN is outside of no band: it would settle at once.
    if not np.isfinite(values).all():
        raise MeasurementError(f"column {name!r} is not finite at sample {int(np.argmin(np.isfinite(values)))}")
    return values


def peak_and_mean(signals: Sequence[Array]) -> tuple[float, float]:
    """Return the largest absolute value of any signal, and the largest mean absolute value of one."""
    found = [(float(size.max()), total(size) / len(size)) for size in map(np.abs, signals)]
    return max((peak for peak, _ in found), default=0.0), max((mean for _, mean in found), default=0.0)


def step_samples(reference: Array) -> list[int]:
    """Return the samples at which a reference jumps from one held value to another.

    A reference that changes at neighbouring samples is moving, not stepping.
    """
    changed = np.diff(reference) != 0.0
    neighbours = np.zeros_like(changed)
    neighbours[1:] |= changed[:-1]
    neighbours[:-1] |= changed[1:]
    return [int(k) + 1 for k in np.flatnonzero(changed & ~neighbours)]


def step_responses(time: Array, positions: Mapping[str, Array], references: Mapping[str, Array],
                   bands: Mapping[str, Sequence[float]], own_steps: Mapping[str, Sequence[int]],
                   cuts: Mapping[int, str], windows: Sequence[tuple[int, int]]) -> tuple[StepResponse, ...]:
    """Measure every step of every axis, in order of time, each on the window that it begins; by axis."""
    responses = []
    for start, end in windows:
        for axis in [axis for axis, steps in own_steps.items() if start in steps]:
            before, target = float(references[axis][start - 1]), float(references[axis][start])
            error = positions[axis][start:end] - target
            beyond = float((error * math.copysign(1.0, target - before)).max())
            steady = max(1, round(STEADY_SHARE * len(error)))
            responses.append(StepResponse(
                axis, float(time[start]), before, target,
                {band: settling_time(time[start:end], error, band) for band in bands[axis]},
                max(0.0, beyond) / abs(target - before), total(np.abs(error[-steady:])) / steady,
                *window_end(time, end, own_steps, cuts)))
    return tuple(responses)


def disturbed_samples(plan: RunPlan, time: Array) -> dict[int, str]:
    """Return the samples with a disturbance of a run, with its name; for two at once that of the first."""
    cuts: dict[int, str] = {}
    for at, name in plan.disturbances:
        cuts.setdefault(int(np.searchsorted(time, at - TIME_TOLERANCE)), name)
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


def lost_setpoints(time: Array, positions: Mapping[str, Array], references: Mapping[str, Array],
                   flags: Sequence[Array], fail_errors: Mapping[str, float],
                   windows: Sequence[tuple[int, int]]) -> tuple[float, ...]:
    """Return the times (s) of the steps after which a flag was set or the error (by axis) at the end was too large.

    A fall counts once: a step that finds the stage lost already, by a flag or by its error, is no failure of its own.
    """
    def lost_at(k: int) -> bool:
        return (any(flag[k] for flag in flags)
                or any(abs(positions[axis][k] - references[axis][k]) > fail_errors[axis] for axis in references))

    return tuple(float(time[start]) for start, end in windows
                 if not lost_at(start - 1) and (lost_at(end - 1) or any(flag[start:end].any() for flag in flags)))


def settling_time(time: Array, error: Array, band: float) -> float:
    """Return the time (s) from the first sample to the last with |error| > band; inf if that is the very last."""
    outside = np.flatnonzero(np.abs(error) > band)
    if not len(outside):
        return 0.0
    last = int(outside[-1])
    return math.inf if last == len(error) - 1 else float(time[last] - time[0])


def tracking_error(axis: str, time: Array, position: Array, reference: Array, tracking_from: float) -> TrackingError:
    """Measure the tracking error from a time (s) on; MeasurementError if the run ends before."""
    error = np.abs(position - reference)
    steady = time >= tracking_from - TIME_TOLERANCE
    if not steady.any():
        raise MeasurementError(f"the run ends at {time[-1]} s, expected samples after tracking_from = "
                               f"{tracking_from} s")
    peak = float(error[steady].max())
    beyond = np.flatnonzero(error > TRANSIENT * peak)
    transient = float(time[beyond[-1]] - time[0]) if len(beyond) else 0.0
    return TrackingError(axis, total(error[steady]) / int(steady.sum()), peak, transient)


def event_responses(plan: RunPlan, time: Array, columns: Mapping[str, Array], errors: Mapping[str, Array],
                    resistances: Mapping[str, float]) -> tuple[EventResponse, ...]:
    """Measure every event of a plan by errors (m, rad of a rotation) by axis; see `run_metrics` for the rest."""
    responses = []
    ohms = {name: resistances.get(name, math.nan) * (
        1.0 + COPPER * columns.get(f"{winding_of(motor)}.rise", np.zeros(len(time))))
        for name, motor in plan.motors.items()}
    for event, until in zip(plan.events, plan.event_ends, strict=True):
        # The sample at the end belongs to what begins there, except for that at the end of the run.
        first, last = np.searchsorted(time, [event.time - TIME_TOLERANCE, until - TIME_TOLERANCE])
        inside = slice(int(first), len(time) if until >= time[-1] - TIME_TOLERANCE else int(last))
        if not len(time[inside]):
            raise MeasurementError(f"the run ends at {time[-1]} s, expected samples after the event {event.name!r} at "
                                   f"{event.time} s")
        responses.append(EventResponse(
            event.name, event.time, float(time[inside][-1]),
            tuple(event_deviation(axis, time[inside], errors[axis][inside], plan.metrics.bands_of(names))
                  for axis, names in plan.axes.items()),
            tuple(effort(motor, time[inside], [column(columns, name, len(time))[inside] for name in names.currents],
                         [column(columns, name, len(time))[inside] for name in names.commands], ohms[motor][inside])
                  for motor, names in plan.motors.items())))
    return tuple(responses)


def event_deviation(axis: str, time: Array, error: Array, bands: Sequence[float]) -> Deviation:
    """Measure the error (m, of a rotation rad) of an axis in the window of an event, which begins with it."""
    return Deviation(axis, float(np.abs(error).max()), {band: settling_time(time, error, band) for band in bands},
                     integral(time, np.abs(error)))


def effort(motor: str, time: Array, currents: Sequence[Array], commands: Sequence[Array], resistance: Array) -> Effort:
    """Measure currents and commands (A) of a motor, with the resistance (ohm) of a phase, in the window of an event.

    The noise of a command is the rms of its changes from sample to sample over √2 (von Neumann's mean square successive
    difference). For white noise it is the standard deviation, even on top of a slow course. For a sinusoid of amplitude
    A and frequency f, sampled every T, it is A |sin πfT|.
    """
    squares = np.sum(np.square(currents), axis=0) if currents else np.zeros(len(time))
    return Effort(motor, math.sqrt(total(squares) / len(squares) / max(1, len(currents))),
                  integral(time, resistance * squares),
                  max((math.sqrt(total(np.diff(command) ** 2) / (len(command) - 1) / 2.0) for command in commands
                       if len(command) > 1), default=0.0))


def integral(time: Array, values: Array) -> float:
    """Integral over time (s) by the trapezoidal rule."""
    return total((values[1:] + values[:-1]) * np.diff(time)) / 2.0


def total(values: Array) -> float:
    """Sum in the order of the samples, as one has it that is made while they come."""
    return float(np.add.accumulate(values)[-1]) if len(values) else 0.0


def larger_of(a: Any, b: Any) -> Any:
    """The larger one, of numbers as Python's `max` has it, of arrays (of one shape) each."""
    return (b if b > a else a) if isinstance(b, float | int) else np.where(b > a, b, a)


def winding_of(motor: Motor) -> str:
    """Return the plant's name for the winding of a motor, such as "plant.alpha.winding", by its currents."""
    return f"{motor.currents[0].rpartition('.')[0]}.winding" if motor.currents else ""


def phase_resistances(plan: RunPlan) -> Callable[[Mapping[str, Any]], dict[str, float]]:
    """Return the resistance of a phase (ohm, cold) of each motor if it is known, for one sample of a study.

    The sample's values are by `fmu.variable`. The others are those of the scenario's start values, or of the
    description of the stage. A replaced plant without such a parameter is taken for that stage.
    """
    described = {motor.name: motor.winding.resistance for motor in plan.stage.motors} if plan.stage is not None else {}
    known: dict[str, tuple[str, Any]] = {}   # by motor: what sets it, and its value without
    for name, motor in plan.motors.items():
        full = f"{winding_of(motor)}.resistance"
        fmu, _, variable = full.partition(".")
        start = plan.fmus[fmu].start.get(variable) if fmu in plan.fmus else None
        if motor.currents:
            known[name] = full, start.value if start is not None else described.get(name)

    def given(settings: Mapping[str, Any]) -> dict[str, float]:
        values = {name: settings.get(full, value) for name, (full, value) in known.items()}
        return {name: float(value) for name, value in values.items() if value is not None}

    return given
