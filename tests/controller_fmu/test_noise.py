"""Random numbers of the measurement: published answers, and what white normal noise has to show."""

import numpy as np
import pytest
from scipy.stats import chi2, kstest, norm

from controller_fmu.measured_position import MeasuredPosition
from controller_fmu.sampling_instant import SamplingInstant
from pmlsm.normal_variate import normal_variate
from pmlsm.random_words import random_words

SAMPLES = 8192
SIGMA = 2e-6   # m
RARE = 1e-4    # of what is true: the numbers are always the same, and a wrong one fails by far


@pytest.mark.parametrize(("seed", "stream", "number", "words"), [
    (0, 0, 0, (0xFF1DAE59, 0x6CD10DF2)), (0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF, (0x2C3F628B, 0xAB4FD7AD)),
    (0x13198A2E, 0x85A308D3, 0x243F6A88, (0xDD7CE038, 0xF62A4C12))])
def test_words_are_the_published_ones(seed: int, stream: int, number: int, words: tuple[int, int]) -> None:
    """`kat_vectors` of Random123, the reference implementation of Philox."""
    assert random_words(seed, stream, number) == words
    assert random_words(seed, stream, number + 2**32) == words, "samples are counted with 32 bits"


def test_normal_variate_is_the_quantile() -> None:
    """By scipy, over all words and close to both ends; no integer on the way is beyond what C holds."""
    words = np.unique(np.concatenate([np.linspace(0, 2**32 - 1, 2001).astype(np.int64), 2 ** np.arange(32)]))
    words = np.unique(np.concatenate([words, 2**32 - 1 - words]))
    found = np.array([normal_variate(word) for word in words.tolist()])
    assert np.allclose(found, norm.ppf((words + 0.5) / 2**32), rtol=3e-7, atol=0)
    assert np.array_equal(found, -found[::-1]) and (np.diff(found) > 0).all()
    assert (2**32 - 1) * 0xD256 + 2**32 < 2**53


def noise(stream: int, seed: int) -> np.ndarray:
    """Noise of an encoder that rests at 20 mm, shape (SAMPLES,)."""
    position, instant = MeasuredPosition(0.02, stream), SamplingInstant()
    position.noise = SIGMA
    found = []
    for k in range(SAMPLES):
        position.sample(instant, seed, k, 1e-3)
        found.append(position.measured - 0.02)
    return np.array(found)


@pytest.fixture(scope="module")
def channels() -> np.ndarray:
    """Noise by encoder and seed, shape (4, SAMPLES)."""
    return np.array([noise(1, 0), noise(2, 0), noise(1, 1), noise(2, 12345)])


def test_noise_is_normal_with_its_variance(channels: np.ndarray) -> None:
    for values in channels:
        assert kstest(values / SIGMA, "norm").pvalue > RARE
        low, high = (chi2.ppf(share, SAMPLES - 1) / (SAMPLES - 1) for share in (RARE / 2, 1 - RARE / 2))
        assert low < np.var(values, ddof=1) / SIGMA**2 < high


def test_noise_is_white(channels: np.ndarray) -> None:
    """No line in the spectrum, no slope in it, no correlation with what came before."""
    for values in channels / SIGMA:
        power = np.abs(np.fft.rfft(values)[1:-1]) ** 2 / SAMPLES   # each exponential with mean 1
        assert kstest(power, "expon").pvalue > RARE
        assert power.max() < -np.log(RARE / len(power))
        low, high = power[:len(power) // 2].mean(), power[len(power) // 2:].mean()
        assert abs(low - high) < 4 * np.sqrt(4 / len(power))
        for lag in (1, 2, 3, 10, 1000):
            assert abs(np.mean(values[lag:] * values[:-lag])) < 4 / np.sqrt(SAMPLES - lag), lag


def test_encoders_and_seeds_are_independent(channels: np.ndarray) -> None:
    correlations = np.corrcoef(channels)
    assert np.abs(correlations - np.eye(len(channels))).max() < 4 / np.sqrt(SAMPLES)
    cross = np.fft.irfft(np.fft.rfft(channels[0]) * np.conj(np.fft.rfft(channels[1]))) / SAMPLES / SIGMA**2
    assert np.abs(cross).max() < 5.5 / np.sqrt(SAMPLES), "not shifted against each other either"
