import gzip
import json

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from packed_series import decode, unpack

from maglev.pages.panels import PANELS
from maglev.pages.series import FIRST_ROWS, LARGEST_COUNT, QUANTA, encode, pack, thin

INTERVAL = 1e-3   # s


def signal(seed, length, smooth, size):
    noise = np.random.default_rng(seed).standard_normal(length)
    return size * (np.cumsum(noise) if smooth else noise)


signals = st.builds(
    signal, st.integers(0, 2**32), st.integers(1, 3000), st.booleans(), st.sampled_from([0.0, 1e-6, 1e-3, 1.0, 1e6]))
tolerances = st.sampled_from([0.2e-6, 1e-3, 10e-3])


def times(values):
    return np.arange(len(values), dtype=float) * INTERVAL


@given(signals, tolerances, st.sampled_from([40, 400, 4000]))
def test_lines_between_kept_rows_are_within_the_tolerance(values, tolerance, most):
    time = times(values)
    rows, within = thin(time, values, tolerance, most)
    lines = np.interp(time, time[rows], values[rows])
    assert np.abs(lines - values).max() <= within
    assert within >= tolerance
    assert len(rows) <= most
    assert (np.diff(rows) > 0).all()
    assert {0, len(values) - 1} <= set(rows)
    assert {values.min(), values.max()} <= set(values[rows])


@given(signals, tolerances, st.sampled_from([40, 4000]))
def test_unpacked_series_equal_the_packed_ones(values, tolerance, most):
    time = times(values)
    packed = json.loads(json.dumps(pack(time, {"a": values, "b": -values}, INTERVAL, {"a": tolerance, "b": 1.0}, most)))
    unpacked = unpack(packed)
    assert list(unpacked) == ["a", "b"]
    signal = packed["signals"]["a"]
    found_time, found = unpacked["a"]
    assert len(found) == signal["rows"]
    beyond = signal["tolerance"] + 0.5 * signal["quantum"]
    rounding = 1e-9 * (1.0 + np.abs(values).max())
    assert np.abs(np.interp(time, found_time, found) - values).max() <= beyond + rounding
    assert signal["quantum"] <= max(signal["tolerance"] / QUANTA, 1e-9 * np.abs(values).max())


def test_a_line_needs_few_rows_and_a_step_keeps_its_edge():
    time = np.arange(60001, dtype=float) * INTERVAL
    assert len(thin(time, 1e-3 * time, 0.2e-6, 4000)[0]) < 50
    step = np.where(time < 30.0, 0.02, 0.03)
    rows = thin(time, step, 0.2e-6, 4000)[0]
    assert {29999, 30000} <= set(rows)
    assert len(rows) < 50


def test_ten_micrometres_are_seen_in_a_step_of_thirty_millimetres():
    time = np.arange(26001, dtype=float) * INTERVAL
    ring = 10e-6 * np.sin(2.0 * np.pi * 5.0 * time)
    position = np.where(time < 1.0, 0.0, 30e-3) + ring
    found_time, found = unpack(pack(time, {"x": position}, INTERVAL, {"x": 0.2e-6}, 16000))["x"]
    assert np.abs(np.interp(time, found_time, found) - position).max() < 0.3e-6


@given(st.lists(st.integers(-LARGEST_COUNT, LARGEST_COUNT)))
@example([-LARGEST_COUNT, LARGEST_COUNT, -LARGEST_COUNT])
def test_integers_are_encoded_exactly(integers):
    assert decode(encode(np.array(integers, dtype=np.int64))).tolist() == integers


def test_times_off_the_interval_are_kept_to_a_microsecond():
    time = np.array([0.0, 0.7e-3, 1.3e-3])
    found, _ = unpack(pack(time, {"x": time}, INTERVAL, {"x": 1e-6}, 100))["x"]
    np.testing.assert_allclose(found, time, atol=0.5e-6)


def test_a_column_that_was_not_recorded_is_left_out():
    assert pack(np.zeros(1), {"x": np.zeros(1)}, INTERVAL, {"x": 1.0, "y": 1.0}, 100)["signals"].keys() == {"x"}


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("interval", [1e-3, 0.2e-3])
def test_sixty_noisy_seconds_stay_within_the_rows(interval):
    time = np.arange(round(60.0 / interval)) * interval
    noise = np.random.default_rng(1).standard_normal(len(time))
    packed = pack(time, {"i": noise}, interval, {"i": 10e-3}, 4000)
    assert packed["signals"]["i"]["rows"] <= 4000
    assert len(packed["data"]) <= 4000 * 8 * 4 / 3 + 100


def test_a_row_of_the_worst_noise_takes_five_bytes():
    """Two for its time, of as many samples as a packaged run has, and three for its value.

    That is one of errors within ±0.2 m, beyond every stop; all other signals have fewer quanta.
    """
    random = np.random.default_rng(2)
    time = np.arange(40_000, dtype=float) * INTERVAL
    values = random.uniform(-1.0, 1.0, len(time))
    rows = np.unique(np.concatenate([np.linspace(0, len(time) - 1, FIRST_ROWS).astype(int),
                                     random.choice(len(time), 1000, replace=False)]))
    counts = np.rint(values[rows] * 0.2 / (PANELS["error"].tolerance / QUANTA)).astype(np.int64)
    packed = gzip.compress(encode(rows.astype(np.int64)) + encode(counts), 9)
    assert 4.0 * len(rows) < len(packed) < 5.02 * len(rows) + 40   # bytes
