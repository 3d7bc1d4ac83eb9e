"""Data to identify a stage from: the closed loop under the excitation of sections 4.3.1 and 5.3, by blocks directly."""

from math import pi, sin
from typing import Any

import numpy as np
from direct_loop import RIGS, idealise

from controller_fmu.pid_2dof import PID2DOF
from controller_fmu.pid_3dof import PID3DOF
from plant_fmu.stage_2dof import Stage2DOF
from plant_fmu.stage_3dof import Stage3DOF

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


def reference(axis: str, t: float) -> float:
    """Reference (m) of an axis at a time (s)."""
    offset, amplitude, terms = EXCITATION[axis]
    s = min(t / RAMP, 1.0)
    return offset + (3 - 2 * s) * s * s * amplitude * sum(a * sin(pi * (w * t + p)) for a, w, p in terms)


def excitation(rig: int, ideal: bool = True, seconds: float = 40.0, resolution: float = 0.0,
               constants: dict[str, float] | None = None,
               change: tuple[float, dict[str, float]] | None = None) -> dict[str, np.ndarray]:
    """Fly a rig under PID with pre-filter along the excitation.

    Parameters
    ----------
    rig : int
        2 or 3, degrees of freedom.
    ideal : bool
        No friction, bias, modulation, ripple, lag or clamp.
    seconds : float
    resolution : float
        Of the encoders of an ideal stage, m; a real one has its own.
    constants : dict, optional
        Constants of the stage; the controller knows them as well. Otherwise those of the controllers' model.
    change : (float, dict), optional
        Time (s) and constants that the stage has from then on.

    Returns
    -------
    dict of str to ndarray, each of shape (samples,)
        time (s); for each axis `.position` (m, true), `.velocity` (m/s, true), `.encoder` (m); for each motor `.i_d`
        and `.i_q` (A, delivered).
    """
    axes, motors, dt = RIGS[rig]
    stage: Any = Stage2DOF() if rig == 2 else Stage3DOF()
    pid: Any = PID2DOF() if rig == 2 else PID3DOF()
    for name, value in (constants or {}).items():
        setattr(pid, name, value)
        setattr(stage, name, value)
    for name in axes:
        getattr(pid, name).prefilter = CORNERS[name]
        if name in ("x", "z"):
            getattr(pid, name).pole, getattr(pid, name).pair_real = -8.0, -25.0
            getattr(pid, name).pair_imaginary = 45.0
    if ideal:
        idealise(rig, stage, pid)
        stage.encoder.resolution = resolution
        pid.current_limit = 0.0
    assert pid.start() == stage.start() == 0
    count = round(seconds / dt)
    names = [*(f"{name}.{what}" for name in axes for what in ("position", "velocity", "encoder")),
             *(f"{name}.{what}" for name in motors for what in ("i_d", "i_q"))]
    owners = [(getattr(stage, name.split(".")[0]), name.split(".")[1]) for name in names]
    loops = [(name, getattr(pid, name), getattr(stage, name)) for name in axes]
    wires = [(getattr(pid, name), getattr(stage, name)) for name in motors]
    rows = np.empty((count, len(names)))
    for k in range(count):
        t = k * dt
        if change is not None and t >= change[0]:
            for name, value in change[1].items():
                setattr(stage, name, value)
            change = None
        rows[k] = [getattr(owner, what) for owner, what in owners]
        for name, controlled, moved in loops:
            controlled.reference = reference(name, t)
            controlled.measured = moved.encoder
        assert pid.step(t, dt) == 0
        for source, to in wires:
            to.i_a_cmd, to.i_b_cmd, to.i_c_cmd = source.i_a_cmd, source.i_b_cmd, source.i_c_cmd
        assert stage.step(t, dt) == 0
        assert not stage.at_stop
    return {"time": dt * np.arange(count), **dict(zip(names, rows.T, strict=True))}
