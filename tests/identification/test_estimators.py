"""The estimators against their equations in matrix form, solved by scipy, and against closed solutions."""

from collections.abc import Callable

import numpy as np
import pytest
from offline_data import flight
from scipy.integrate import solve_ivp

from identification.estimators import estimate, largest_squares
from identification.rigs import RIGS, Row, RowData, regressors
from scenarios.errors import ScenarioError

GAMMA, DT = 1.1, 0.5e-3
Slope = Callable[[float, np.ndarray], np.ndarray]


def lift_row(count: int) -> RowData:
    """Vertical row of the 2-DOF rig in flight."""
    data = flight("2dof", "ideal")
    part = slice(6000, 6000 + count)
    r = data.recording
    return regressors(RIGS["2dof"], r.positions[part], r.i_d[part], r.i_q[part], data.velocity[part])[0]


def run(method: str, row: RowData, guess: np.ndarray, epsilon: float, q0: float) -> np.ndarray:
    time = DT * np.arange(len(row.b))
    names = row.row.constants
    result = estimate(method, [row], time, dict(zip(names, guess.tolist(), strict=True)), epsilon, GAMMA, q0)
    assert result.names == names
    return result.theta


def solved(method: str, row: RowData, guess: np.ndarray, epsilon: float, q0: float) -> np.ndarray:
    """(3.3), (3.6)–(3.7) or (3.8) as printed in model.md, for one row, by Radau with tight tolerances."""
    p, y = row.a.shape[1], row.velocity
    sigma0 = q0 * epsilon * np.diag(largest_squares(row.a))
    size = p + 1 if method == "full" else p
    start = np.zeros((size, size))
    start[-p:, -p:] = sigma0
    if method == "full":
        start[0, 0] = 1.0 / epsilon
    # Σ in units of its scale, for the solver's absolute tolerance.
    unit = np.sqrt(np.diag(start))
    state = np.concatenate([[y[0]], guess, (start / np.outer(unit, unit)).ravel()])
    path = [guess]
    for k in range(len(y) - 1):
        a, b = 0.5 * (row.a[k] + row.a[k + 1]), 0.5 * (row.b[k] + row.b[k + 1])
        rate = (y[k + 1] - y[k]) / DT

        def slope(t: float, s: np.ndarray, a: np.ndarray = a, b: float = b, rate: float = rate,
                  y0: float = float(y[k])) -> np.ndarray:
            x, theta = s[0], s[1:1 + p]
            sigma = s[1 + p:].reshape(size, size) * np.outer(unit, unit)
            error = y0 + rate * t - x
            if method == "fsdi":
                x_rate, theta_rate = rate, np.linalg.solve(sigma, a * (rate - a @ theta - b))
                sigma_rate = (1.0 - GAMMA**-2) * np.outer(a, a)
            elif method == "reduced":
                x_rate = a @ theta + b + error / epsilon
                theta_rate = np.linalg.solve(sigma, a * error) / epsilon
                sigma_rate = (1.0 - GAMMA**-2) * np.outer(a, a)
            else:
                f, e1 = np.zeros((size, size)), np.diag([1.0, *[0.0] * p])
                f[0, 1:] = a
                weight = np.zeros((size, size))
                weight[0, 0] = epsilon**-2
                weight[1:, 1:] = -GAMMA**-2 * np.outer(a, a)
                sigma_rate = -sigma @ f - f.T @ sigma + weight - sigma @ e1 @ sigma
                gain = np.linalg.solve(sigma, np.eye(size)[0]) / epsilon**2 * error
                x_rate, theta_rate = a @ theta + b + gain[0], gain[1:]
            return np.concatenate([[x_rate], theta_rate, (sigma_rate / np.outer(unit, unit)).ravel()])

        state = solve_ivp(slope, (0.0, DT), state, method="Radau", rtol=1e-8, atol=1e-10).y[:, -1]
        path.append(state[1:1 + p])
    return np.array(path)


@pytest.mark.parametrize(("method", "q0", "tolerance"),
                         [("fsdi", 0.5, 1e-9), ("reduced", 0.5, 2e-4), ("full", 10.0, 2e-4)])
def test_recursion_solves_its_equations(method: str, q0: float, tolerance: float) -> None:
    row, truth = lift_row(80), np.array([791.0, 30.9, 0.12])
    expected = solved(method, row, 0.5 * truth, 0.01, q0)
    found = run(method, row, 0.5 * truth, 0.01, q0)
    way = np.abs(expected - expected[0]).max(axis=0)
    assert np.all(np.abs(found - expected).max(axis=0) < tolerance * way)


def constant_row(a: float, rate: float, count: int) -> RowData:
    row = Row("h", ("C1",), 0.0, lambda f, i_d, i_q: i_q)
    return RowData(row, np.full((count, 1), a), np.zeros(count), rate * DT * np.arange(count))


def test_fsdi_of_a_constant_regressor() -> None:
    """θ̃ = θ̃0 (1 + κ a² t/Q0)^(−1/κ)."""
    a, truth, count = 0.4, 14.2, 2000
    row = constant_row(a, a * truth, count)
    found = run("fsdi", row, np.array([7.0]), 0.01, 0.3)[:, 0]
    kappa, t = 1.0 - GAMMA**-2, DT * np.arange(count)
    expected = truth + (7.0 - truth) * (1.0 + kappa * t / (0.3 * 0.01)) ** (-1.0 / kappa)
    assert found == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("method", ["reduced", "full", "fsdi"])
def test_truth_is_a_fixed_point(method: str) -> None:
    row = constant_row(0.4, 0.4 * 14.2, 4000)
    assert run(method, row, np.array([14.2]), 0.01, 8.0) == pytest.approx(np.full((4000, 1), 14.2), rel=1e-12)


@pytest.mark.parametrize("epsilon", [1e-4, 1e-3, 0.01])
def test_tiny_start_weight_is_stable(epsilon: float) -> None:
    """Σ starts ten orders of magnitude below where it is after a sample; ε may be shorter than the sample."""
    row, truth = lift_row(4000), np.array([791.0, 30.9, 0.12])
    found = run("reduced", row, 0.5 * truth, epsilon, 1e-8)
    assert np.all(np.isfinite(found))
    assert found[-1, :2] == pytest.approx(truth[:2], rel=0.05)


def test_reduced_and_full_agree_as_epsilon_falls() -> None:
    data = flight("2dof", "ideal")
    r = data.recording
    rows = regressors(r.rig, r.positions[:40001], r.i_d[:40001], r.i_q[:40001], data.velocity[:40001])
    guess = {name: 0.5 * value for name, value in data.truth.items()}
    apart = []
    for epsilon in (0.02, 0.005, 0.00125):
        reduced, full = (np.array(list(estimate(method, rows, r.time[:40001], guess, epsilon).final.values()))
                         for method in ("reduced", "full"))
        apart.append(np.abs(reduced / full - 1.0).max())
    assert apart[0] > 3.0 * apart[1] > 9.0 * apart[2]
    assert apart[2] < 1e-3


@pytest.mark.parametrize(("arguments", "message"), [
    ({"method": "redused"}, "method redused: expected one of reduced, full, fsdi; nearest is 'reduced'"),
    ({"epsilon": 0.0}, "epsilon = 0.0: expected a time above 0 s, such as 0.01"),
    ({"epsilon": float("nan")}, "epsilon = nan: expected a time above 0 s, such as 0.01"),
    ({"gamma": 1.0}, "gamma = 1.0: expected more than 1, such as 1.1"),
    ({"method": "full", "q0": 1e-3}, "axis h: Σ of (3.7) is not positive definite after")])
def test_refusals(arguments: dict[str, object], message: str) -> None:
    row = constant_row(0.4, 5.0, 100)
    settings = {"method": "reduced", "rows": [row], "time": DT * np.arange(100), "guess": {"C1": 7.0}, **arguments}
    with pytest.raises(ScenarioError) as refused:
        estimate(**settings)   # type: ignore[arg-type]
    assert str(refused.value).startswith(message)
