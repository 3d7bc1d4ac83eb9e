"""Diagnostics of an estimate from its recording: excitation, correlation, standard errors, residuals."""

from dataclasses import dataclass

import numpy as np

from maglev.files.arrays import Array
from maglev.identification.estimators import Estimate, behind_lag, between
from maglev.identification.regressors import RowData

SMALLEST_MOTION = 1e-4       # m; an axis that moves less than ten encoder counts says nothing
SMALLEST_EXCITATION = 1e-6   # of ∫Q dt, scaled; below, its columns are one
BLOCK = 0.5                  # s, residuals further apart count as independent: about a stroke; assumed
CREEP = 5e-3                 # m/s, speed over which the Coulomb term of the check for friction turns; assumed
SETTLING = 6.0               # ε, after which the start of a lag of ε has decayed (to 0.2 %)
OBSERVER_SETTLING = 0.02     # s, the same for the observer's two time constants of 1 ms
CURVE = 200                  # points of the excitation over time

UNIDENTIFIABLE = 0.25        # standard error over value from which a constant counts as not identified
HELD_BACK = 0.10             # change of a constant by friction terms from which a warning is given
RELATED = 0.95               # correlation of two constants from which a warning is given


@dataclass(frozen=True)
class RowDiagnostics:
    """Diagnostics of one row with p constants."""

    excited: bool   # true if the row says anything: the axis moves, and the columns of A are there and differ
    # λmin of ∫Q dt (3.5), with each column of A scaled to ∫a² = 1 over the whole recording. It starts at 0. It ends at
    # 1 for orthogonal columns, at 0 for equal columns; shape (m,)
    time: Array
    excitation: Array
    correlation: Array   # of the constants, from (∫AᵀA dt)⁻¹; shape (p, p)
    covariance: Array   # of the estimate at the end; infinite where not excited; shape (p, p)
    standard_error: Array   # roots of its diagonal; shape (p,)
    # least-squares constants when a viscous and a Coulomb term join the row; NaN where not excited; shape (p,)
    with_friction: Array
    residual: float   # RMS of velocity' − b − A θ behind a lag of ε, m/s²
    motion: float   # RMS of velocity' behind the same lag, m/s²


def diagnose(data: RowData, motion: float, time: Array, estimate: Estimate) -> RowDiagnostics:
    """Diagnostics of a row, whose axis moves over a range `motion` (m)."""
    dt = float(time[-1] - time[0]) / (len(time) - 1)
    theta = np.array([estimate.final[name] for name in data.row.constants])
    count = len(theta)
    information = np.cumsum(between(data.a)[:, :, None] * between(data.a)[:, None, :], axis=0) * dt
    total = np.diag(information[-1])
    present = bool(np.all(total > 0.0))
    scale = 1.0 / np.sqrt(np.where(total > 0.0, total, 1.0))
    points = np.unique(np.linspace(0, len(information) - 1, CURVE).astype(int))
    curve = np.linalg.eigvalsh(information[points] * np.outer(scale, scale))[:, 0].clip(min=0.0)
    excited = present and motion >= SMALLEST_MOTION and bool(curve[-1] >= SMALLEST_EXCITATION)
    terms = np.stack([data.velocity, np.tanh(data.velocity / CREEP)], axis=1)
    a, c, friction = compared(data, terms, dt, estimate.epsilon)
    left = c - a @ theta
    correlation, covariance = np.eye(count), np.full((count, count), np.inf)
    other = np.full(count, np.nan)
    if excited:
        # The estimators give late data more weight, in proportion to Σ^(1/κ − 1): the variance grows by this.
        weighting = 1.0 - estimate.gamma**-2
        lateness = 1.0 / (weighting * (2.0 - weighting))
        inverse = np.linalg.inv(information[-1] * np.outer(scale, scale))
        correlation = inverse / np.sqrt(np.outer(np.diag(inverse), np.diag(inverse)))
        covariance = lateness * block_covariance(a, c, max(1, round(BLOCK / dt)))
        other = least_squares(np.concatenate([a, friction], axis=1), c)[:count]
    return RowDiagnostics(excited, time[points + 1], curve, correlation, covariance, np.sqrt(np.diag(covariance)),
                          other, float(np.sqrt(np.mean(left**2))),
                          float(np.sqrt(np.mean((c + data.b[0])**2))))


def compared(data: RowData, terms: Array, dt: float, epsilon: float) -> tuple[Array, Array, Array]:
    """A, velocity' − b and further terms of a row, (n, m), behind a lag of ε (s), after its initial transient.

    Differences of a velocity are noise; the estimators compare them behind a lag of ε. A recording may begin in motion,
    but the observer and the lag begin at rest.
    """
    settled = min(round((SETTLING * epsilon + OBSERVER_SETTLING) / dt), len(data.velocity) // 2)
    a, c, more = (behind_lag(held, dt, epsilon)[1 + settled:] for held in (
        between(data.a), np.diff(data.velocity) / dt - between(data.b), between(terms)))
    return a, c, more


def least_squares(a: Array, c: Array) -> Array:
    """Solution of A θ = c; the columns are scaled, for their units differ by orders of magnitude."""
    scale = np.sqrt(np.sum(a * a, axis=0))
    scale = np.where(scale > 0.0, scale, 1.0)
    return np.asarray(np.linalg.lstsq(a / scale, c, rcond=None)[0] / scale)


def block_covariance(a: Array, c: Array, block: int) -> Array:
    """Covariance of the least-squares solution of A θ = c with residuals that are correlated over a block of samples.

    (AᵀA)⁻¹ (Σ g gᵀ) (AᵀA)⁻¹ with g = Aᵀr of each block: friction and encoders leave anything but white residuals.
    """
    scale = np.sqrt(np.sum(a * a, axis=0))
    scaled = a / scale
    residual = c - scaled @ np.linalg.lstsq(scaled, c, rcond=None)[0]
    blocks = max(1, len(c) // block)
    scores = (scaled * residual[:, None])[:blocks * block].reshape(blocks, -1, a.shape[1]).sum(axis=1)
    inverse = np.linalg.inv(scaled.T @ scaled)
    return np.asarray(inverse @ scores.T @ scores @ inverse / np.outer(scale, scale))


def unidentified(data: RowData, diagnostics: RowDiagnostics, estimate: Estimate) -> list[str]:
    """Constants of a row that the recording does not identify: not excited, not above 0, or lost in the residual."""
    return [name for name, error in zip(data.row.constants, diagnostics.standard_error, strict=True)
            if not diagnostics.excited or not error <= UNIDENTIFIABLE * estimate.final[name]]


def warnings_of(data: RowData, diagnostics: RowDiagnostics, estimate: Estimate) -> list[str]:
    """Warnings for users of the constants of a row, one plain sentence each."""
    names, axis = data.row.constants, data.row.axis
    if not diagnostics.excited:
        return [f"{', '.join(names)}: cannot be identified from this recording of axis {axis}: move all axes, as with "
                "the excitation of section 4.3.1 or 5.3"]
    told = []
    for name, error, other in zip(names, diagnostics.standard_error, diagnostics.with_friction, strict=True):
        value = estimate.final[name]
        if value <= 0.0:
            told.append(f"{name}: cannot be identified, its estimate is {value:.4g}, expected more than 0")
        elif error > UNIDENTIFIABLE * value:
            told.append(f"{name}: cannot be identified, its standard error is {error / value:.0%} of its value: its "
                        f"effect on axis {axis} is smaller than the unexplained motion")
        elif abs(other - value) > HELD_BACK * value:
            told.append(f"{name}: may contain friction, or epsilon is too large: least squares with friction terms "
                        f"give {other:.4g} instead of {value:.4g}")
    for i in range(len(names)):
        for k in range(i):
            together = diagnostics.correlation[i, k]
            if abs(together) > RELATED:
                told.append(f"{names[k]} and {names[i]}: only a combination of them is well determined, their "
                            f"correlation is {together:.3f}")
    return told
