"""The estimator against scipy's solution of (3.8), inputs held over each sample, with everything written again."""

from collections.abc import Callable

import numpy as np
import pytest
from direct_loop import LAYOUTS
from estimator_run import PLACES, TRUE_VELOCITY, TRUTH, new_estimator, run
from reference_stage import G, shape_functions
from scipy.integrate import solve_ivp

from maglev.fmi.definition import read

Rows = list[tuple[list[int], np.ndarray, float]]   # constants, row A, b of each axis


def rows(stage: int, sample: dict[str, float]) -> Rows:
    """Rows of (4.3), (5.3) at a sample, in the order of the axes."""
    if stage == 2:
        f1, f2, f3, f4 = shape_functions(sample["v.encoder"])
        i_d, i_q = sample["motor.i_d"], sample["motor.i_q"]
        return [([1, 2, 3], np.array([-f2, f3 * i_d, -f4 * (i_d**2 + i_q**2)]), G),
                ([0], np.array([-f1 * i_q]), 0.0)]
    f1, f2, f3, f4 = shape_functions(sample["y.encoder"])
    d = np.array([sample["alpha.i_d"], sample["beta.i_d"]])
    q = np.array([sample["alpha.i_q"], sample["beta.i_q"]])
    return [([2, 3, 4], np.array([-4 * f2, 2 * f3 * d.sum(), -2 * f4 * (d @ d + q @ q)]), G),
            ([0], np.array([-2 * f1 * q[0]]), 0.0), ([1], np.array([-2 * f1 * q[1]]), 0.0)]


def solve(stage: int, trial: dict[str, np.ndarray], start: np.ndarray, weights: np.ndarray, epsilon: float,
          gamma: float, forgetting: float) -> np.ndarray:
    """Estimates after every sample, shape (samples, constants)."""
    axes, _, dt = LAYOUTS[stage]
    samples = [dict(zip(trial, values, strict=True)) for values in zip(*trial.values(), strict=True)]
    estimates = np.empty((len(samples), len(start)))
    for number, (constants, _, _) in enumerate(rows(stage, samples[0])):
        n, position = len(constants), trial[f"{axes[number]}.encoder"]
        velocity = np.diff(position, prepend=position[0]) / dt
        q0 = np.diag(weights[constants])
        state = np.concatenate([start[constants], q0.ravel(), [0.0]])
        for k, sample in enumerate(samples):
            _, a, b = rows(stage, sample)[number]
            y, grown = velocity[k], ((1 - gamma**-2) * np.outer(a, a) + forgetting * q0).ravel()

            def rates(_: float, z: np.ndarray, a: np.ndarray = a, b: float = b, y: float = y, n: int = n,
                      grown: np.ndarray = grown) -> np.ndarray:
                theta, sigma, error = z[:n], z[n:-1], (y - z[-1]) / epsilon
                gain = np.linalg.solve(sigma.reshape(n, n), a) if n > 1 else a / sigma
                return np.concatenate([gain * error, grown - forgetting * sigma, [a @ theta + b + error]])

            state = solve_ivp(rates, (0, dt), state, method="DOP853", rtol=1e-10, atol=1e-13).y[:, -1]
            estimates[k, constants] = state[:n]
    return estimates


@pytest.mark.few(2)
@pytest.mark.parametrize(("stage", "epsilon", "gamma", "forgetting", "weight", "tolerance"), [
    (2, 0.01, 1.1, 0.0, 1.0, 2e-4), (2, 0.001, 1.1, 0.0, 1.0, 1e-3), (2, 0.05, 1.1, 0.0, 1.0, 2e-4),
    (2, 0.001, 1.1, 0.0, 100.0, 2e-6), (2, 0.01, 2.0, 0.5, 1.0, 3e-4), (2, 0.01, 1.0, 0.0, 100.0, 1e-12),
    pytest.param(3, 0.01, 1.1, 0.0, 1.0, 3e-4, marks=pytest.mark.thorough), (3, 0.001, 1.1, 0.0, 1.0, 3e-4)])
def test_against_scipy(trial: Callable[..., dict[str, np.ndarray]], stage: int, epsilon: float, gamma: float,
                       forgetting: float, weight: float, tolerance: float) -> None:
    """0.2 s from anywhere: the estimates first go far away, and all the time where scipy's go.

    The distance is relative to how far they go. With γ = 1 Σ is constant, and the solution is exact.
    """
    count = round(0.2 / LAYOUTS[stage][2])
    middle = {name: values[20_000:20_000 + count] for name, values in trial(stage, seconds=20.0).items()}
    names = [f"C{i + 1}" for i in range(len(TRUTH[stage]))]
    default = new_estimator(stage, TRUTH[stage])
    weights = weight * np.array([read(default, PLACES[stage][f"{name}_weight"]) for name in names])
    weighted = {f"{name}_weight": float(w) for name, w in zip(names, weights, strict=True)}
    estimator = new_estimator(stage, 0.5 * TRUTH[stage], epsilon=epsilon, gamma=gamma, forgetting=forgetting,
                              **TRUE_VELOCITY, **weighted)
    exact = solve(stage, middle, 0.5 * TRUTH[stage], weights, epsilon, gamma, forgetting)
    ours = run(stage, estimator, middle)
    reach = np.abs(exact - 0.5 * TRUTH[stage]).max(axis=0) + TRUTH[stage]
    distance = np.abs(ours - exact).max(axis=0) / reach
    assert (distance < tolerance).all()
