"""Parts of the regulators, each by itself: observer, internal model, linearisation, limits, clock."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from motor import MOTOR
from scipy.linalg import expm
from scipy.signal import cont2discrete

from controller_fmu.feedback_linearisation import smaller_root
from controller_fmu.internal_model import InternalModel, OscillatorStep, integral_of_sine
from controller_fmu.motor_command import MotorCommand
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from pmlsm.dq_transform import clarke, park
from pmlsm.sine_cosine import sine_cosine

TS = 0.5e-3


TIMES = [(1e-3, 1e-3), (1e-3, 2e-3), (5e-3, 0.2e-3), (1e-3, 0.0), (0.0, 1e-3), (0.0, 0.0)]


def observe(positions: np.ndarray, time1: float = 1e-3, time2: float = 1e-3) -> np.ndarray:
    """Velocities (m/s) that an observer seeded with the first position reads at every sample."""
    filters, observer = ObserverFilter(), VelocityObserver()
    filters.time1, filters.time2 = time1, time2
    filters.prepare(TS)
    observer.seed(float(positions[0]))
    velocities = []
    for position in positions:
        observer.update(float(position), filters, TS)
        velocities.append(observer.velocity)
    return np.array(velocities)


@pytest.mark.parametrize(("time1", "time2"), TIMES)
def test_observer_reads_a_ramp_exactly(time1: float, time2: float) -> None:
    velocities = observe(0.02 + 0.3 * TS * np.arange(400), time1, time2)
    assert velocities[-1] == pytest.approx(0.3, rel=1e-12)


def test_observer_is_seeded_at_rest() -> None:
    assert (observe(np.full(5, 0.0237)) == 0.0).all()


@pytest.mark.parametrize(("time1", "time2"), TIMES)
def test_observer_is_its_two_filters_sampled_exactly(time1: float, time2: float) -> None:
    """First stage: a lag and the mean rate of its output; second stage: a lag of that rate."""
    positions = np.cumsum(np.random.default_rng(1).normal(0.0, 1e-5, 200))

    def sampled_lag(time_constant: float) -> tuple[float, float]:
        if time_constant == 0.0:
            return 0.0, 1.0
        a, b, c, d = (np.array([[x]]) for x in (-1 / time_constant, 1 / time_constant, 1.0, 0.0))
        a, b, *_ = cont2discrete((a, b, c, d), TS, method="zoh")
        return a.item(), b.item()

    (a1, b1), (a2, b2) = sampled_lag(time1), sampled_lag(time2)
    low, velocity, expected = positions[0], 0.0, []
    for y in positions:
        before, low = low, a1 * low + b1 * y
        velocity = a2 * velocity + b2 * (low - before) / TS
        expected.append(velocity)
    assert observe(positions, time1, time2) == pytest.approx(np.array(expected), rel=1e-9, abs=1e-13)


def test_observer_reads_a_sinusoid_as_its_continuous_filter_does() -> None:
    """s / ((T1 s + 1)(T2 s + 1)) at the experiments' frequency; sampling shifts it by part of a sample."""
    omega, t = 1.5 * math.pi, TS * np.arange(2000)
    filtered = 1j * omega / (1 + 1e-3j * omega)**2 * np.exp(1j * omega * t)
    difference = observe(np.sin(omega * t)) - filtered.imag
    assert np.abs(difference[100:]).max() < omega * omega * 0.5 * TS


@pytest.mark.parametrize("angle", [0.0, 1e-6, 1e-3, 0.01, 0.1, 0.49, 0.51, 1.0, 2.0, 3.0])
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


# The function changes from its series to the formula at 0.5.
@given(st.floats(1e-8, 3.1))
@example(math.nextafter(0.5, 0.0))
@example(0.5)
@example(math.nextafter(0.5, 1.0))
def test_integral_of_sine(x: float) -> None:
    with mpmath.workdps(60):
        exact = (mpmath.mpf(x) - mpmath.sin(mpmath.mpf(x))) / mpmath.mpf(x)**3
    assert integral_of_sine(x) == pytest.approx(float(exact), rel=1e-14)


def test_integral_of_sine_at_zero() -> None:
    assert integral_of_sine(0.0) == 1.0 / 6.0


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize(("omega", "sample_time"),
                         [(1.5 * math.pi, 0.2e-3), (1.5 * math.pi, 0.5e-3), (1000.0, 1e-3)])
def test_internal_model_is_marginally_stable(omega: float, sample_time: float) -> None:
    """Without input the oscillation keeps its amplitude over 1e6 samples, and ξ1 does not drift."""
    oscillator, model = OscillatorStep(), InternalModel()
    oscillator.prepare(omega, sample_time)
    model.xi2, model.xi3 = 1e-3, 2e-3
    # ξ1 + ξ3/ω² and the amplitude are constants of ξ' = φ ξ.
    amplitudes, centres = [], []
    for _ in range(101):
        amplitudes.append((omega * model.xi2)**2 + model.xi3**2)
        centres.append(model.xi1 + model.xi3 / omega**2)
        for _ in range(10_000):
            model.update(0.0, oscillator, 0.0, 0.0, 0.0)
    assert amplitudes == pytest.approx([amplitudes[0]] * 101, rel=1e-9)
    swing = math.sqrt(amplitudes[0]) / omega**2
    assert centres == pytest.approx([centres[0]] * 101, abs=1e-8 * swing)


@given(st.floats(1e-3, 10.0), st.floats(0.1, 50.0), st.floats(-100.0, 100.0))
@example(1.0, 2.0, 1.0)   # a double root is still one
def test_smaller_root(a: float, b: float, c: float) -> None:
    root, real = smaller_root(a, b, c)
    if b * b < 4.0 * a * c:
        assert not real
        assert root == b / (2.0 * a)
        return
    assert real
    assert a * root**2 - b * root + c == pytest.approx(0.0, abs=1e-10 * (b * b / a + abs(c)))
    assert root <= b / (2.0 * a)
    # numpy's own roots of a nearly double one are good to the square root of the rounding only
    assert root == pytest.approx(np.roots([a, -b, c]).real.min(), abs=1e-6 * b / a)


@given(st.floats(-10.0, 10.0), st.floats(-10.0, 10.0), st.floats(-0.06, 0.06), st.floats(0.0, 8.0))
def test_motor_command(i_d: float, i_q: float, displacement: float, limit: float) -> None:
    motor = MotorCommand()
    motor.command(i_d, i_q, limit, MOTOR.electrical_angle(displacement))
    bound = limit if limit > 0.0 else math.inf
    assert (motor.i_d_cmd, motor.i_q_cmd) == (min(max(i_d, -bound), bound), min(max(i_q, -bound), bound))
    assert motor.limited == (abs(i_d) > bound or abs(i_q) > bound)
    assert (motor.excess_d, motor.excess_q) == (motor.i_d_cmd - i_d, motor.i_q_cmd - i_q)
    angle = sine_cosine(MOTOR.electrical_angle(displacement))
    made = park(*clarke(motor.i_a_cmd, motor.i_b_cmd, motor.i_c_cmd), *angle)
    assert made == pytest.approx((motor.i_d_cmd, motor.i_q_cmd), abs=1e-13)
    motor.release()
    assert motor.i_a_cmd == motor.i_b_cmd == motor.i_c_cmd == motor.i_d_cmd == motor.i_q_cmd == 0.0


@pytest.mark.parametrize(("error", "trip", "expected"), [(1e-3, 0.0, False), (1e-3, 1e-3, False), (1.1e-3, 1e-3, True),
                                                         (-1.1e-3, 1e-3, True), (-1e-4, 1e-3, False)])
def test_trip_threshold(error: float, trip: float, expected: bool) -> None:
    assert exceeds(error, trip) is expected


@pytest.mark.usefixtures("slow")
@settings(max_examples=10, deadline=None)
@given(st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_clock_samples_every_nth_step_whatever_the_rounding(count: int, seed: int) -> None:
    """Over 1e5 steps, each with its own rounding."""
    noise = np.random.default_rng(seed).uniform(-1e-13, 1e-13, 100_000)
    clock, dts = SampleClock(), (TS / count * (1.0 + noise)).tolist()
    assert all(clock.fits(dt, TS) and clock.due(dt, TS) == (k % count == 0) for k, dt in enumerate(dts))


def test_clock_takes_steps_that_are_differences_of_late_times() -> None:
    """An importer may pass t_next − t_now, which at 1e4 s is rounded to 1e-12 s."""
    clock, dts = SampleClock(), np.diff(1e4 + TS / 5 * np.arange(20_001)).tolist()
    assert max(dts) - min(dts) > 1e-12
    assert all(clock.fits(dt, TS) and clock.due(dt, TS) == (k % 5 == 0) for k, dt in enumerate(dts))


@pytest.mark.parametrize("dt", [2 * TS, 0.9 * TS, 0.4 * TS, 1.001 * TS, TS / 2.5])
def test_clock_refuses_other_steps(dt: float) -> None:
    assert not SampleClock().fits(dt, TS)


def test_clock_refuses_to_step_over_a_sample() -> None:
    """After a short step a long one would move every sample off the grid; two short ones and a long one fit."""
    clock = SampleClock()
    assert clock.fits(TS / 2, TS)
    clock.due(TS / 2, TS)
    assert not clock.fits(TS, TS)
    assert clock.fits(TS / 2, TS)
    clock.due(TS / 2, TS)
    assert clock.fits(TS, TS)
    assert clock.due(TS, TS)
