"""From a recording to constants: velocities, estimator, diagnostics, replay, and effects outside the model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from maglev.files.arrays import Array
from maglev.files.errors import IdentificationError
from maglev.identification.diagnostics import RowDiagnostics, diagnose, unidentified, warnings_of
from maglev.identification.effects import changes, effects_of, judge_description
from maglev.identification.estimators import Estimate, run_estimator
from maglev.identification.recording import MotionRecording
from maglev.identification.regressors import RowData, accelerations, regressors
from maglev.identification.settings import EPSILON, GAMMA

HORIZON = 0.05      # s; open loop the vertical axis is unstable, with rates of 20 to 45 1/s
WINDOWS = 50        # at most, spread over the recording
SMOOTHING = 0.02    # s, of the states that a replay starts from


@dataclass(frozen=True)
class Identification:
    """An estimate with its diagnostics; errors, replays and shares by constant or axis."""

    recording: MotionRecording
    estimate: Estimate
    guess: dict[str, float]
    matched: bool   # true if y and u went through the observer's filters
    diagnostics: dict[str, RowDiagnostics]
    standard_error: dict[str, float]   # the scatter to expect from another recording, no more
    with_friction: dict[str, float]
    # its changes by friction, bias, ripple and modulation, as described, with their signs, and their bound, larger if
    # the recording shows more; NaN and infinite where not excited
    bias: dict[str, float]
    left_out: dict[str, float]
    replay_error: Array   # m, shape (axes,), see `replay`; as the next one
    replay_motion: Array
    warnings: list[str]
    unidentified: list[str]   # constants that the recording does not tell

    def __repr__(self) -> str:
        constants = ", ".join(f"{name} = {value:.6g}" for name, value in self.estimate.final.items())
        return f"<Identification of {self.recording.stage.name}: {constants}; {len(self.warnings)} warnings>"

    @property
    def uncertainty(self) -> dict[str, float]:
        """Largest likely error of each constant: two standard errors, and the effects that the model leaves out."""
        return {name: 2.0 * error + self.left_out[name] for name, error in self.standard_error.items()}


def identify(recording: MotionRecording, method: str = "reduced", epsilon: float = EPSILON, gamma: float = GAMMA,
             guess: Mapping[str, float] | None = None, match: bool = False,
             velocities: Array | None = None) -> Identification:
    """Estimate the constants of a stage from a recording; see `run_estimator` for method, ε and γ.

    A `guess` has initial values; those of the estimator FMU are for constants that it does not name. `match` puts
    positions and currents through the filters that the observer's velocity has gone through. `velocities` are in m/s,
    shape (n, axes), by default those of the high-gain observer. IdentificationError if no axis is excited, or as in
    `run_estimator`.
    """
    stage, dt = recording.stage, recording.dt
    start = {**stage.guess, **(guess or {})}
    seen = observed(recording.positions, dt) if velocities is None else velocities
    positions, i_d, i_q = recording.positions, recording.i_d, recording.i_q
    if match:
        positions, i_d, i_q = (matched(signal, dt) for signal in (positions, i_d, i_q))
    rows = regressors(stage, positions, i_d, i_q, seen)

    def estimated(seen_rows: Sequence[RowData]) -> Estimate:
        return run_estimator(method, seen_rows, recording.time, start, epsilon, gamma)

    estimates = estimated(rows)
    travel = np.ptp(recording.positions, axis=0).tolist()
    diagnostics = {data.row.axis: diagnose(data, way, recording.time, estimates)
                   for data, way in zip(rows, travel, strict=False)}   # tilts have no row of constants
    if not any(diagnosis.excited for diagnosis in diagnostics.values()):
        ways = ", ".join(f"{axis} {1e3 * way:.3g} mm" for axis, way in zip(stage.axes, travel, strict=True))
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
    # True velocities have no lag; observed ones have one, even if the rows have none.
    delayed = partial(matched, dt=dt) if velocities is None else np.asarray
    effects = effects_of(recording, rows, delayed, estimates.final)
    by_effect = changes(effects, estimates.final, lambda others: estimated(others).final)
    bias = {name: sum(change[name] for change in by_effect) for name in estimates.final}
    bound = {name: sum(abs(change[name]) for change in by_effect) for name in estimates.final}
    for data in rows:
        if diagnostics[data.row.axis].excited:
            warnings += judge_description(data, effects, by_effect, estimates, errors, bound)
        else:
            bound |= dict.fromkeys(data.row.constants, np.inf)
            bias |= dict.fromkeys(data.row.constants, np.nan)
    return Identification(recording, estimates, start, match, diagnostics, errors, friction, bias, bound, error,
                          motion, sorted(warnings), sorted(unknown))


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
    """Signals, shape (n, m), through the two low-pass filters of the observer's velocity.

    They begin at the first sample. The observer's velocity is exactly the derivative of the position behind these
    filters. With the signals behind them too, the delay is the same on both sides of velocity' = A θ + b.
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
        half = accelerations(recording.stage, x, i_d, i_q, known)
        v_middle = v + 0.5 * dt * half
        full = accelerations(recording.stage, x + 0.5 * dt * v, middle_d, middle_q, known)
        x, v = x + dt * v_middle, v + dt * full
    there = positions[starts + steps]
    return rms(x - there), rms(there - positions[starts])


def rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
