"""Parts of the estimators, each by itself, and what an estimator does with samples that tell it nothing."""

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from direct_loop import LAYOUTS
from estimator_run import TRUTH, constants, new_estimator, run
from hypothesis import example, given, settings
from hypothesis import strategies as st
from motor import MOTOR
from scipy.linalg import expm
from scipy.optimize import brentq

from controller_fmu.constant_estimate import ConstantEstimate, ConvergenceRule
from controller_fmu.matched_filter import MatchedFilter
from controller_fmu.status import STEP_MISFIT
from controller_fmu.symmetric3 import Symmetric3
from controller_fmu.velocity_model import two_states
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from pmlsm.gap_functions import gap_functions

VERTICAL = {2: ("v", 20e-3), 3: ("y", 25e-3)}

rows3 = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


def full(sigma: Symmetric3) -> np.ndarray:
    """The matrix."""
    return np.array([[sigma.s11, sigma.s21, sigma.s31], [sigma.s21, sigma.s22, sigma.s32],
                     [sigma.s31, sigma.s32, sigma.s33]])


@given(st.lists(rows3, min_size=0, max_size=6), rows3, st.floats(1e-3, 1.0))
def test_symmetric3(squares: list[tuple[float, float, float]], a: tuple[float, float, float], diagonal: float) -> None:
    sigma = Symmetric3()
    sigma.set_diagonal(diagonal, 2.0 * diagonal, 3.0 * diagonal)
    expected = diagonal * np.diag([1.0, 2.0, 3.0])
    for row in squares:
        sigma.add_square(0.5, *row)
        expected += 0.5 * np.outer(row, row)
    assert full(sigma) == pytest.approx(expected, rel=1e-13, abs=1e-13)
    sigma.factorise()
    size = float(np.linalg.cond(expected)) * 1e-13
    assert sigma.solve(*a) == pytest.approx(np.linalg.solve(expected, a), rel=size, abs=size / diagonal)
    assert sigma.inverse_diagonal() == pytest.approx(np.diag(np.linalg.inv(expected)), rel=size, abs=size / diagonal)
    sigma.decay(0.25, diagonal, 2.0 * diagonal, 3.0 * diagonal)
    assert full(sigma) == pytest.approx(0.75 * expected + 0.25 * diagonal * np.diag([1.0, 2.0, 3.0]), rel=1e-13)


@given(rows3)
@example((0.0, 0.0, 2.63510040035617e-158))
def test_singular_matrix_leaves_rows_out(a: tuple[float, float, float]) -> None:
    """What depends on rows before it gets 0; nothing is divided by zero."""
    sigma = Symmetric3()
    sigma.set_diagonal(0.0, 0.0, 0.0)
    sigma.add_square(1.0, *a)
    sigma.factorise()
    u = np.array(sigma.solve(*a))
    assert np.isfinite(u).all()
    assert np.count_nonzero(u) <= 1
    assert np.isfinite(sigma.inverse_diagonal()).all()


@given(st.floats(0.0, 1e6), st.floats(1e-4, 0.1), st.floats(1e-6, 1e-2))
def test_two_states(gain: float, epsilon: float, tau: float) -> None:
    p, q, r, k = two_states(gain, epsilon, tau)
    # With w in units of √(s/ε) every entry is of the order of one.
    unit = math.sqrt(gain / epsilon) if gain > 1e-3 else 1.0
    exact = expm(tau * np.array([[-1 / epsilon, -unit], [gain / epsilon / unit, 0.0]]))
    assert np.array([[p, -q * unit], [r / unit, k]]) == pytest.approx(exact, rel=1e-7, abs=1e-7)


@given(st.floats(1e17, 1e24), st.floats(1e-3, 0.1))
def test_two_states_of_more_turns_than_an_angle_keeps(gain: float, epsilon: float) -> None:
    """As close as the rounding of the angle lets them be, and no wave is lost where that is a turn and more."""
    tau = 5e-4
    p, q, r, k = two_states(gain, epsilon, tau)
    with mpmath.workdps(60):
        damping, stiffness = 1 / (2 * mpmath.mpf(epsilon)), mpmath.mpf(gain) / mpmath.mpf(epsilon)
        root = mpmath.sqrt(stiffness - damping ** 2)
        angle, left = root * tau, mpmath.exp(-damping * tau)
        c, s = mpmath.cos(angle), mpmath.sin(angle) / root
        scales = [left, left / root, left * root, left]
        exact = [left * each for each in (c - damping * s, s, stiffness * s, c + damping * s)]
        for found, expected, scale in zip((p, q, r, k), exact, scales, strict=True):
            assert abs(float((found - expected) / scale)) < 5.0 * 2.0**-53 * float(angle) + 1e-6
        assert float((p / scales[0]) ** 2 + (q / scales[1]) ** 2) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("epsilon", [0.001, 0.01])
def test_two_states_where_the_rates_meet(epsilon: float) -> None:
    """The two formulas and the one between them agree."""
    tau, critical = 5e-4, 0.25 / epsilon
    near = [two_states(critical * (1.0 + d), epsilon, tau) for d in (-1e-4, -1e-9, 0.0, 1e-9, 1e-4)]
    for each in near:
        assert each == pytest.approx(near[2], rel=1e-3)
    assert near[1] == pytest.approx(near[3], rel=1e-8)


def test_matched_filter_is_the_observers() -> None:
    """v' = a θ in mean values over samples holds exactly behind the filters."""
    filters, observer, matched, dt = ObserverFilter(), VelocityObserver(), MatchedFilter(), 5e-4
    filters.time1, filters.time2 = 1e-3, 3e-3
    filters.prepare(dt)
    a = np.concatenate([[0.0], np.random.default_rng(0).normal(size=200)])
    position = np.cumsum(np.cumsum(a) * dt) * dt
    before = 0.0
    for k in range(len(a)):
        observer.update(float(position[k]), filters, dt)
        assert (observer.velocity - before) / dt == pytest.approx(matched.update(float(a[k]), filters), abs=1e-9)
        before = observer.velocity


def test_convergence() -> None:
    watched, rule, dt = ConstantEstimate(0.0, 1.0), ConvergenceRule(), 0.5

    def after(values: list[float], uncertainty: float = 1e-3) -> bool:
        for value in values:
            watched.value = value
            watched.watch(uncertainty, rule, dt)
        return watched.converged

    assert not after([-2.0] * 10)
    assert after([-2.0] * 2)
    assert after([-2.01, -1.99])
    assert not after([-2.03])
    assert after([-2.03] * 10)
    assert not after([-2.03], uncertainty=0.2), "data say little more than the guess"


@pytest.mark.parametrize("stage", [2, 3])
class TestEstimator:
    def still(self, stage: int, count: int, gap: float, i_d: float) -> dict[str, np.ndarray]:
        """Run at rest with a direct current."""
        axes, motors, dt = LAYOUTS[stage]
        trial = {"time": dt * np.arange(count)} | {f"{name}.encoder": np.zeros(count) for name in axes}
        trial[f"{axes[0]}.encoder"] += gap
        for name in motors:
            trial |= {f"{name}.i_d": np.full(count, i_d), f"{name}.i_q": np.zeros(count)}
        return trial

    def test_no_thrust_no_change(self, stage: int) -> None:
        """Without quadrature current the thrusts keep their guess bit for bit, whatever the vertical row learns."""
        estimator = new_estimator(stage, TRUTH[stage])
        estimates = run(stage, estimator, self.still(stage, 500, VERTICAL[stage][1], 0.3))
        thrusts = slice(0, stage - 1)
        assert (estimates[:, thrusts] == TRUTH[stage][thrusts]).all()
        assert not getattr(estimator, LAYOUTS[stage][0][1]).thrust.converged

    def test_equilibrium_of_the_model_no_change(self, stage: int) -> None:
        gap = VERTICAL[stage][1]
        _, f2, f3, f4 = gap_functions(MOTOR, gap)
        c2, c3, c4 = TRUTH[stage][-3:] * (1.0 if stage == 2 else 4.0)
        held = brentq(lambda i: 9.81 - c4 * f4 * i * i + c3 * f3 * i - c2 * f2, -5.0, 5.0, xtol=1e-15)
        estimates = run(stage, new_estimator(stage, TRUTH[stage]), self.still(stage, 500, gap, held))
        assert estimates == pytest.approx(np.tile(TRUTH[stage], (500, 1)), rel=1e-9)

    def test_no_measurement_yet(self, stage: int) -> None:
        """A gap of 0 is what an importer has that has not exchanged values: nothing begins."""
        estimator = new_estimator(stage, TRUTH[stage])
        run(stage, estimator, self.still(stage, 20, 0.0, 1.0))
        assert not estimator.started
        run(stage, estimator, self.still(stage, 1, VERTICAL[stage][1], 1.0))
        assert estimator.started
        assert getattr(estimator, VERTICAL[stage][0]).velocity == 0.0

    def test_weight_holds_a_constant(self, stage: int) -> None:
        last = len(TRUTH[stage])
        estimator = new_estimator(stage, TRUTH[stage], **{f"C{last}_weight": 1e12, f"C{last - 1}_weight": 1e12})
        estimates = run(stage, estimator, self.still(stage, 2000, VERTICAL[stage][1], 0.3))
        assert estimates[-1, -2:] == pytest.approx(TRUTH[stage][-2:], rel=1e-9)
        assert abs(estimates[-1, -3] / TRUTH[stage][-3] - 1.0) > 1e-3

    def test_step_that_does_not_divide_the_sample_time(self, stage: int) -> None:
        estimator = new_estimator(stage, TRUTH[stage])
        dt = LAYOUTS[stage][2]
        assert estimator.step(0.0, 0.7 * dt) == STEP_MISFIT
        assert estimator.step(0.0, 0.5 * dt) == 0

    def test_half_steps_sample_once(self, stage: int) -> None:
        dt = LAYOUTS[stage][2]
        whole, half = new_estimator(stage, TRUTH[stage]), new_estimator(stage, TRUTH[stage])
        for k in range(50):
            self.excite(stage, whole, k)
            assert whole.step(k * dt, dt) == 0
            self.excite(stage, half, k)
            assert half.step(k * dt, 0.5 * dt) == 0
            self.excite(stage, half, k + 7)   # between two samples: not looked at
            assert half.step((k + 0.5) * dt, 0.5 * dt) == 0
        assert constants(stage, whole) == constants(stage, half)

    def excite(self, stage: int, estimator: Any, k: int) -> None:
        """Some inputs."""
        axes, motors, _ = LAYOUTS[stage]
        for i, name in enumerate(axes):
            getattr(estimator, name).measured = (VERTICAL[stage][1] if i == 0 else 0.0) + 1e-5 * math.sin(0.7 * k + i)
        for i, name in enumerate(motors):
            getattr(estimator, name).i_d, getattr(estimator, name).i_q = math.sin(0.3 * k + i), math.cos(0.2 * k + i)


@settings(max_examples=60)
@given(st.sampled_from([2, 3]), st.lists(st.tuples(st.floats(-10.0, 10.0), st.floats(-10.0, 10.0),
                                                   st.floats(-1000.0, 1000.0), st.floats(-1000.0, 1000.0)),
                                         min_size=1, max_size=40),
       st.sampled_from([1e-5, 1e-3, 0.01, 10.0]), st.sampled_from([1.0, 1.1, 1e3]), st.sampled_from([0.0, 0.3, 1e3]),
       st.sampled_from([1e-20, 1e-6, 1.0, 1e20]), st.booleans())
def test_whatever_comes_in(stage: int, samples: list[tuple[float, float, float, float]], epsilon: float, gamma: float,
                           forgetting: float, weight: float, matched: bool) -> None:
    """Any inputs and parameters within their ranges: finite estimates, and Σ stays symmetric and positive."""
    axes, motors, dt = LAYOUTS[stage]
    names = [f"C{i + 1}" for i in range(len(TRUTH[stage]))]
    estimator = new_estimator(stage, TRUTH[stage], epsilon=epsilon, gamma=gamma, forgetting=forgetting,
                              matched_filter=matched, **{f"{name}_weight": weight for name in names})
    for k, (gap, displacement, i_d, i_q) in enumerate(samples):
        for i, name in enumerate(axes):
            getattr(estimator, name).measured = gap if i == 0 else displacement
        for name in motors:
            getattr(estimator, name).i_d, getattr(estimator, name).i_q = i_d, i_q
        assert estimator.step(k * dt, dt) == 0
        sigma = full(getattr(estimator, axes[0]).information)
        assert np.isfinite(constants(stage, estimator)).all()
        scale = np.sqrt(np.diag(sigma))
        assert (scale > 0.0).all()
        assert np.linalg.eigvalsh(sigma / np.outer(scale, scale)).min() > -1e-12
        assert all(getattr(estimator, name).information > 0.0 for name in axes[1:])
