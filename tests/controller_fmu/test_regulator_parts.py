"""Parts of the regulators, each by itself: observer, internal model, linearisation, limits, clock."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from controller_fmu.feedback_linearisation import smaller_root
from controller_fmu.internal_model import InternalModel, OscillatorStep, integral_of_sine
from controller_fmu.motor_command import MotorCommand
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from pmlsm.dq_transform import clarke, park

TS = 0.5e-3


def observe(positions: np.ndarray, time1: float = 1e-3, time2: float = 1e-3) -> VelocityObserver:
    filters, observer = ObserverFilter(), VelocityObserver()
    filters.time1, filters.time2 = time1, time2
    filters.prepare(TS)
    observer.seed(float(positions[0]))
    for position in positions:
        observer.update(float(position), filters, TS)
    return observer


def test_observer_reads_a_ramp_exactly() -> None:
    assert observe(0.02 + 0.3 * TS * np.arange(200)).velocity == pytest.approx(0.3, rel=1e-12)


def test_observer_against_its_continuous_filters() -> None:
    """First stage: exact sampling of a lag, and its rate; second stage: exact sampling of a lag of that rate."""
    rng = np.random.default_rng(1)
    positions = np.cumsum(rng.normal(0.0, 1e-5, 50))
    low, velocity = positions[0], 0.0
    for y in positions:
        before = low
        low = y + (low - y) * math.exp(-TS / 1e-3)
        velocity = (low - before) / TS + (velocity - (low - before) / TS) * math.exp(-TS / 2e-3)
    assert observe(positions, 1e-3, 2e-3).velocity == pytest.approx(velocity, rel=1e-9)


def test_observer_without_filters_is_the_difference() -> None:
    assert observe(np.array([0.0, 1e-3, 3e-3]), 0.0, 0.0).velocity == pytest.approx(2e-3 / TS)


@pytest.mark.parametrize("angle", [0.0, 1e-6, 1e-3, 0.1, 0.49, 0.51, 1.0, 3.0])
def test_oscillator_step_is_the_exact_discretisation(angle: float) -> None:
    oscillator, omega = OscillatorStep(), angle / TS
    oscillator.prepare(omega, TS)
    phi = np.zeros((4, 4))
    phi[0, 1] = phi[1, 2] = phi[2, 3] = 1.0
    phi[2, 1] = -omega**2
    # With time in units of TS every entry is of the order of one, so that expm is accurate.
    scale = np.diag([TS**3, TS**2, TS, 1.0])
    exact = scale @ expm(np.linalg.inv(scale) @ phi @ scale * TS) @ np.linalg.inv(scale)
    ours = np.array([[1.0, oscillator.sine, oscillator.versine, oscillator.ramp],
                     [0.0, oscillator.cosine, oscillator.sine, oscillator.versine],
                     [0.0, oscillator.minus_sine, oscillator.cosine, oscillator.sine]])
    assert ours == pytest.approx(exact[:3], rel=1e-12, abs=1e-14 * TS**3)


@given(st.floats(1e-8, 3.1))
def test_integral_of_sine(x: float) -> None:
    with mpmath.workdps(60):
        exact = (mpmath.mpf(x) - mpmath.sin(mpmath.mpf(x))) / mpmath.mpf(x)**3
    assert integral_of_sine(x) == pytest.approx(float(exact), rel=1e-14)


def test_internal_model_is_marginally_stable() -> None:
    """Without input the oscillation keeps its amplitude over 1e6 samples."""
    oscillator, model = OscillatorStep(), InternalModel()
    omega = 1.5 * math.pi
    oscillator.prepare(omega, 0.2e-3)
    model.xi2, model.xi3 = 1e-3, 2e-3

    def amplitude() -> float:
        return (omega * model.xi2)**2 + model.xi3**2

    before = amplitude()
    for _ in range(1_000_000):
        model.update(0.0, oscillator, 0.0, 0.0, 0.0)
    assert amplitude() == pytest.approx(before, rel=1e-8)
    assert abs(model.xi1) < 1e-2


@given(st.floats(1e-3, 10.0), st.floats(0.1, 50.0), st.floats(-100.0, 100.0))
def test_smaller_root(a: float, b: float, c: float) -> None:
    root, real = smaller_root(a, b, c)
    if b * b < 4.0 * a * c:
        assert not real
        assert root == b / (2.0 * a)
        return
    assert real
    assert a * root**2 - b * root + c == pytest.approx(0.0, abs=1e-10 * (b * b / a + abs(c)))
    assert root <= b / (2.0 * a)


@given(st.floats(-10.0, 10.0), st.floats(-10.0, 10.0), st.floats(-0.06, 0.06), st.floats(0.0, 8.0))
def test_motor_command(i_d: float, i_q: float, displacement: float, limit: float) -> None:
    motor = MotorCommand()
    motor.command(i_d, i_q, limit, displacement)
    bound = limit if limit > 0.0 else math.inf
    assert (motor.i_d_cmd, motor.i_q_cmd) == (min(max(i_d, -bound), bound), min(max(i_q, -bound), bound))
    assert motor.limited == (abs(i_d) > bound or abs(i_q) > bound)
    assert (motor.excess_d, motor.excess_q) == (motor.i_d_cmd - i_d, motor.i_q_cmd - i_q)
    made = park(*clarke(motor.i_a_cmd, motor.i_b_cmd, motor.i_c_cmd), displacement)
    assert made == pytest.approx((motor.i_d_cmd, motor.i_q_cmd), abs=1e-13)
    motor.release()
    assert motor.i_a_cmd == motor.i_b_cmd == motor.i_c_cmd == motor.i_d_cmd == motor.i_q_cmd == 0.0


@pytest.mark.parametrize(("error", "trip", "expected"), [(1e-3, 0.0, False), (1e-3, 1e-3, False), (1.1e-3, 1e-3, True),
                                                         (-1.1e-3, 1e-3, True), (-1e-4, 1e-3, False)])
def test_trip_threshold(error: float, trip: float, expected: bool) -> None:
    assert exceeds(error, trip) is expected


@given(st.integers(1, 12), st.lists(st.floats(-1e-12, 1e-12), min_size=300, max_size=300))
def test_clock_samples_every_nth_step_whatever_the_rounding(count: int, noise: list[float]) -> None:
    clock = SampleClock()
    for k, relative in enumerate(noise):
        dt = TS / count * (1.0 + relative)
        assert clock.fits(dt, TS)
        assert clock.due(dt, TS) == (k % count == 0)


@pytest.mark.parametrize("dt", [2 * TS, 0.9 * TS, 0.4 * TS, 1.001 * TS, TS / 2.5])
def test_clock_refuses_other_steps(dt: float) -> None:
    assert not SampleClock().fits(dt, TS)
