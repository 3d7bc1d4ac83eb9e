"""Velocities from measured positions by the rig's observer, and its delay for what they are compared with."""

import numpy as np
from scipy.signal import lfilter

from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from maglev.arrays import Array


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
    shares = observer_filter(dt)
    for share in (shares.share1, shares.share2):
        signals, _ = lfilter([share], [1.0, share - 1.0], signals, axis=0, zi=(1.0 - share) * signals[:1])
    return np.asarray(signals)
