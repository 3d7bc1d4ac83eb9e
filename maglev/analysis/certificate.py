"""Regions of stability by linear matrix inequalities, and antiwindup gains by the same inequalities.

Generalised sector condition of J. M. Gomes da Silva Jr. and S. Tarbouriech, "Antiwindup design with guaranteed regions
of stability: an LMI-based approach", IEEE Transactions on Automatic Control 50(1), 2005; see docs/results_stability.md.
"""

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from maglev.analysis.axis_loop import AxisLoop
from maglev.files.arrays import Array
from maglev.files.errors import StabilityError, extra

# The optimum lies on the border of the inequalities, where rounding decides. These are shares of its step, for which a
# certificate with a margin is sought.
SHARES = (0.998, 0.995, 0.99, 0.97, 0.9, 0.8, 0.7)
TOLERANCES = (1e-8, 1e-6, 1e-5, 1e-4)   # of the solver; the next one if it gives up: its results are verified
LARGEST_STEP = 0.25     # m, twice the way between the stops of any axis: larger steps are not tried
LEAST_DECREASE = 1e-6   # 1/s, of V/V: much more than rounding errors make


@dataclass(frozen=True, eq=False)
class Certificate:
    """Ellipsoid χᵀ P χ ≤ 1 from which the loop comes back to rest whatever the limit cuts off: V = χᵀ P χ decreases."""

    gains: Array   # Ec: m s²/A, m s/A, m/A; shape (3,)
    P: Array   # positive definite; shape (n, n)
    # of the sector conditions, A: φ(u) (φ(u) − G χ) ≤ 0 wherever |(K − G) χ| is within the limit, for each command;
    # shape (m, n)
    G: Array
    T: Array   # weights of the sector conditions; shape (m,)
    step: float   # largest step of the reference that starts in the ellipsoid, m; about LARGEST_STEP if that is reached
    decrease: float   # V decreases by at least this share of itself and of Σ φ² T a second, 1/s

    def level(self, states: Array) -> Array:
        """V of states, the columns of an array of shape (n, c): at most 1 inside."""
        return np.asarray(np.einsum("ic,ij,jc->c", states, self.P, states))

    def section(self, directions: Array) -> Array:
        """Shape matrix of the ellipse {c: V(directions c) ≤ 1} for two directions, shape (n, 2)."""
        return np.asarray(directions.T @ self.P @ directions)

    def shadow(self) -> Array:
        """Shape matrix of the ellipsoid's shadow on position and velocity."""
        return np.asarray(np.linalg.inv(np.linalg.inv(self.P)[:2, :2]))


def solver() -> Any:
    """cvxpy, an extra of this project with its solver Clarabel; StabilityError if one is not installed."""
    cvxpy, _ = (extra(module, "region", "a region", StabilityError) for module in ("cvxpy", "clarabel"))
    return cvxpy


def certify(loop: AxisLoop, gains: Array, decay: float = 0.0) -> Certificate:
    """Find the ellipsoid with the largest step in it, with gains Ec of the antiwindup, shape (3,), zeros for none.

    V is to decrease at least as exp(−2 decay t), `decay` in 1/s. StabilityError if there is none, or cvxpy is missing.
    """
    scaled = Scaled(loop)
    inequalities = Inequalities(scaled, decay, gains)
    best = inequalities.largest_step()
    for share in SHARES:
        inequalities.most_room(share * best)
        certified = certificate(loop, scaled, gains, inequalities, decay)
        if certified is not None:
            return certified
    raise StabilityError(f"{loop.name}: the solver's solution is not a certificate; try a decay below {decay:g} 1/s")


def synthesise(loop: AxisLoop, decay: float) -> Array:
    """Antiwindup gains Ec, shape (3,), with the largest certified step at a rate of decay (1/s).

    S = 1/T is equal for all commands that the antiwindup acts on. Z = Ec S replaces the product, so that the
    inequalities are linear in Q, Y, S, Z. StabilityError if no gains fulfil them, or cvxpy is missing.
    """
    inequalities = Inequalities(Scaled(loop), decay, None)
    inequalities.largest_step()
    return inequalities.gains()


class Scaled:
    """A loop in the coordinates of its modes, each as large as the limit or a typical step drives it.

    Positions, integrals of integrals and currents differ by orders of magnitude, and the modes' rates by a thousand.
    """

    STEP = 0.02   # m, typical

    def __init__(self, loop: AxisLoop):
        values, vectors = np.linalg.eig(loop.A)
        modes = [part for value, vector in zip(values, vectors.T, strict=True) if value.imag >= 0.0
                 for part in ([vector.real, vector.imag] if value.imag > 0.0 else [vector.real])]
        rates = [abs(value) for value in values if value.imag >= 0.0 for _ in range(2 if value.imag > 0.0 else 1)]
        basis: Array = np.array(modes, dtype=np.float64).T
        driven = np.linalg.solve(basis, np.column_stack([loop.B * loop.limits, self.STEP * loop.A @ loop.at_step]))
        self.rates: Array = np.array(rates)   # 1/s, of the modes
        sizes = np.linalg.norm(driven, axis=1) / self.rates
        self.modes: Array = np.asarray(basis * sizes, dtype=np.float64)
        self.back: Array = np.asarray(np.linalg.inv(self.modes), dtype=np.float64)
        self.A: Array = self.back @ loop.A @ self.modes
        # Currents in units of the limit.
        self.limits = loop.limits
        self.B: Array = self.back @ loop.B * self.limits
        self.E: Array = self.back @ loop.E
        self.w: Array = loop.w * self.limits
        self.K: Array = loop.K @ self.modes / self.limits[:, None]
        self.at_step: Array = self.back @ loop.at_step * self.STEP
        self.sample_time, self.name = loop.sample_time, loop.name


class Inequalities:
    """The inequalities of docs/results_stability.md in Q = P⁻¹, Y = G Q, S = 1/T and, where Ec is looked for, Z = Ec S.

    `gains` are given, or looked for where None.
    """

    def __init__(self, scaled: Scaled, decay: float, gains: Array | None):
        m, n = scaled.K.shape
        self.cvxpy, self.scaled = solver(), scaled
        cvxpy = self.cvxpy
        self.Q = cvxpy.Variable((n, n), symmetric=True)
        self.Y = cvxpy.Variable((m, n))
        self.S = cvxpy.Variable(m)
        self.step = cvxpy.Variable((1, 1))
        self.sizes = np.linalg.norm(scaled.E, axis=0) * np.abs(scaled.w).max()
        s = cvxpy.diag(self.S)
        if gains is None:
            self.Z = cvxpy.Variable((3, 1))
            bs = scaled.B @ s + (scaled.E / self.sizes) @ self.Z @ scaled.w[None]
        else:
            bs = (scaled.B + np.outer(scaled.E @ gains, scaled.w)) @ s
        aq, root = scaled.A @ self.Q, np.sqrt(scaled.sample_time)
        rows = [[aq + aq.T + 2.0 * decay * self.Q, self.Y.T - bs], [self.Y - bs.T, -2.0 * s]]
        if scaled.sample_time:
            # The square of a sample's change, (A χ − B φ)ᵀ P (A χ − B φ) Ts, by its Schur complement.
            rows = [[*rows[0], root * aq.T], [*rows[1], -root * bs.T], [root * aq, -root * bs, -self.Q]]
        # Fast modes and slow ones alike: the same inequality with rows and columns of other sizes.
        even = np.ones(sum(row[-1].shape[0] for row in rows))
        even[:n] = scaled.rates ** -0.5
        self.decrease = cvxpy.multiply(np.outer(even, even), cvxpy.bmat(rows))
        kq, start = scaled.K @ self.Q - self.Y, scaled.at_step[:, None] @ self.step
        acting = [k for k in range(m) if gains is None and scaled.w[k] != 0.0]
        self.constraints = [*(cvxpy.bmat([[self.Q, kq[k:k + 1].T], [kq[k:k + 1], np.eye(1)]]) >> 0 for k in range(m)),
                            *(self.S[k] == self.S[acting[0]] for k in acting[1:]),
                            cvxpy.bmat([[np.eye(1), start.T], [start, self.Q]]) >> 0,
                            self.step <= LARGEST_STEP / scaled.STEP]

    def largest_step(self) -> float:
        """Solve for the largest step in the ellipsoid, in units of the scale."""
        self.solve(self.cvxpy.Maximize(self.step[0, 0]), [self.decrease << 0])
        return float(self.step.value[0, 0])

    def most_room(self, step: float) -> None:
        """Solve for an ellipsoid with this step in it that is farthest from the border of the inequality."""
        room = self.cvxpy.Variable()
        size = self.decrease.shape[0]
        self.solve(self.cvxpy.Maximize(room), [self.decrease << -room * np.eye(size), self.step == step])

    def solve(self, objective: Any, constraints: list[Any]) -> None:
        problem = self.cvxpy.Problem(objective, [*self.constraints, *constraints])
        for tolerance in TOLERANCES:
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")   # that it may be inaccurate: its results are verified
                    problem.solve(solver=self.cvxpy.CLARABEL, tol_gap_abs=tolerance, tol_gap_rel=tolerance,
                                  tol_feas=tolerance, accept_unknown=True)
                break
            except self.cvxpy.SolverError:
                continue
        else:
            raise StabilityError(f"{self.scaled.name}: Clarabel stopped without a solution; try another decay rate")
        if self.Q.value is None:
            raise StabilityError(f"{self.scaled.name}: the inequalities are {problem.status}, expected a solution; "
                                 "try a smaller decay rate")

    def gains(self) -> Array:
        """Ec of the solution, where they were looked for."""
        return np.asarray(self.Z.value[:, 0] / self.sizes / self.S.value[np.argmax(np.abs(self.scaled.w))])


def certificate(loop: AxisLoop, scaled: Scaled, gains: Array, solved: Inequalities, decay: float
                ) -> Certificate | None:
    """Certificate of a solution if it is one, by eigenvalues and without the solver's word."""
    q, y, s = (np.asarray(unknown.value) for unknown in (solved.Q, solved.Y, solved.S))
    if s.min() <= 0.0 or np.linalg.eigvalsh(q)[0] <= 0.0:
        return None
    p: Array = np.asarray(np.linalg.inv(q), dtype=np.float64)
    g = y @ p
    b = scaled.B + np.outer(scaled.E @ gains, scaled.w)
    decrease = decrease_of(scaled.A, b, g, p, 1.0 / s, scaled.sample_time, decay)
    if decrease < LEAST_DECREASE:
        return None
    # Between K and G the sector condition reaches to the limit: shrink the ellipsoid until it is inside.
    reach = max(1.0, float(np.diag((scaled.K - g) @ q @ (scaled.K - g).T).max()))
    p = p * reach
    original = scaled.back.T @ p @ scaled.back
    original = 0.5 * (original + original.T)
    return Certificate(gains, original, scaled.limits[:, None] * (g @ scaled.back), reach / s / scaled.limits**2,
                       float(1.0 / np.sqrt(loop.at_step @ original @ loop.at_step)), decrease)


def decrease_of(a: Array, b: Array, g: Array, p: Array, t: Array, sample_time: float, decay: float) -> float:
    """Least decrease of V + 2 decay V + 2 φᵀ T (φ − G χ) for χᵀ P χ + φᵀ T φ = 1, 1/s; negative where it grows.

    With χ' = a χ − b φ, or the divided difference of a loop sampled every `sample_time`, s; T has the diagonal t > 0,
    (m,).
    """
    change = np.column_stack([a, -b])
    n = len(a)
    matrix = np.zeros((n + len(t), n + len(t)))
    matrix[:n] = p @ change
    matrix += matrix.T
    matrix[:n, :n] += 2.0 * decay * p
    matrix += sample_time * change.T @ p @ change
    matrix[n:, :n] += t[:, None] * g
    matrix[:n, n:] += (t[:, None] * g).T
    matrix[n:, n:] -= 2.0 * np.diag(t)
    root = np.zeros_like(matrix)
    root[:n, :n] = np.linalg.cholesky(p)
    root[n:, n:] = np.diag(np.sqrt(t))
    balanced = np.linalg.solve(root, np.linalg.solve(root, matrix).T)
    return float(-np.linalg.eigvalsh(0.5 * (balanced + balanced.T))[-1])
