"""Metrics of a recorded run: settling, overshoot, tracking errors, disturbances, currents, losses, failure."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, is_dataclass, replace
from typing import Any

import numpy as np

from maglev.files.arrays import Array, Bools, Texts
from maglev.files.errors import MeasurementError, nearest
from maglev.scenario.run_plan import Axis, Motor, RunPlan


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
    lost: Mapping[float, Bools]   # by times (s) of steps to setpoints, True for runs in which they failed
    stop_contact_time: Array   # s, inf = never
    trip_time: Array           # s, inf = never
    failed: Bools
    ended_off: Bools
    stop_axis: Texts           # as of `Metrics`
    trip_axis: Texts

    @property
    def lost_setpoints(self) -> Array:
        """Return how many steps to setpoints failed, by run."""
        return np.asarray(sum(self.lost.values(), np.zeros(len(self.failed))))


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


def metrics_of_one(plan: RunPlan, many: ManyMetrics, extremes: Mapping[str, tuple[float, float]]) -> Metrics:
    """Return the metrics of a run from those of many that are one, with the extremes of its columns."""
    one = of_one(many)
    contact, trip = (time if time < math.inf else None for time in (one.stop_contact_time, one.trip_time))
    return Metrics(one.steps, one.tracking, one.motors, one.end_errors, contact, trip, one.failed,
                   tuple(time for time, lost in one.lost.items() if lost), one.rms_errors, extremes, one.events,
                   {axis: error for axis, error in one.end_errors.items()
                    if error > plan.metrics.fail_error_of(plan.axes[axis])}, one.stop_axis, one.trip_axis)


def of_one(value: Any) -> Any:
    """A value with numbers where it has arrays of one."""
    if isinstance(value, np.ndarray):
        return value.item()
    if isinstance(value, Mapping):
        return {key: of_one(entry) for key, entry in value.items()}
    if isinstance(value, tuple):
        return tuple(of_one(entry) for entry in value)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{each.name: of_one(getattr(value, each.name)) for each in fields(value)})
    return value


def extremes_of(columns: Mapping[str, Array]) -> dict[str, tuple[float, float]]:
    """Lowest and highest value of each column of finite numbers; one that is not finite shows in them."""
    ends = {name: (float(values.min()), float(values.max())) for name, values in columns.items()
            if values.dtype == np.float64 and len(values)}
    return {name: both for name, both in ends.items() if all(map(math.isfinite, both))}


def finite_column(columns: Mapping[str, Array], name: str, length: int) -> Array:
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
    known: dict[str, tuple[str, Any]] = {}   # by motor: the parameter, and its value without the limit
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
                     np.full(len(positions), math.inf) for k, stop in enumerate(stops.values())], axis=1)
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
