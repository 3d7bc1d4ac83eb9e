"""The estimators of chapter 3: FSDI (3.3), NPFSI of full order (3.6), (3.7) and of reduced order (3.8).

The rows of A decouple, so each velocity row has an estimator of its own. Between two samples the regressor is held at
their mean and the velocity runs straight. The rest is integrated exactly (FSDI, of the mean behind its lag) or with the
gain at the middle of the sample (NPFSI). The latter is of second order and stable for any ε.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import mul

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import IdentificationError, one_of
from maglev.identification.regressors import RowData
from maglev.identification.settings import EPSILON, GAMMA, METHODS

TINY_Q0 = 1e-3     # ε diag(max AᵀA), for (3.3) and (3.8)
FULL_Q0 = 8.0      # ε diag(max AᵀA), for (3.7): below about this Σ does not stay positive definite
REFINED = 30       # samples at the start that (3.8) divides, for Σ grows from next to nothing
GROWTH = 1.1       # of the first sample's parts, one to the next


@dataclass(frozen=True)
class Estimate:
    method: str
    epsilon: float
    gamma: float
    time: Array   # s; shape (n,)
    names: tuple[str, ...]
    theta: Array   # shape (n, p)

    @property
    def final(self) -> dict[str, float]:
        """The constants at the end, by name."""
        return dict(zip(self.names, self.theta[-1].tolist(), strict=True))


def run_estimator(method: str, rows: Sequence[RowData], time: Array, guess: Mapping[str, float],
                  epsilon: float = EPSILON, gamma: float = GAMMA, q0: float | None = None) -> Estimate:
    """Run an estimator, "reduced", "full" or "fsdi", over a recording with evenly spaced times, s, shape (n,).

    `guess` has the initial value of every constant. ε is the confidence level of the measurement, here a time (s).
    (3.3) has no such level; for FSDI it is the lag of both sides of v' = a θ + b. γ > 1 is the attenuation, `q0` Q0 in
    ε diag(max AᵀA), by default `FULL_Q0` or `TINY_Q0`. IdentificationError if the method is unknown, ε or γ is out of
    range, or Σ of (3.7) loses its definiteness.
    """
    if method not in METHODS:
        raise IdentificationError(f"method {method}: expected {one_of(method, METHODS)}")
    if not (np.isfinite(epsilon) and epsilon > 0.0):
        raise IdentificationError(f"epsilon = {epsilon}: expected a time above 0 s, such as {EPSILON}")
    if not (np.isfinite(gamma) and gamma > 1.0):
        raise IdentificationError(f"gamma = {gamma}: expected more than 1, such as {GAMMA}")
    dt = float(time[-1] - time[0]) / (len(time) - 1)
    scale = FULL_Q0 if method == "full" else TINY_Q0
    columns: dict[str, Array] = {}
    for data in rows:
        theta0 = np.array([guess[name] for name in data.row.constants])
        mean = Samples(between(data.a), np.diff(data.velocity) / dt - between(data.b), dt)
        sigma0 = (scale if q0 is None else q0) * epsilon * np.diag(largest_squares(data.a))
        if method == "fsdi":
            path = fsdi(mean_behind_lag(mean, epsilon), theta0, sigma0, gamma)
        elif method == "reduced":
            path = npfsi_reduced(mean, theta0, sigma0, gamma, epsilon)
        else:
            path = npfsi_full(mean, theta0, sigma0, gamma, epsilon, data.row.axis)
        columns.update(zip(data.row.constants, path.T, strict=True))
    names = tuple(sorted(columns))
    return Estimate(method, epsilon, gamma, time, names, np.stack([columns[name] for name in names], axis=1))


@dataclass(frozen=True)
class Samples:
    """Data of one row that an estimator sees between its samples."""

    a: Array    # regressor, shape (n − 1, p)
    c: Array    # velocity' − b, m/s², shape (n − 1,)
    dt: float   # s


def between(signal: Array) -> Array:
    """Mean of each two neighbouring samples."""
    return np.asarray(0.5 * (signal[1:] + signal[:-1]))


def largest_squares(a: Array) -> Array:
    """max AᵀA of each column, 1 for a column that is zero throughout; shape (p,)."""
    squares = np.max(a * a, axis=0)
    return np.where(squares > 0.0, squares, 1.0)


def outer(a: Array, b: Array) -> Array:
    """Outer products of n vectors with p entries, shape (n, p, p)."""
    return a[:, :, None] * b[:, None, :]


def running_sum(parts: Array) -> Array:
    return np.concatenate([np.zeros_like(parts[:1]), np.cumsum(parts, axis=0)[:-1]])


def solve(sigma: Array, a: Array) -> Array:
    """Σ⁻¹ aᵀ of n matrices (n, p, p) and vectors (n, p)."""
    return np.asarray(np.linalg.solve(sigma, a[:, :, None])[:, :, 0])


def behind_lag(held: Array, dt: float, epsilon: float) -> Array:
    """First-order lag of ε (s) that starts at 0, at the samples.

    Exact for signals held between samples: shape (n − 1,) or (n − 1, p) in, one row more out.
    """
    from scipy.signal import lfilter  # half of the start of every run, which estimates nothing

    decay = np.exp(-dt / epsilon)
    return np.concatenate([np.zeros_like(held[:1]), lfilter([1.0 - decay], [1.0, -decay], held, axis=0)])


def mean_behind_lag(samples: Samples, epsilon: float) -> Samples:
    """Both sides of v' − b = a θ behind a lag of ε (s), as their means between samples.

    (3.3) takes v' as available, which no sensor of the stages measures. Assumed: a lag in front, which leaves θ as it
    is,
    since it is linear, and makes v' known: lag(v)' = lag(v') = (v − lag(v))/ε with lag(v)(0) = v(0). Bare differences
    of an observed velocity are the noise of the encoders, and so are in part the currents that the controller answers
    with: together they bias the estimate.
    """
    dt = samples.dt
    # Over a sample the distance of the lag from the held value decays: this is its mean.
    left = -np.expm1(-dt / epsilon) * epsilon / dt
    a, c = (held + (behind_lag(held, dt, epsilon)[:-1] - held) * left for held in (samples.a, samples.c))
    return Samples(a, c, dt)


def fsdi(samples: Samples, theta0: Array, sigma0: Array, gamma: float) -> Array:
    """(3.3): θ' = Σ⁻¹ aᵀ (c − a θ), Σ' = κ aᵀa, κ = 1 − γ⁻². Returns θ at the samples, shape (n, p).

    Over a sample with constant a and c the residual r = c − a θ falls as r0 (1 + κ q t)^(−1/κ), q = a Σ⁻¹ aᵀ.
    """
    a, c, dt = samples.a, samples.c, samples.dt
    kappa = 1.0 - gamma**-2
    p = solve(sigma0 + kappa * dt * running_sum(outer(a, a)), a)
    q = np.sum(a * p, axis=1)
    # The step of θ is p r0 times this; for q → 0 it is dt.
    gone = -np.expm1(-np.log1p(kappa * q * dt) / kappa)
    share = np.where(q * dt > 1e-12, gone / np.where(q > 0.0, q, 1.0), dt)
    theta = theta0.tolist()
    path = [theta]
    for a_k, c_k, step in zip(a.tolist(), c.tolist(), (p * share[:, None]).tolist(), strict=True):
        residual = c_k - sum(map(mul, a_k, theta))
        theta = [value + part * residual for value, part in zip(theta, step, strict=True)]
        path.append(theta)
    return np.array(path)


def npfsi_reduced(samples: Samples, theta0: Array, sigma0: Array, gamma: float, epsilon: float) -> Array:
    """(3.8): θ' = ε⁻¹ p e, e' = c − a θ − ε⁻¹ e with p = Σ⁻¹ aᵀ, Σ' = κ aᵀa. Returns θ, shape (n, p)."""
    kappa = 1.0 - gamma**-2
    dt = samples.dt
    # The first sample raises Σ along a by orders of magnitude: its parts grow with it.
    information = kappa * float(samples.a[0] @ np.linalg.solve(sigma0, samples.a[0]))
    grown = np.log1p(information * dt)
    first = max(1, int(np.ceil(grown / np.log(GROWTH))))
    ends = np.array([dt])
    if first > 1:
        ends = np.expm1(grown * np.arange(1, first + 1) / first) / information
    count = np.ones(len(samples.c), dtype=np.int64)
    refined = np.arange(1, min(REFINED, len(count)))
    count[0], count[refined] = len(ends), -(-REFINED // refined)
    h = np.repeat(dt / count, count)
    h[:len(ends)] = np.diff(ends, prepend=0.0)
    a, c = np.repeat(samples.a, count, axis=0), np.repeat(samples.c, count)
    growth = kappa * h[:, None, None] * outer(a, a)
    p = solve(sigma0 + running_sum(growth) + 0.5 * growth, a)
    path = integrate(a, c, p, np.full(len(h), 1.0 / epsilon), h, epsilon, theta0)
    return np.asarray(path[np.concatenate([[0], np.cumsum(count)])])


def npfsi_full(samples: Samples, theta0: Array, sigma0: Array, gamma: float, epsilon: float, axis: str) -> Array:
    """(3.6), (3.7) of one row, with P0 = ε⁻¹, at which the first entry of Σ rests. Returns θ, shape (n, p).

    Σ = [ε⁻¹ −af; −afᵀ S] makes the Riccati equation (3.7) explicit. af' = ε⁻¹ (a − af), af(0) = 0, and the Schur
    complement M = S − ε afᵀaf has M' = afᵀaf − γ⁻² aᵀa, M(0) = Q0. Then (3.6) is θ' = ε⁻¹ p e and e' = c − a θ − (ε⁻¹ +
    af p) e with p = M⁻¹ afᵀ.
    """
    a, dt = samples.a, samples.dt
    offset = behind_lag(a, dt, epsilon)[:-1] - a   # at the start of each sample; decays during it

    def growth(t: float) -> Array:
        """Growth of M from the start of each sample to t (s) later."""
        once, twice = -epsilon * np.expm1(-t / epsilon), -0.5 * epsilon * np.expm1(-2.0 * t / epsilon)
        cross = outer(a, offset)
        return np.asarray((1.0 - gamma**-2) * t * outer(a, a) + once * (cross + np.swapaxes(cross, 1, 2))
                          + twice * outer(offset, offset))

    m = sigma0 + running_sum(growth(dt)) + growth(0.5 * dt)
    unit = 1.0 / np.sqrt(np.diag(sigma0))
    smallest = np.linalg.eigvalsh(m * np.outer(unit, unit))[:, 0]
    if smallest.min() <= 0.0:
        raise IdentificationError(f"axis {axis}: Σ of (3.7) is not positive definite after "
                                  f"{dt * int(np.argmax(smallest <= 0.0)):.4g} s, expected a larger Q0, a larger γ or "
                                  "a smaller ε; the reduced estimator has no such limit")
    middle = np.asarray(a + offset * np.exp(-0.5 * dt / epsilon))
    p = solve(m, middle)
    return integrate(a, samples.c, p, 1.0 / epsilon + np.sum(middle * p, axis=1), np.full(len(a), dt), epsilon, theta0)


def integrate(a: Array, c: Array, p: Array, damping: Array, h: Array, epsilon: float, theta0: Array) -> Array:
    """Integrate θ' = ε⁻¹ p e, e' = c − a θ − d e, e(0) = 0 over steps h (s) with a, c, p and d held.

    Over a step θ moves along p only, θ = θ0 + p η. Two exact numbers remain: with q = a p, e' = (c − a θ0) − q η − d e
    and η' = ε⁻¹ e. Returns θ before and after all steps, shape (steps + 1, p).
    """
    q = np.sum(a * p, axis=1)
    root = np.sqrt((0.25 * damping**2 - q / epsilon).astype(np.complex128))
    faster, slower = np.exp((-0.5 * damping - root) * h), np.exp((-0.5 * damping + root) * h)
    near = np.abs(root * h) < 1e-4
    s = np.where(near, h * np.exp(-0.5 * damping * h) * (1.0 + (root * h) ** 2 / 6.0),
                 (slower - faster) / np.where(near, 1.0, 2.0 * root)).real
    mean = 0.5 * (slower + faster).real
    e_from_e = mean - 0.5 * damping * s
    eta_from_e = s / epsilon
    turning = q * h * h / epsilon
    held = (h + np.expm1(-damping * h) / damping) / damping
    eta_from_c = np.where(turning > 1e-6, (1.0 - mean - 0.5 * damping * s) / np.where(q != 0.0, q, 1.0), held / epsilon)
    theta, e = theta0.tolist(), 0.0
    path = [theta]
    for a_k, c_k, p_k, e_e, e_c, n_e, n_c in zip(a.tolist(), c.tolist(), p.tolist(), e_from_e.tolist(), s.tolist(),
                                                 eta_from_e.tolist(), eta_from_c.tolist(), strict=True):
        residual = c_k - sum(map(mul, a_k, theta))
        eta = n_e * e + n_c * residual
        e = e_e * e + e_c * residual
        theta = [value + part * eta for value, part in zip(theta, p_k, strict=True)]
        path.append(theta)
    return np.array(path)
