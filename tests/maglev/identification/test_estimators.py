"""The estimators against their equations in matrix form, solved by scipy, and against closed solutions."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from facts import raises
from identification_data import Data, record, trial
from scipy.integrate import solve_ivp

from maglev.files.errors import IdentificationError
from maglev.identification.estimators import Samples, fsdi, largest_squares, mean_behind_lag, run_estimator
from maglev.identification.regressors import ESTIMATED_STAGES, ConstantRow, RowData, regressors

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

GAMMA, DT = 1.1, 0.5e-3
Slope = Callable[[float, np.ndarray], np.ndarray]


@cache
def start() -> Data:
    """The first seconds of an excited 2-DOF stage."""
    return record("2dof", 6.0, DT)


def lift_row(count: int) -> RowData:
    """Vertical row of the 2-DOF stage while it runs."""
    data = start()
    part = slice(6000, 6000 + count)
    r = data.recording
    return regressors(ESTIMATED_STAGES["2dof"], r.positions[part], r.i_d[part], r.i_q[part], data.velocity[part])[0]


def run(method: str, row: RowData, guess: np.ndarray, epsilon: float, q0: float) -> np.ndarray:
    time = DT * np.arange(len(row.b), dtype=float)
    names = row.row.constants
    result = run_estimator(method, [row], time, dict(zip(names, guess.tolist(), strict=True)), epsilon, GAMMA, q0)
    assert result.names == names
    return result.theta


def solved(method: str, row: RowData, guess: np.ndarray, epsilon: float, q0: float) -> np.ndarray:
    """(3.3) behind the lag, (3.6)–(3.7) or (3.8) in matrix form, for one row, by Radau with tight tolerances."""
    p, y = row.a.shape[1], row.velocity
    sigma0 = q0 * epsilon * np.diag(largest_squares(row.a))
    size = p + 1 if method == "full" else p
    start = np.zeros((size, size))
    start[-p:, -p:] = sigma0
    if method == "full":
        start[0, 0] = 1.0 / epsilon
    # Σ in units of its scale, for the solver's absolute tolerance.
    unit = np.sqrt(np.diag(start))
    # At the end velocity, regressor and b behind the lag, which (3.3) is about.
    state = np.concatenate([[y[0]], guess, (start / np.outer(unit, unit)).ravel(), [y[0]], np.zeros(p + 1)])
    path = [guess]
    for k in range(len(y) - 1):
        a, b = 0.5 * (row.a[k] + row.a[k + 1]), 0.5 * (row.b[k] + row.b[k + 1])
        rate = (y[k + 1] - y[k]) / DT

        def slope(t: float, s: np.ndarray, a: np.ndarray = a, b: float = b, rate: float = rate,
                  y0: float = float(y[k])) -> np.ndarray:
            x, theta = s[0], s[1:1 + p]
            sigma = s[1 + p:-2 - p].reshape(size, size) * np.outer(unit, unit)
            error = y0 + rate * t - x
            lag_rate = (np.array([y0 + rate * t, *a, b]) - s[-2 - p:]) / epsilon
            if method == "fsdi":
                lagged_a, lagged_b = s[-1 - p:-1], s[-1]
                x_rate, theta_rate = 0.0, np.linalg.solve(
                    sigma, lagged_a * (lag_rate[0] - lagged_a @ theta - lagged_b))
                sigma_rate = (1.0 - GAMMA**-2) * np.outer(lagged_a, lagged_a)
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
            return np.concatenate([[x_rate], theta_rate, (sigma_rate / np.outer(unit, unit)).ravel(), lag_rate])

        state = solve_ivp(slope, (0.0, DT), state, method="Radau", rtol=1e-8, atol=1e-10).y[:, -1]
        path.append(state[1:1 + p])
    return np.array(path)


@pytest.mark.parametrize(("method", "q0", "tolerance"),
                         [("fsdi", 0.5, 4e-4), ("reduced", 0.5, 2e-4), ("full", 10.0, 2e-4)])
def test_recursion_solves_its_equations(method: str, q0: float, tolerance: float) -> None:
    row, truth = lift_row(80), np.array([791.0, 30.9, 0.12])
    expected = solved(method, row, 0.5 * truth, 0.01, q0)
    found = run(method, row, 0.5 * truth, 0.01, q0)
    way = np.abs(expected - expected[0]).max(axis=0)
    assert np.all(np.abs(found - expected).max(axis=0) < tolerance * way)


def test_fsdi_is_of_second_order() -> None:
    """What is held between two samples in parts: a quarter of the distance to the solution for half the step."""
    row, guess, epsilon, q0 = lift_row(40), np.array([400.0, 15.0, 0.06]), 0.01, 0.05
    a, c = 0.5 * (row.a[1:] + row.a[:-1]), np.diff(row.velocity) / DT - 0.5 * (row.b[1:] + row.b[:-1])
    expected = solved("fsdi", row, guess, epsilon, q0)
    sigma0 = q0 * epsilon * np.diag(largest_squares(row.a))
    apart = []
    for parts in (1, 2, 4):
        samples = mean_behind_lag(Samples(np.repeat(a, parts, axis=0), np.repeat(c, parts), DT / parts), epsilon)
        apart.append(np.abs(fsdi(samples, guess, sigma0, GAMMA)[::parts] - expected).max(axis=0))
    assert apart[0] / apart[1] == pytest.approx(np.full(3, 4.0), rel=0.05)
    assert apart[1] / apart[2] == pytest.approx(np.full(3, 4.0), rel=0.05)


def constant_row(a: float, rate: float, count: int) -> RowData:
    row = ConstantRow("h", ("C1",), 0.0, lambda f, i_d, i_q: i_q)
    return RowData(row, np.full((count, 1), a), np.zeros(count), rate * DT * np.arange(count, dtype=float))


def test_fsdi_of_a_constant_regressor() -> None:
    """θ̃ = θ̃0 (1 + κ/Q0 ∫af² dt)^(−1/κ), af = a (1 − exp(−t/ε)); without the lag ∫af² dt = a² t."""
    a, truth, epsilon, count = 0.4, 14.2, 0.01, 2000
    row = constant_row(a, a * truth, count)
    kappa, t = 1.0 - GAMMA**-2, DT * np.arange(count)
    weight = 0.3 * epsilon * a**2

    def expected(integral: np.ndarray) -> np.ndarray:
        return truth + (7.0 - truth) * (1.0 + kappa / weight * integral) ** (-1.0 / kappa)

    found = run("fsdi", row, np.array([7.0]), epsilon, 0.3)[:, 0]
    lagged = a**2 * (t + 2.0 * epsilon * np.expm1(-t / epsilon) - 0.5 * epsilon * np.expm1(-2.0 * t / epsilon))
    assert found == pytest.approx(expected(lagged), rel=2.5e-4)   # of the mean between two samples
    sigma0 = np.array([[weight]])
    bare = fsdi(Samples(row.a[1:], np.diff(row.velocity) / DT, DT), np.array([7.0]), sigma0, GAMMA)[:, 0]
    assert bare == pytest.approx(expected(a**2 * t), rel=1e-11)


def test_mean_behind_lag() -> None:
    """Between samples the mean behind the lag; as ε falls, what is held itself."""
    epsilon, t = 0.01, DT * np.arange(200)
    held = Samples(np.full((199, 1), 3.0), np.full(199, 2.0), DT)
    found = mean_behind_lag(held, epsilon)
    means = 1.0 + epsilon / DT * np.diff(np.exp(-t / epsilon))
    assert found.a[:, 0] == pytest.approx(3.0 * means, rel=1e-10)
    assert found.c == pytest.approx(2.0 * means, rel=1e-10)
    assert mean_behind_lag(held, 1e-12 * DT).c == pytest.approx(held.c, rel=1e-11)


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


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
def test_reduced_and_full_agree_as_epsilon_falls() -> None:
    data = trial("2dof", "ideal")
    r = data.recording
    rows = regressors(r.stage, r.positions[:40001], r.i_d[:40001], r.i_q[:40001], data.velocity[:40001])
    guess = {name: 0.5 * value for name, value in data.truth.items()}
    apart = []
    for epsilon in (0.02, 0.005, 0.00125):
        reduced, full = (np.array(list(run_estimator(method, rows, r.time[:40001], guess, epsilon).final.values()))
                         for method in ("reduced", "full"))
        apart.append(np.abs(reduced / full - 1.0).max())
    assert apart[0] > 3.0 * apart[1] > 9.0 * apart[2]
    assert apart[2] < 1e-3


@pytest.mark.parametrize(("arguments", "facts"), [
    ({"method": "redused"}, ["method", "redused", "full", "fsdi", "'reduced'"]),
    ({"epsilon": 0.0}, ["epsilon", "0.0", "0 s"]), ({"epsilon": float("nan")}, ["epsilon", "nan", "0 s"]),
    ({"gamma": 1.0}, ["gamma", "1.0", "1", "1.1"]), ({"method": "full", "q0": 1e-3}, ["axis h", "(3.7)"])])
def test_refusals(arguments: dict[str, object], facts: list[str]) -> None:
    row = constant_row(0.4, 5.0, 100)
    settings = {"method": "reduced", "rows": [row], "time": DT * np.arange(100), "guess": {"C1": 7.0}, **arguments}
    with raises(IdentificationError, *facts):
        run_estimator(**settings)   # type: ignore[arg-type]
