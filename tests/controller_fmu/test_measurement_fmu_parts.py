"""What goes wrong with an encoder, one thing at a time, against what it should be by its definition."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from scipy.stats import binom, kstest

from controller_fmu.measurement import Measurement
from maglev.descriptions.packaged import PACKAGED_STAGES

T = 5e-4   # s, sample time of the stage
BLOCK = partial(Measurement, PACKAGED_STAGES["2dof"])   # all stages have the same parts
GAP, ALONG = 0, 1   # numbers of its encoders


def measured(block: Measurement, position: Callable[[float], float], samples: int, parts: int = 1) -> np.ndarray:
    """Measured gap (m) at each sample of a moving gap, shape (samples,), stepped in parts of a sample."""
    assert block.start() == 0
    found = []
    for k in range(samples * parts):
        block.encoders[GAP].encoder = position(k * T / parts)
        assert block.step(k * T / parts, T / parts) == 0
        if k % parts == 0:
            found.append(block.encoders[GAP].measured)
        assert block.encoders[GAP].measured == found[-1], "held between samples"
    return np.array(found)


def wave(t: float, omega: float = 80.0) -> float:
    """A gap that swings, m."""
    return 0.02 + 1e-3 * math.sin(omega * t)


def ramp(t: float) -> float:
    """A gap that grows by 10 mm/s, m."""
    return 0.02 + 0.01 * t


def test_nothing_is_exact() -> None:
    """Whatever the seed is, and however long a sample is divided."""
    block = BLOCK()
    block.seed = 7.0
    assert measured(block, wave, 200, parts=4).tolist() == [wave(4 * k * T / 4) for k in range(200)]
    block.encoders[ALONG].encoder = -0.0
    block.step(200 * T, T)
    assert math.copysign(1.0, block.encoders[ALONG].measured) == -1.0


@pytest.mark.parametrize("delay", [1 * T, 3 * T, 126 * T, 2.25 * T, 0.5 * T])
def test_delay_is_a_phase(delay: float) -> None:
    """A whole number of samples exactly; a fraction with the gain of a straight line between samples, 1 − (ωT)²/8."""
    block, omega, start = BLOCK(), 80.0, 200
    block.instant.delay = delay
    found = measured(block, wave, 2000)[start:] - 0.02
    if (delay / T).is_integer():
        late = round(delay / T)
        assert found.tolist() == [wave((start + k - late) * T) - 0.02 for k in range(len(found))]
    times = T * np.arange(start, 2000)
    basis = np.column_stack([np.sin(omega * times), np.cos(omega * times)])
    (in_phase, quadrature), *_ = np.linalg.lstsq(basis, found, rcond=None)
    assert math.isclose(math.remainder(-math.atan2(quadrature, in_phase) - omega * delay, 2 * math.pi) / omega, 0.0,
                        abs_tol=1e-3 * T)
    assert math.isclose(math.hypot(in_phase, quadrature), 1e-3, rel_tol=(omega * T) ** 2 / 8 + 1e-9)


def test_before_the_first_sample_it_was_at_rest() -> None:
    block = BLOCK()
    block.instant.delay = 10 * T
    assert measured(block, ramp, 12).tolist() == [ramp(0.0)] * 10 + [ramp(0.0), ramp(T)]


def test_jitter_is_spread_evenly_over_its_range() -> None:
    """Of a ramp an age is a distance: none is outside, and all are as likely; one instant for all encoders."""
    block, delay, jitter = BLOCK(), 2.3 * T, 4.1 * T
    block.instant.delay, block.instant.jitter, block.seed = delay, jitter, 3.0
    assert block.start() == 0
    ages, others = [], []
    for k in range(3000):
        block.encoders[GAP].encoder = ramp(k * T)
        block.encoders[ALONG].encoder = ramp(k * T)
        block.step(k * T, T)
        ages.append(k * T - (block.encoders[GAP].measured - 0.02) / 0.01)
        others.append(k * T - (block.encoders[ALONG].measured - 0.02) / 0.01)
    shares = (np.array(ages[100:]) - delay) / jitter
    assert kstest(shares, "uniform").pvalue > 1e-4
    assert abs(np.corrcoef(shares[1:], shares[:-1])[0, 1]) < 4 / math.sqrt(len(shares))
    assert ages == others


def test_offset_drift_and_jump() -> None:
    block = BLOCK()
    block.encoders[GAP].offset, block.encoders[GAP].drift = 3e-5, 2e-4
    found = measured(block, lambda t: 0.02, 1001)
    assert np.allclose(found - 0.02, 3e-5 + 2e-4 * T * np.arange(1001), rtol=0, atol=1e-15)
    block.encoders[GAP].offset, block.encoders[GAP].drift = 5e-5, 0.0
    block.step(1001 * T, T)
    jump = block.encoders[GAP].measured - found[-1]
    assert math.isclose(jump, 2e-5 + 2e-4 * T, rel_tol=1e-9), "the drift stays where it was"


def test_interpolation_error_is_a_line_over_the_way() -> None:
    """Over 25 periods of 40 µm: one line in the spectrum over the position, with the phase of a sine."""
    block, period, amplitude = BLOCK(), 4e-5, 3e-6
    block.encoders[GAP].interpolation.amplitude, block.encoders[GAP].interpolation.period = amplitude, period
    way = 0.02 + period / 40 * np.arange(1000)
    found = measured(block, lambda t: float(way[round(t / T)]), 1000) - way
    spectrum = np.fft.rfft(found) / 500
    assert np.isclose(spectrum[25], -1j * amplitude * np.exp(2j * math.pi * 0.02 / period), rtol=1e-6)
    assert np.abs(np.delete(spectrum, 25)).max() < 1e-9 * amplitude


def test_a_lost_sample_leaves_the_one_before() -> None:
    block = BLOCK()
    block.encoders[GAP].lost = 0.3
    found = measured(block, ramp, 4000)
    fresh = found == np.array([ramp(k * T) for k in range(4000)])
    low, high = (binom.ppf(share, 4000, 0.3) for share in (5e-5, 1 - 5e-5))
    assert low <= np.count_nonzero(~fresh) <= high
    assert (found[1:][~fresh[1:]] == found[:-1][~fresh[1:]]).all()
    runs = np.diff(np.flatnonzero(fresh)) - 1   # of lost samples: geometric
    assert abs(np.mean(runs) - 0.3 / 0.7) < 0.05 and abs(np.mean(runs == 0) - 0.7) < 0.03


def test_frozen_and_lost_for_good() -> None:
    block = BLOCK()
    assert measured(block, ramp, 10)[-1] == ramp(9 * T)
    block.encoders[GAP].frozen = True
    block.encoders[GAP].offset = 1e-3
    block.encoders[GAP].encoder = 0.03
    block.step(10 * T, T)
    assert block.encoders[GAP].measured == ramp(9 * T) and block.encoders[ALONG].measured == 0.0
    block.encoders[GAP].frozen = False
    block.step(11 * T, T)
    assert block.encoders[GAP].measured == 0.03 + 1e-3
    block.encoders[GAP].lost = 1.0
    block.encoders[GAP].encoder = 0.01
    for k in range(12, 40):
        block.step(k * T, T)
    assert block.encoders[GAP].measured == 0.03 + 1e-3


def test_noise_does_not_depend_on_lost_samples() -> None:
    one, other = BLOCK(), BLOCK()
    for block in (one, other):
        block.encoders[GAP].noise, block.seed = 1e-6, 5.0
    other.encoders[GAP].lost, other.instant.jitter = 0.2, T
    first, second = (measured(block, lambda t: 0.02, 300) for block in (one, other))
    assert np.mean(first == second) > 0.7


def test_refusals() -> None:
    block = BLOCK()
    assert block.step(0.0, 0.7 * T) == 1
    block.instant.delay, block.instant.jitter = 100 * T, 27 * T
    assert block.start() == 2
    block.instant.jitter, block.seed = 0.0, 0.5
    assert block.start() == 3


def test_a_gap_that_is_not_exchanged_yet_is_handed_on() -> None:
    block = BLOCK()
    block.encoders[GAP].noise, block.instant.delay = 1e-6, T
    assert block.start() == 0
    block.encoders[GAP].encoder = 0.0
    block.step(0.0, T)
    assert block.encoders[GAP].measured == 0.0 and block.number == 0
    block.encoders[GAP].encoder = 0.02
    block.step(T, T)
    assert 0.0 < abs(block.encoders[GAP].measured - 0.02) < 1e-5, "at rest where it begins"
