"""The model with the estimated constants against the recording, over short horizons."""

from collections.abc import Mapping

import numpy as np
from scipy.signal import savgol_filter

from maglev.arrays import Array
from maglev.identification.recording import Recording
from maglev.identification.rigs import accelerations

HORIZON = 0.05      # s; open loop the vertical axis is unstable, with rates of 20 to 45 1/s
WINDOWS = 50        # at most, spread over the recording
SMOOTHING = 0.02    # s, of the states that a replay starts from


def replay(recording: Recording, constants: Mapping[str, float]) -> tuple[Array, Array]:
    """Replay windows of a recording from its states, with its currents.

    Returns
    -------
    error : ndarray, shape (axes,)
        RMS of replayed − recorded position at the end of the windows, m.
    motion : ndarray, shape (axes,)
        RMS of the way that the axes go in a window, m.
    """
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
    """Root mean square over the first axis."""
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
