"""Elementary functions against mpmath, in units of the last place, and at the edges of their ranges."""

import math
from collections.abc import Callable
from typing import NamedTuple

import mpmath
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from maglev.own_fmus import DEFINITIONS, definition
from pmlsm.elementary.arctangent import arctangent, arctangent_integral
from pmlsm.elementary.exponential import LARGEST_EXPONENT, exponential, exponential_minus_one
from pmlsm.elementary.logarithm import logarithm, logarithm_one_plus
from pmlsm.elementary.sine_cosine import LARGEST_REDUCED, sine_cosine, sine_of_turns
from pmlsm.elementary.whole_numbers import fraction, rounded_down

TINIEST = 5e-324
Exact = Callable[[mpmath.mpf], mpmath.mpf]


def ulps(found: float, exact: mpmath.mpf) -> float:
    """Distance of a number from an exact one, in units of the exact one's last place."""
    return float(abs(mpmath.mpf(found) - exact) / mpmath.mpf(math.ulp(float(exact))))


class Case(NamedTuple):
    """A function, the exact one, its range, and the largest error that its module states, ULP."""

    function: Callable[[float], float]
    exact: Exact
    low: float
    high: float
    error: float


def sine(x: float) -> float:
    return sine_cosine(x)[0]


def cosine(x: float) -> float:
    return sine_cosine(x)[1]


def integral(x: mpmath.mpf) -> mpmath.mpf:
    return x * mpmath.atan(x) - mpmath.log1p(x * x) / 2


CASES = {
    "sine": Case(sine, mpmath.sin, -1.6, 1.6, 0.8), "cosine": Case(cosine, mpmath.cos, -1.6, 1.6, 0.8),
    "sine, wide": Case(sine, mpmath.sin, -LARGEST_REDUCED, LARGEST_REDUCED, 0.8),
    "cosine, wide": Case(cosine, mpmath.cos, -LARGEST_REDUCED, LARGEST_REDUCED, 0.8),
    "sine of turns": Case(sine_of_turns, lambda x: mpmath.sinpi(2 * x), -1e6, 1e6, 1.8),
    "exponential": Case(exponential, mpmath.exp, -1.0, 1.0, 0.77),
    "exponential, wide": Case(exponential, mpmath.exp, -745.1, LARGEST_EXPONENT, 0.77),
    "less one": Case(exponential_minus_one, mpmath.expm1, -1.0, 1.0, 0.9),
    "less one, wide": Case(exponential_minus_one, mpmath.expm1, -40.0, LARGEST_EXPONENT, 0.9),
    "logarithm": Case(logarithm, mpmath.log, 0.4, 3.0, 0.8),
    "logarithm, wide": Case(logarithm, mpmath.log, TINIEST, 1.7e308, 0.8),
    "one plus": Case(logarithm_one_plus, mpmath.log1p, -0.9, 3.0, 0.8),
    "one plus, wide": Case(logarithm_one_plus, mpmath.log1p, -1.0 + 1e-15, 1.7e308, 0.8),
    "arctangent": Case(arctangent, mpmath.atan, -3.0, 3.0, 0.85),
    "arctangent, wide": Case(arctangent, mpmath.atan, -1.7e308, 1.7e308, 0.85),
    "its integral": Case(arctangent_integral, integral, -500.0, 500.0, 4.0)}


@pytest.mark.parametrize("name", CASES)
@settings(max_examples=1500)
@given(data=st.data())
def test_error(name: str, data: st.DataObject) -> None:
    case = CASES[name]
    x = data.draw(st.floats(case.low, case.high))
    with mpmath.workdps(400 if "wide" in name else 60):
        exact = case.exact(mpmath.mpf(x))
        if exact == 0:
            assert case.function(x) == 0.0
        else:
            assert ulps(case.function(x), exact) <= case.error


@settings(max_examples=2000)
@given(quarters=st.integers(-530_000_000, 530_000_000), away=st.integers(-3, 3))
@example(quarters=1, away=0)
@example(quarters=2, away=0)
def test_next_to_a_multiple_of_a_quarter_turn(quarters: int, away: int) -> None:
    """Where a sine or a cosine is nearly 0, all of its digits come from those of π/2."""
    with mpmath.workdps(60):
        x = float(quarters * mpmath.pi / 2)
        for _ in range(abs(away)):
            x = math.nextafter(x, math.copysign(math.inf, away))
        for found, exact in zip(sine_cosine(x), (mpmath.sin(mpmath.mpf(x)), mpmath.cos(mpmath.mpf(x))), strict=True):
            assert found == exact == 0 or ulps(found, exact) <= 0.8


def test_no_permitted_displacement_is_out_of_reach() -> None:
    """The largest length of any FMU over the least pole pitch is far within what a sine takes."""
    lengths = {variable.name: variable for name in DEFINITIONS for variable in definition(name).variables
               if variable.unit == "m"}
    longest = max(abs(float(end)) for variable in lengths.values() for end in (variable.minimum, variable.maximum)
                  if end is not None)
    shortest = lengths["geometry.pole_pitch"].minimum
    assert shortest is not None
    assert 1e3 < math.pi / shortest * 2.0 * longest < 1e-3 * LARGEST_REDUCED


@pytest.mark.parametrize("function", [sine, exponential_minus_one, logarithm_one_plus, arctangent])
@pytest.mark.parametrize("x", [0.0, -0.0, TINIEST, -TINIEST, 1e-310, 2.3e-308, -1e-20])
def test_where_they_are_their_argument(function: Callable[[float], float], x: float) -> None:
    found = function(x)
    assert found == x and math.copysign(1.0, found) == math.copysign(1.0, x)


@pytest.mark.parametrize(("found", "expected"), [
    (cosine(0.0), 1.0), (exponential(0.0), 1.0), (logarithm(1.0), 0.0), (exponential(-math.inf), 0.0),
    (exponential(math.inf), math.inf), (exponential(709.79), math.inf), (exponential(-746.0), 0.0),
    (exponential_minus_one(-math.inf), -1.0), (exponential_minus_one(math.inf), math.inf),
    (exponential_minus_one(-50.0), -1.0), (logarithm(0.0), -math.inf), (logarithm(math.inf), math.inf),
    (logarithm_one_plus(-1.0), -math.inf), (logarithm_one_plus(math.inf), math.inf),
    (arctangent(math.inf), math.pi / 2), (arctangent(-math.inf), -math.pi / 2), (arctangent_integral(0.0), 0.0)])
def test_edges(found: float, expected: float) -> None:
    assert found == expected


@pytest.mark.parametrize("found", [
    *sine_cosine(math.nan), *sine_cosine(math.inf), *sine_cosine(-math.inf), *sine_cosine(1e9), *sine_cosine(-1e300),
    sine_of_turns(math.nan), sine_of_turns(math.inf), exponential(math.nan), exponential_minus_one(math.nan),
    logarithm(math.nan), logarithm(-1.0), logarithm(-math.inf), logarithm_one_plus(math.nan), logarithm_one_plus(-1.5),
    arctangent(math.nan)])
def test_no_number(found: float) -> None:
    """What is not right is NaN, which a block's checks see, and never a plausible number."""
    assert math.isnan(found)


@pytest.mark.parametrize(("function", "low", "high", "fall"), [
    (exponential, -40.0, 40.0, 0.0), (exponential_minus_one, -2.0, 3.0, 0.0), (logarithm, 1e-3, 1e3, 0.0),
    (logarithm_one_plus, -0.9, 3.0, 0.0), (arctangent, -4.0, 4.0, 0.0), (sine, -1.5, 1.5, 0.0),
    (arctangent_integral, 0.0, 40.0, 4.0)])
@settings(max_examples=1500)
@given(data=st.data())
def test_monotone(function: Callable[[float], float], low: float, high: float, fall: float,
                  data: st.DataObject) -> None:
    """From one number to the next, also across the borders between two ways to compute a value.

    The integral alone may fall, by as many units of the last place as it is in error.
    """
    x = data.draw(st.floats(low, high))
    here = function(x)
    for beyond in (math.nextafter(x, math.inf), x + 64.0 * math.ulp(x)):
        assert function(beyond) >= here - fall * math.ulp(here)


@given(st.one_of(st.floats(), st.integers(-2**55, 2**55).map(lambda k: k / 2)))
def test_rounded_down(x: float) -> None:
    found = rounded_down(x)
    assert math.isnan(found) if math.isnan(x) else found == x if math.isinf(x) else found == math.floor(x)


@given(st.one_of(st.floats(-1e17, 1e17), st.integers(-2**55, 2**55).map(lambda k: k / 2)))
def test_fraction(x: float) -> None:
    """Exactly what is left beside the nearest whole number."""
    found = fraction(x)
    assert -0.5 <= found <= 0.5 and (x - found).is_integer()
