"""Signals on many times at once, against their formulas one time at a time: the same bits."""

import math
import operator
from bisect import bisect_right
from collections.abc import Callable, Iterable
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter

from maglev.scenario.signals import TIME_TOLERANCE, Signal
from maglev.scenario.waves import sines_cosines
from pmlsm.sine_cosine import sine_cosine

SIGNAL: TypeAdapter[Any] = TypeAdapter(Signal)
TIMES = st.lists(st.floats(0.0, 30.0), min_size=1, max_size=30)
ROWS = st.lists(st.tuples(st.floats(0.001, 5.0), st.floats(-1.0, 1.0)), min_size=1, max_size=6)


def signal(**table: object) -> Any:
    return SIGNAL.validate_python({"to": "controller.y.reference", **table})


def require_same_bits(found: np.ndarray, formula: Callable[[float], float], times: list[float]) -> None:
    assert found.dtype == np.float64
    assert found.tobytes() == np.array([formula(t) for t in times]).tobytes()


def ascending(rows: list[tuple[float, float]]) -> tuple[list[float], list[float]]:
    times = np.cumsum([gap for gap, _ in rows]).tolist()
    return times, [value for _, value in rows]


@given(TIMES, ROWS)
def test_steps(times: list[float], rows: list[tuple[float, float]]) -> None:
    at, values = ascending(rows)
    times = sorted(times + [t + shift for t in at for shift in (-2e-9, -0.5e-9, 0.0, 1e-9)])
    found = signal(kind="steps", times=at, values=values)

    def value(t: float) -> float:
        return values[max(bisect_right(at, t + TIME_TOLERANCE) - 1, 0)]

    require_same_bits(found.values_at(np.array(times)), value, times)
    require_same_bits(found.rates_at(np.array(times)), lambda _: 0.0, times)


@given(TIMES, st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(0.0, 20.0), st.floats(-7.0, 7.0)), min_size=1,
                       max_size=4), st.floats(-1.0, 1.0), st.floats(0.0, 10.0))
def test_sinusoids(times: list[float], terms: list[tuple[float, float, float]], offset: float, ramp: float) -> None:
    times += [0.0, ramp, math.nextafter(ramp, 0.0), math.nextafter(ramp, 11.0)]
    found = signal(kind="sinusoids", offset=offset, ramp=ramp,
                   terms=[{"amplitude": a, "omega": omega, "phase": phase} for a, omega, phase in terms])

    def value(t: float) -> float:
        return offset + envelope(t) * waves(t)

    def rate(t: float) -> float:
        return envelope_rate(t) * waves(t) + envelope(t) * total(
            a * omega * sine_cosine(omega * t + phase)[1] for a, omega, phase in terms)

    def waves(t: float) -> float:
        return total(a * sine_cosine(omega * t + phase)[0] for a, omega, phase in terms)

    def total(values: Iterable[float]) -> float:
        return reduce(operator.add, values, 0.0)   # `sum` compensates the rounding, since Python 3.12

    def envelope(t: float) -> float:
        return 1.0 if t >= ramp else (t / ramp) * (t / ramp) * (3.0 - 2.0 * (t / ramp))

    def envelope_rate(t: float) -> float:
        return 0.0 if t >= ramp else 6.0 * (t / ramp) * (1.0 - t / ramp) / ramp

    require_same_bits(found.values_at(np.array(times)), value, times)
    require_same_bits(found.rates_at(np.array(times)), rate, times)


@given(TIMES, ROWS)
def test_csv(tmp_path_factory: pytest.TempPathFactory, times: list[float], rows: list[tuple[float, float]]) -> None:
    at, values = ascending(rows)
    times += at
    path: Path = tmp_path_factory.mktemp("csv") / "rows.csv"
    path.write_text("t,y\n" + "".join(f"{t!r},{y!r}\n" for t, y in zip(at, values, strict=True)))
    found = signal(kind="csv", file=str(path), column="y")

    def value(t: float) -> float:
        if t <= at[0]:
            return values[0]
        return values[-1] if t >= at[-1] else values[before(t)] + rate(t) * (t - at[before(t)])

    def rate(t: float) -> float:
        i = before(t)
        return 0.0 if t < at[0] or t >= at[-1] else (values[i + 1] - values[i]) / (at[i + 1] - at[i])

    def before(t: float) -> int:
        return bisect_right(at, t) - 1

    require_same_bits(found.values_at(np.array(times)), value, times)
    require_same_bits(found.rates_at(np.array(times)), rate, times)


def test_constant() -> None:
    found = signal(kind="constant", value="25 mm")
    assert found.values_at(np.zeros(3)).tolist() == [0.025] * 3
    assert found.rates_at(np.zeros(3)).tolist() == [0.0] * 3


@given(st.lists(st.one_of(st.floats(-2000.0, 2000.0), st.floats(-1e9, 1e9), st.floats()), min_size=1, max_size=50))
def test_sines_of_many_angles_are_those_of_the_blocks(angles: list[float]) -> None:
    angles += [0.0, -0.0, math.pi, -math.pi / 2, 1e-300]
    found = np.array(sines_cosines(np.array(angles)))
    expected = np.array([sine_cosine(angle) for angle in angles]).T
    assert np.array_equal(found, expected, equal_nan=True)
    assert np.array_equal(np.signbit(found), np.signbit(expected))
