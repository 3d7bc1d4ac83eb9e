"""What is searched: poles become gains, and gains place poles."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from maglev.linear.design import gains_of, regulator_polynomial
from maglev.many.tuning_plan import Unknowns, placed_gains, read_tuning
from maglev.many.tuning_search import row

OMEGA0 = 1.5 * np.pi
TABLE = {"name": "tuning", "scenario": "tiny.toml", "minimise": ["overshoot"]}


@given(st.lists(st.floats(0.1, 100.0), min_size=5, max_size=5), st.floats(0.1, 20.0))
def test_gains_place_the_poles(rates: list[float], omega0: float) -> None:
    polynomial = np.poly([-rate for rate in rates])
    found = regulator_polynomial(gains_of(polynomial.tolist(), omega0), omega0)
    # Differences of large numbers: an error is one of the largest of them.
    assert found == pytest.approx(polynomial, rel=1e-9, abs=1e-12 * (1.0 + omega0 ** 4) * float(polynomial.max()))


def test_the_published_gains_come_of_their_poles() -> None:
    """(5.14): -5, -6, -7, -8, -9 are a real pole and the pairs of -6, -7 and of -8, -9."""
    numbers = (5.0, np.sqrt(42.0), 13.0 / (2.0 * np.sqrt(42.0)), np.sqrt(72.0), 17.0 / (2.0 * np.sqrt(72.0)))
    assert placed_gains(numbers, OMEGA0) == pytest.approx([-463.0, -35.0, -15121.0, -997.0, -2548.0], rel=1e-3)


def test_every_parameter_gets_its_number() -> None:
    tuning = read_tuning({**TABLE, "search": [{"set": ["plant.v.mass", "plant.h.mass"], "low": "1 kg", "high": "2 kg"}],
                          "poles": [{"of": ["controller.h", "controller.v"], "rate": {"low": 2, "high": 9},
                                     "damping": {"low": 0.5, "high": 1}}]}, Path("tuning.toml"))
    unknowns = Unknowns(tuning, {"controller": OMEGA0})
    assert unknowns.bounds == [(2, 9), (2, 9), (0.5, 1), (2, 9), (0.5, 1), (1, 2)]
    assert unknowns.names == [*(f"controller.{axis}.k{i}" for axis in "hv" for i in range(1, 6)), "plant.v.mass",
                              "plant.h.mass"]
    found = unknowns.parameters(np.array([3.0, 4.0, 0.6, 5.0, 0.8, 1.23456789]))
    assert found[10:].tolist() == [1.2346, 1.2346]
    assert found[:5].tolist() == found[5:10].tolist()
    real = -regulator_polynomial(found[:5].tolist(), OMEGA0)[1]
    assert real == pytest.approx(-(3.0 + 2 * 0.6 * 4.0 + 2 * 0.8 * 5.0), rel=1e-4)   # the sum of the poles


def test_where_nothing_settles_the_largest_is_not_0() -> None:
    never, seldom = np.full(3, np.inf), np.array([1.0, np.inf, np.inf])
    assert row("settling time to 10 µm of h", never, seldom, "s")[1:5] == [*["not settled"] * 3, "1 s"]
