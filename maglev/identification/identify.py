"""From a recording to constants: velocities, estimator, diagnostics, replay, and what the model leaves out of them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import exp, pi

import numpy as np

from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from maglev.arrays import Array
from maglev.errors import IdentificationError
from maglev.identification.diagnostics import RowDiagnostics, diagnose, unidentified, warnings_of
from maglev.identification.estimators import Estimate, run_estimator
from maglev.identification.recording import MotionRecording
from maglev.identification.rigs import RowData, accelerations, functions, regressors
from maglev.identification.settings import EPSILON, GAMMA
from plant_fmu.ripple import RIPPLE_PHASE, SHORTEST_RIPPLE
from pmlsm.rig import RigAxis

HORIZON = 0.05      # s; open loop the vertical axis is unstable, with rates of 20 to 45 1/s
WINDOWS = 50        # at most, spread over the recording
SMOOTHING = 0.02    # s, of the states that a replay starts from
Again = Callable[[Sequence[RowData]], Mapping[str, float]]   # constants of an estimator that sees other rows


@dataclass(frozen=True)
class Identification:
    """An estimate with what is known about it; errors, replays and shares by constant or axis."""

    recording: MotionRecording
    estimate: Estimate
    guess: dict[str, float]
    matched: bool   # whether y and u went through the observer's filters
    diagnostics: dict[str, RowDiagnostics]
    standard_error: dict[str, float]   # the scatter to expect from another recording, no more
    with_friction: dict[str, float]
    # bound of what friction, bias, ripple and modulation do to it, see `left_out`; infinite where not excited
    left_out: dict[str, float]
    replay_error: Array   # m, shape (axes,), see `replay`; as the next one
    replay_motion: Array
    warnings: list[str]
    unidentified: list[str]   # constants that the recording does not tell

    def __repr__(self) -> str:
        constants = ", ".join(f"{name} = {value:.6g}" for name, value in self.estimate.final.items())
        return f"<Identification of {self.recording.rig.name}: {constants}; {len(self.warnings)} warnings>"

    @property
    def uncertainty(self) -> dict[str, float]:
        """How far each constant may be from the true one: two standard errors, and what is left out."""
        return {name: 2.0 * error + self.left_out[name] for name, error in self.standard_error.items()}


def identify(recording: MotionRecording, method: str = "reduced", epsilon: float = EPSILON, gamma: float = GAMMA,
             guess: Mapping[str, float] | None = None, match: bool = False, velocities: Array | None = None,
             q0: float | None = None) -> Identification:
    """Estimate the constants of a rig from a recording; see `run_estimator` for method, ε, γ and Q0.

    A `guess` has initial values; those of the estimator FMU are for constants that it does not name. `match` puts
    positions and currents through the filters that the observer's velocity has gone through. `velocities` are in m/s,
    shape (n, axes), by default those of the high-gain observer. IdentificationError if no axis is excited, or as of
    `run_estimator`.
    """
    rig, dt = recording.rig, recording.dt
    start = {**rig.guess, **(guess or {})}
    seen = observed(recording.positions, dt) if velocities is None else velocities
    positions, i_d, i_q = recording.positions, recording.i_d, recording.i_q
    if match:
        positions, i_d, i_q = (matched(signal, dt) for signal in (positions, i_d, i_q))
    rows = regressors(rig, positions, i_d, i_q, seen)

    def estimated(seen_rows: Sequence[RowData]) -> Estimate:
        return run_estimator(method, seen_rows, recording.time, start, epsilon, gamma, q0)

    estimates = estimated(rows)
    travel = np.ptp(recording.positions, axis=0).tolist()
    diagnostics = {data.row.axis: diagnose(data, way, recording.time, estimates)
                   for data, way in zip(rows, travel, strict=False)}   # tilts have no row of constants
    if not any(diagnosis.excited for diagnosis in diagnostics.values()):
        ways = ", ".join(f"{axis} {1e3 * way:.3g} mm" for axis, way in zip(rig.axes, travel, strict=True))
        raise IdentificationError(f"no axis is excited: they move over {ways}, expected motion on all axes, as with "
                                  "the excitation of sections 4.3.1 and 5.3, and currents that change")
    errors: dict[str, float] = {}
    friction: dict[str, float] = {}
    warnings: list[str] = []
    unknown: list[str] = []
    for data in rows:
        diagnosis = diagnostics[data.row.axis]
        errors.update(zip(data.row.constants, diagnosis.standard_error.tolist(), strict=True))
        friction.update(zip(data.row.constants, diagnosis.with_friction.tolist(), strict=True))
        warnings += warnings_of(data, diagnosis, estimates)
        unknown += unidentified(data, diagnosis, estimates)
    error, motion = replay(recording, estimates.final)
    # True velocities are what they are; observed ones lag, whether the rows do so with them or not.
    bound = left_out(recording, rows, partial(matched, dt=dt) if velocities is None else np.asarray, estimates.final,
                     lambda others: estimated(others).final)
    bound |= {name: np.inf for data in rows if not diagnostics[data.row.axis].excited for name in data.row.constants}
    return Identification(recording, estimates, start, match, diagnostics, errors, friction, bound, error, motion,
                          sorted(warnings), sorted(unknown))


def observer_filter(dt: float) -> ObserverFilter:
    """Filter shares of the high-gain observer at a sample time (s)."""
    shares = ObserverFilter()
    shares.prepare(dt)
    return shares


def observed(positions: Array, dt: float) -> Array:
    """Velocities (m/s) by the high-gain observer of Fig. 4.7, of positions (m) with shape (n, axes)."""
    shares = observer_filter(dt)
    velocities = np.empty_like(positions)
    for axis in range(positions.shape[1]):
        observer = VelocityObserver()
        observer.seed(float(positions[0, axis]))
        path = []
        for measured in positions[:, axis].tolist():
            observer.update(measured, shares, dt)
            path.append(observer.velocity)
        velocities[:, axis] = path
    return velocities


def matched(signals: Array, dt: float) -> Array:
    """Signals, shape (n, m), through the two low-pass filters that the observer's velocity has gone through.

    They begin at the first sample. What the observer's derivative is of the measured position, it is exactly of a
    signal that has gone through this: the delay is the same on both sides of velocity' = A θ + b.
    """
    from scipy.signal import lfilter  # see behind_lag

    shares = observer_filter(dt)
    for share in (shares.share1, shares.share2):
        signals, _ = lfilter([share], [1.0, share - 1.0], signals, axis=0, zi=(1.0 - share) * signals[:1])
    return np.asarray(signals)


def replay(recording: MotionRecording, constants: Mapping[str, float]) -> tuple[Array, Array]:
    """Replay windows of a recording from its states, with its currents.

    RMS of replayed − recorded position at the end of the windows, and of the way that the axes go in one, m, (axes,).
    """
    from scipy.signal import savgol_filter

    dt = recording.dt
    steps = max(1, round(HORIZON / dt))
    window = max(5, 2 * round(0.5 * SMOOTHING / dt) + 1)
    positions = savgol_filter(recording.positions, window, 3, axis=0)
    velocities = savgol_filter(recording.positions, window, 3, deriv=1, delta=dt, axis=0)
    # The filter is one-sided at the ends.
    first = np.linspace(window, len(positions) - 1 - steps - window, WINDOWS)
    starts = np.unique(first[first >= 0].astype(int))
    if len(starts) == 0:
        starts = np.array([0])
    x, v = positions[starts], velocities[starts]
    known = dict(constants)
    for k in range(steps):
        at = starts + k
        i_d, i_q = recording.i_d[at], recording.i_q[at]
        middle_d, middle_q = 0.5 * (i_d + recording.i_d[at + 1]), 0.5 * (i_q + recording.i_q[at + 1])
        half = accelerations(recording.rig, x, i_d, i_q, known)
        v_middle = v + 0.5 * dt * half
        full = accelerations(recording.rig, x + 0.5 * dt * v, middle_d, middle_q, known)
        x, v = x + dt * v_middle, v + dt * full
    there = positions[starts + steps]
    return rms(x - there), rms(there - positions[starts])


def rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))


def left_out(recording: MotionRecording, rows: Sequence[RowData], delayed: Callable[[Array], Array],
             constants: Mapping[str, float], again: Again) -> dict[str, float]:
    """How far constants could be off by what the model leaves out: a bound, by constant.

    The recording is identified again by a model that has one of the effects, of the size that the description of the
    stage assumes, along the recorded motion; the changes by all effects are added whatever their signs. The estimator
    `again` found `found` in the rows; `delayed` is what the velocities have gone through, of signals with shape (n, m).
    """
    bound = dict.fromkeys(constants, 0.0)
    for changed in rows_by_effect(recording, rows, delayed):
        for name, value in again(changed).items():
            bound[name] += abs(value - constants[name])
    return bound


def rows_by_effect(recording: MotionRecording, rows: Sequence[RowData],
                     delayed: Callable[[Array], Array]) -> Iterator[list[RowData]]:
    """The rows of models that have one of the effects, each in turn, as far as the stage has it."""
    described = recording.rig.described
    for effect in (friction, bias, ripple):
        added = np.stack([effect(axis, x, data.velocity) for axis, x, data in
                          zip(described.axes, recording.positions.T, rows, strict=False)], axis=1)
        if added.any():
            yield [replace(data, b=data.b + part) for data, part in zip(rows, delayed(added).T, strict=True)]
    if described.modulation:
        yield modulated(recording, rows, delayed)


def friction(axis: RigAxis, x: Array, velocity: Array) -> Array:
    """Acceleration (m/s²) by the guide, as of `plant_fmu.guide`, at positions (m) and velocities (m/s)."""
    guide, deflection, path = axis.friction, 0.0, [0.0]
    on = guide.presliding > 0.0 and guide.coulomb > 0.0
    for way in np.diff(x).tolist():
        if way and on:   # w' = v/δ (1 − w sgn v), exact along a way in one direction
            end = 1.0 if way > 0.0 else -1.0
            deflection = end + (deflection - end) * exp(-abs(way) / guide.presliding)
        path.append(deflection)
    return -(guide.coulomb * np.array(path) + guide.viscous * velocity) / axis.mass


def bias(axis: RigAxis, x: Array, _velocity: Array) -> Array:
    """Constant acceleration (m/s²) of an axis."""
    return np.full(len(x), axis.bias)


def ripple(axis: RigAxis, x: Array, _velocity: Array) -> Array:
    """Periodic acceleration (m/s²) of an axis, as of `plant_fmu.ripple`."""
    if axis.ripple.amplitude == 0.0 or axis.ripple.period < SHORTEST_RIPPLE:
        return np.zeros(len(x))
    return np.asarray(axis.ripple.amplitude * np.sin(2.0 * pi * x / axis.ripple.period + RIPPLE_PHASE))


def modulated(recording: MotionRecording, rows: Sequence[RowData], delayed: Callable[[Array], Array]) -> list[RowData]:
    """Rows with the attraction of each motor times 1 − k sin²(π d/t1), as of `plant_fmu.attraction`."""
    rig, k = recording.rig, recording.rig.described.modulation
    f = functions(rig, recording.positions)
    pitches = np.array([of.slot_pitch for of in rig.geometries.values()])
    factor = 1.0 - k * np.sin(pi * recording.positions @ rig.places.slots.T / pitches) ** 2
    with_slots = np.broadcast_to(f, (*f.shape[:2], factor.shape[1])).copy()
    with_slots[1] *= factor
    plain, changed = ([data.row.columns(of, recording.i_d, recording.i_q) for data in rows] for of in (f, with_slots))
    return [replace(data, a=data.a + delayed(after - before))
            for data, before, after in zip(rows, plain, changed, strict=True)]
