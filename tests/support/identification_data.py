"""Data to identify a stage from: the closed loop under the excitation of sections 4.3.1 and 5.3, by blocks directly."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import pi
from typing import Any

import numpy as np
from direct_loop import LAYOUTS, idealise
from named_controllers import PID2DOF, PID3DOF
from named_stage import Stage2DOF, Stage3DOF

from maglev.identification.recording import MotionRecording
from maglev.identification.regressors import ESTIMATED_STAGES

RAMP = 2.0   # s, in which the excitation comes in by 3 s² − 2 s³
CORNERS = {"v": 25.0, "h": 6.0, "y": 25.0, "x": 6.0, "z": 6.0}   # rad/s, pre-filters
Y_TERMS = [(0.25, 1.0, -0.8), (0.25, 2.0, -1.6), (0.25, 3.0, -2.4), (0.25, 4.0, -3.2)]
X_TERMS = [(0.5, 0.75, -1 / 3), (0.25, 1.5, 1 / 4), (0.5, 2.25, -1 / 5), (0.25, 3.0, 1 / 6)]
Z_LOWER = (0.469, 0.938, 1.406, 1.875)

# Offset and amplitude (m), then terms: share, frequency and phase, both over π. Href's second phase is read as π/3.
EXCITATION: dict[str, tuple[float, float, list[tuple[float, float, float]]]] = {
    "v": (0.020, -0.005, [(0.25, 1.0, -0.8), (0.25, 2.0, -1.6), (0.25, 3.0, -1.8), (0.25, 4.0, -3.2)]),
    "h": (0.0, 0.06, [(0.25, 1.0, 1 / 2), (0.5, 2.0, 1 / 3), (0.5, 3.0, 1 / 4), (0.25, 4.0, 1 / 6)]),
    "y": (0.025, 0.005, Y_TERMS),
    "x": (0.0, 0.045, X_TERMS),
    "z": (0.0, 0.045, [(a, w, p - lower) for (a, w, p), lower in zip(X_TERMS, Z_LOWER, strict=True)])}


@dataclass
class Data:
    """A recording with what no sensor of the stages measures."""

    recording: MotionRecording
    velocity: np.ndarray        # m/s, shape (n, axes), true
    truth: dict[str, float]     # constants of the stage


def reference(axis: str, t: np.ndarray) -> np.ndarray:
    """Reference (m) of an axis at times (s)."""
    offset, amplitude, terms = EXCITATION[axis]
    s = np.minimum(t / RAMP, 1.0)
    waves = np.sum([a * np.sin(pi * (w * t + p)) for a, w, p in terms], axis=0)
    return np.asarray(offset + (3 - 2 * s) * s * s * amplitude * waves)


def new_blocks(stage: int) -> tuple[Any, Any]:
    """Stage and PID of a stage, 2 or 3 degrees of freedom."""
    return (Stage2DOF(), PID2DOF()) if stage == 2 else (Stage3DOF(), PID3DOF())


def excitation(description: int, ideal: bool = True, seconds: float = 40.0, resolution: float = 0.0,
               constants: dict[str, float] | None = None, change: tuple[float, dict[str, float]] | None = None,
               dt: float | None = None, adjust: Callable[[Any], None] | None = None) -> dict[str, np.ndarray]:
    """Run a stage under PID with pre-filter along the excitation.

    Parameters
    ----------
    stage : int
        2 or 3, degrees of freedom.
    ideal : bool
        No friction, bias, modulation, ripple, lag or clamp.
    seconds : float
    resolution : float
        Of the encoders of an ideal stage, m; a real one has its own.
    constants : dict, optional
        Constants of the stage; the controller knows them as well. Otherwise those of the controllers' model, and of a
        real stage its own.
    change : (float, dict), optional
        Time (s) and constants that the stage has from then on.
    dt : float, optional
        Sample time, s; otherwise that of the stage.
    adjust : callable, optional
        Sets what a real stage has; without it, twice the described Coulomb friction.

    Returns
    -------
    dict of str to ndarray, each of shape (samples,)
        time (s); for each axis `.position` (m, true), `.velocity` (m/s, true), `.encoder` (m); for each motor `.i_d`
        and `.i_q` (A, delivered).
    """
    axes, motors, usual = LAYOUTS[description]
    dt = usual if dt is None else dt
    stage, pid = new_blocks(description)
    pid.sample_time, pid.current_limit = dt, 0.0
    for name, value in (constants or {}).items():
        setattr(pid, name, value)
        setattr(stage, name, value)
    for name in axes:
        getattr(pid, name).prefilter = CORNERS[name]
        if name in ("x", "z"):
            getattr(pid, name).pole, getattr(pid, name).pair_real = -8.0, -25.0
            getattr(pid, name).pair_imaginary = 45.0
    if ideal:
        idealise(description, stage, pid)
        stage.encoder.resolution = resolution
    elif adjust is not None:
        adjust(stage)
    else:
        for name in axes:   # as it was assumed: enough for what it does to the constants to be told
            getattr(stage, name).friction.coulomb *= 2.0
    assert pid.start() == stage.start() == 0
    stage.longest_step = dt   # one integration step a sample: 0.1 µm is accurate enough (docs/accuracy.md)
    return simulate(description, stage, pid, round(seconds / dt), dt, change)


def simulate(description: int, stage: Any, pid: Any, count: int, dt: float,
        change: tuple[float, dict[str, float]] | None) -> dict[str, np.ndarray]:
    """Samples of blocks that have been started; see `excitation`."""
    axes, motors, _ = LAYOUTS[description]
    names = [*(f"{name}.{what}" for name in axes for what in ("position", "velocity", "encoder")),
             *(f"{name}.{what}" for name in motors for what in ("i_d", "i_q"))]
    owners = [(getattr(stage, name.split(".")[0]), name.split(".")[1]) for name in names]
    times = dt * np.arange(count)
    loops = [(reference(name, times).tolist(), getattr(pid, name), getattr(stage, name)) for name in axes]
    wires = [(getattr(pid, name), getattr(stage, name)) for name in motors]
    rows = np.empty((count, len(names)))
    for k in range(count):
        t = k * dt
        if change is not None and t >= change[0]:
            for name, value in change[1].items():
                setattr(stage, name, value)
            change = None
        rows[k] = [getattr(owner, what) for owner, what in owners]
        for references, controlled, moved in loops:
            controlled.reference = references[k]
            controlled.measured = moved.encoder
        assert pid.step(t, dt) == 0
        for source, to in wires:
            to.i_a_cmd, to.i_b_cmd, to.i_c_cmd = source.i_a_cmd, source.i_b_cmd, source.i_c_cmd
        assert stage.step(t, dt) == 0
        assert not stage.at_stop
    return {"time": times, **dict(zip(names, rows.T, strict=True))}


def record(description: str, seconds: float, dt: float, ideal: bool = True, resolution: float = 0.0,
           scale: dict[str, float] | None = None, adjust: Callable[[Any], None] | None = None) -> Data:
    """The same as a recording of a stage with its own constants, each times that of `scale`.

    The controller knows them: whether a law for other constants runs is not the matter here.
    """
    about = ESTIMATED_STAGES[description]
    stage, _ = new_blocks(len(about.axes))
    truth = {name: (scale or {}).get(name, 1.0) * getattr(stage, name) for name in about.constants}
    made = excitation(len(about.axes), ideal, seconds, resolution, truth, dt=dt, adjust=adjust)

    def columns(names: tuple[str, ...], what: str) -> np.ndarray:
        return np.stack([made[f"{name}.{what}"] for name in names], axis=1)

    recording = MotionRecording(about, made["time"], columns(about.axes, "encoder"), columns(about.motors, "i_d"),
                                columns(about.motors, "i_q"))
    return Data(recording, columns(about.axes, "velocity"), truth)


@cache
def trial(stage: str, kind: str) -> Data:
    """A kind of stage, ideal or encoder for 40 s, or real with friction, bias, modulation, ripple and lag for 20 s."""
    # The thesis's 5 kHz of the 3-DOF stage say no more than 2 kHz, and take 2.5 times as long.
    return record(stage, 20.0 if kind == "real" else 40.0, 0.5e-3, kind != "real", 10e-6 if kind == "encoder" else 0.0)
