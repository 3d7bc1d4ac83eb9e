"""Recordings of the excitation experiments (sections 4.3.1, 5.3), made with the blocks called directly."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import pi, sin
from typing import Any

import numpy as np

from controller_fmu.pid_2dof import PID2DOF
from controller_fmu.pid_3dof import PID3DOF
from identification.recording import Recording
from identification.rigs import RIGS
from plant_fmu import stage_2dof, stage_3dof

STAGES = {"2dof": stage_2dof, "3dof": stage_3dof}
CORNERS = {"v": 25.0, "y": 25.0, "h": 6.0, "x": 6.0, "z": 6.0}   # rad/s, pre-filters of the references
RAMP = 2.0   # s

HREF = (0.06, ((0.25, 1.0, 0.5 * pi), (0.5, 2.0, pi / 3.0), (0.5, 3.0, 0.25 * pi), (0.25, 4.0, pi / 6.0)))
VREF = (-0.005 / 4.0, ((1.0, 1.0, -0.8 * pi), (1.0, 2.0, -1.6 * pi), (1.0, 3.0, -1.8 * pi), (1.0, 4.0, -3.2 * pi)))
XREF = (0.045, ((0.5, 0.75, -pi / 3.0), (0.25, 1.5, pi / 4.0), (0.5, 2.25, -pi / 5.0), (0.25, 3.0, pi / 6.0)))
LOWERED = (0.469 * pi, 0.938 * pi, 1.406 * pi, 1.875 * pi)
ZREF = (0.045, tuple((a, w, phase - by) for (a, w, phase), by in zip(XREF[1], LOWERED, strict=True)))
YREF = (0.005 / 4.0, ((1.0, 1.0, -0.8 * pi), (1.0, 2.0, -1.6 * pi), (1.0, 3.0, -2.4 * pi), (1.0, 4.0, -3.2 * pi)))
REFERENCES = {"2dof": {"v": (0.02, *VREF), "h": (0.0, *HREF)},
              "3dof": {"y": (0.025, *YREF), "x": (0.0, *XREF), "z": (0.0, *ZREF)}}


@dataclass
class Data:
    """A recording with what no sensor of the rigs measures."""

    recording: Recording
    velocity: np.ndarray        # m/s, shape (n, axes), true
    truth: dict[str, float]     # constants of the stage


def reference(signal: Any, t: float) -> float:
    """Reference (m) at a time (s), ramped in by 3 s² − 2 s³."""
    offset, amplitude, terms = signal
    s = min(t / RAMP, 1.0)
    return float(offset + (3.0 * s**2 - 2.0 * s**3) * amplitude * sum(a * sin(w * pi * t + p) for a, w, p in terms))


def set_ideal(stage: Any, rig: str) -> None:
    """Switch off whatever the model of the controller does not have."""
    stage.attraction_modulation = stage.encoder.resolution = 0.0
    for name in RIGS[rig].axes:
        axis = getattr(stage, name)
        axis.bias = axis.friction.coulomb = axis.friction.viscous = axis.ripple.amplitude = 0.0
    for name in RIGS[rig].motors:
        amplifier = getattr(stage, name).amplifier
        amplifier.lag = amplifier.peak = 0.0


def simulate(rig: str, duration: float, dt: float, change: Callable[[Any], None] | None = None,
             ideal: bool = True) -> Data:
    """Fly the excitation under PID, recorded every dt (s); `change` may set parameters of the stage.

    One integration step a sample: 0.1 µm is accurate enough here (docs/accuracy.md), and takes a third of the time.
    """
    longest = STAGES[rig].LONGEST_STEP
    STAGES[rig].LONGEST_STEP = dt
    try:
        return fly(rig, duration, dt, change, ideal)
    finally:
        STAGES[rig].LONGEST_STEP = longest


def fly(rig: str, duration: float, dt: float, change: Callable[[Any], None] | None, ideal: bool) -> Data:
    """What `simulate` does, with the integration step as it is."""
    axes, motors = RIGS[rig].axes, RIGS[rig].motors
    stage = STAGES[rig].Stage2DOF() if rig == "2dof" else STAGES[rig].Stage3DOF()
    pid: Any = PID2DOF() if rig == "2dof" else PID3DOF()
    pid.sample_time, pid.current_limit = dt, 0.0
    for name in axes:
        getattr(pid, name).prefilter = CORNERS[name]
        if rig == "3dof" and name != "y":
            axis = getattr(pid, name)
            axis.pole, axis.pair_real, axis.pair_imaginary = -8.0, -25.0, 45.0
    if ideal:
        set_ideal(stage, rig)
    if change is not None:
        change(stage)
    for name in RIGS[rig].constants:   # whether a law for other constants flies is not the matter here
        setattr(pid, name, getattr(stage, name))
    assert pid.start() == 0
    assert stage.start() == 0
    rows = []
    for k in range(round(duration / dt) + 1):
        t = k * dt
        rows.append([t, *(getattr(stage, name).encoder for name in axes),
                     *(getattr(stage, name).velocity for name in axes),
                     *(getattr(stage, name).i_d for name in motors), *(getattr(stage, name).i_q for name in motors)])
        for name in axes:
            axis = getattr(pid, name)
            axis.measured = getattr(stage, name).encoder
            axis.reference = reference(REFERENCES[rig][name], t)
        assert pid.step(t, dt) == 0
        for name in motors:
            to, source = getattr(stage, name), getattr(pid, name)
            to.i_a_cmd, to.i_b_cmd, to.i_c_cmd = source.i_a_cmd, source.i_b_cmd, source.i_c_cmd
        assert stage.step(t, dt) == 0
        assert not stage.at_stop
    table = np.array(rows)
    n, m = len(axes), len(motors)
    recording = Recording(RIGS[rig], table[:, 0], table[:, 1:1 + n], table[:, 1 + 2 * n:1 + 2 * n + m],
                          table[:, 1 + 2 * n + m:])
    return Data(recording, table[:, 1 + n:1 + 2 * n], {name: getattr(stage, name) for name in RIGS[rig].constants})


def set_encoder(stage: Any) -> None:
    """An encoder of 10 µm, and nothing else."""
    stage.encoder.resolution = 10e-6


@cache
def flight(rig: str, kind: str) -> Data:
    """A kind of stage, ideal or encoder for 40 s, or real with friction, bias, modulation, ripple and lag for 20 s."""
    # The thesis's 5 kHz of the 3-DOF rig say no more than 2 kHz, and take 2.5 times as long.
    duration = 20.0 if kind == "real" else 40.0
    return simulate(rig, duration, 0.5e-3, set_encoder if kind == "encoder" else None, kind != "real")
