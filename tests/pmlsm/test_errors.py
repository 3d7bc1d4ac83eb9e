"""Elementary functions against mpmath, in units of the last place, and at the edges of their ranges."""

import math
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import mpmath
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from maglev.descriptions.own_fmus import DEFINITIONS, definition
from plant_fmu.axis import LARGEST_POSITION
from pmlsm.arctangent import arctangent, arctangent_integral
from pmlsm.exponential import LARGEST_EXPONENT, exponential, exponential_minus_one
from pmlsm.logarithm import logarithm, logarithm_one_plus
from pmlsm.sine_cosine import LARGEST_REDUCED, sine_cosine, sine_of_turns
from pmlsm.whole_numbers import fraction, rounded_down

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

T = TypeVar("T")
TINIEST = 5e-324
Exact = Callable[[mpmath.mpf], mpmath.mpf]


def ulps(found: float, exact: mpmath.mpf) -> float:
    """Distance of a number from an exact one, in units of the exact one's last place."""
    return float(abs(mpmath.mpf(found) - exact) / mpmath.mpf(math.ulp(float(exact))))


def twenty(numbers: st.SearchStrategy[T]) -> st.SearchStrategy[list[T]]:
    """What one example looks at: Hypothesis takes longer to begin one than to draw so many."""
    return st.lists(numbers, min_size=20, max_size=20)


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


def falling_cosine(x: float) -> float:
    """What rises where a cosine falls."""
    return -cosine(x)


def integral(x: mpmath.mpf) -> mpmath.mpf:
    return x * mpmath.atan(x) - mpmath.log1p(x * x) / 2


CASES = {
    "sine": Case(sine, mpmath.sin, -1.6, 1.6, 0.8), "cosine": Case(cosine, mpmath.cos, -1.6, 1.6, 0.8),
    "sine, wide": Case(sine, mpmath.sin, -LARGEST_REDUCED, LARGEST_REDUCED, 0.8),
    "cosine, wide": Case(cosine, mpmath.cos, -LARGEST_REDUCED, LARGEST_REDUCED, 0.8),
    "sine of turns": Case(sine_of_turns, lambda x: mpmath.sinpi(2 * x), -1.0, 1.0, 2.0),
    "sine of turns, wide": Case(sine_of_turns, lambda x: mpmath.sinpi(2 * x), -1.7e308, 1.7e308, 2.0),
    "exponential": Case(exponential, mpmath.exp, -1.0, 1.0, 0.8),
    "exponential, wide": Case(exponential, mpmath.exp, -745.1, LARGEST_EXPONENT, 0.8),
    "less one": Case(exponential_minus_one, mpmath.expm1, -1.0, 1.0, 0.9),
    "less one, wide": Case(exponential_minus_one, mpmath.expm1, -40.0, LARGEST_EXPONENT, 0.9),
    "logarithm": Case(logarithm, mpmath.log, 0.4, 3.0, 0.9),
    "logarithm, wide": Case(logarithm, mpmath.log, TINIEST, 1.7e308, 0.9),
    "one plus": Case(logarithm_one_plus, mpmath.log1p, -0.9, 3.0, 0.9),
    "one plus, wide": Case(logarithm_one_plus, mpmath.log1p, -1.0 + 1e-15, 1.7e308, 0.9),
    "arctangent": Case(arctangent, mpmath.atan, -3.0, 3.0, 0.85),
    "arctangent, wide": Case(arctangent, mpmath.atan, -1.7e308, 1.7e308, 0.85),
    "its integral": Case(arctangent_integral, integral, -500.0, 500.0, 4.5)}


@pytest.mark.few(6)
@pytest.mark.parametrize("name", CASES)
@settings(max_examples=40)
@given(data=st.data())
def test_error(name: str, data: st.DataObject) -> None:
    case = CASES[name]
    with mpmath.workdps(400 if "wide" in name else 60):
        for x in data.draw(twenty(st.floats(case.low, case.high))):
            exact = case.exact(mpmath.mpf(x))
            if exact == 0:
                assert case.function(x) == 0.0
            else:
                assert ulps(case.function(x), exact) <= case.error, x


@settings(max_examples=35)
@given(twenty(st.tuples(st.integers(-530_000_000, 530_000_000), st.integers(-3, 3))))
@example([(1, 0), (2, 0)])
def test_next_to_a_multiple_of_a_quarter_turn(places: list[tuple[int, int]]) -> None:
    """Where a sine or a cosine is nearly 0, all of its digits come from those of π/2."""
    for quarters, away in places:
        with mpmath.workdps(60):
            x = float(quarters * mpmath.pi / 2)
            for _ in range(abs(away)):
                x = math.nextafter(x, math.copysign(math.inf, away))
            for found, exact in zip(sine_cosine(x), (mpmath.sin(mpmath.mpf(x)), mpmath.cos(mpmath.mpf(x))),
                                    strict=True):
                assert found == exact == 0 or ulps(found, exact) <= 0.8, x


def test_no_motor_is_out_of_reach() -> None:
    """A plant refuses a step that ends beyond `LARGEST_POSITION` (m or rad).

    A motor as far out on its platform as may be said, with the shortest poles, still has an angle of which a sine has
    all digits. Of turns it has them anyway.
    """
    variables = [v for name in DEFINITIONS for v in definition(name).variables if v.unit == "m"]
    pitch = min(v.minimum for v in variables if v.name.endswith("geometry.pole_pitch") and v.minimum is not None)
    length = max(abs(float(end)) for v in variables for end in (v.minimum, v.maximum) if end is not None)
    angle = math.pi / pitch * (LARGEST_POSITION + length * LARGEST_POSITION)
    assert 1e7 < angle < 0.05 * LARGEST_REDUCED


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


# How far a function may fall, in units of its last place, from a number to the next where it rises. Those that are
# within one unit do not; the two others do, where they are flat.
FALLS = {exponential: 0.0, exponential_minus_one: 0.0, logarithm: 0.0, logarithm_one_plus: 0.0, arctangent: 0.0,
         sine: 0.0, falling_cosine: 0.0, sine_of_turns: 2.0, arctangent_integral: 3.0}


def does_not_fall(function: Callable[[float], float], x: float, numbers: int) -> None:
    """From a number on to the next, and so on."""
    here = function(x)
    for _ in range(numbers):
        x = math.nextafter(x, math.inf)
        before, here = here, function(x)
        assert here >= before - FALLS[function] * math.ulp(before), x


@pytest.mark.few(3)
@pytest.mark.parametrize(("function", "low", "high"), [
    (exponential, -700.0, 700.0), (exponential_minus_one, -37.0, 700.0), (logarithm, 1e-300, 1e300),
    (logarithm_one_plus, -0.99, 1e6), (arctangent, -4.0, 4.0), (sine, -1.5, 1.5), (falling_cosine, 0.1, 3.1),
    (sine_of_turns, -0.25, 0.25), (arctangent_integral, 0.0, 500.0)])
@settings(max_examples=60)
@given(data=st.data())
def test_monotone(function: Callable[[float], float], low: float, high: float, data: st.DataObject) -> None:
    for x in data.draw(twenty(st.floats(low, high))):
        does_not_fall(function, x, 8)


LN2 = math.log(2.0)
BORDERS: dict[Callable[[float], float], list[float]] = {
    exponential: [(k + 0.5) * LN2 for k in (-900, -63, -62, -1, 0, 1, 31, 62, 63, 900)],
    exponential_minus_one: [-37.5, -0.41, 0.41, 36.7, *((k + 0.5) * LN2 for k in range(-53, 53, 6))],
    logarithm: [math.sqrt(2.0) * 2.0**k for k in (-33, -32, -2, -1, 0, 1, 31, 32, 64)] + [1.0, 2.0**32, 2.0**-32],
    logarithm_one_plus: [math.sqrt(0.5) - 1.0, 1.0, *(math.sqrt(2.0) * 2.0**k - 1.0 for k in (0, 1, 2, 40))],
    arctangent: [sign * x for x in (2.0**-27, 0.4375, 0.6875, 1.1875, 2.4375) for sign in (-1.0, 1.0)],
    sine: [sign * x + turns * 2.0 * math.pi for x in (0.0, 2.0**-27, 2.0**-20, math.pi / 4.0) for sign in (-1.0, 1.0)
           for turns in (0, 1, 255, 256, 257)],
    falling_cosine: [x + turns * 2.0 * math.pi for x in (math.pi / 4.0, math.pi / 2.0, 0.75 * math.pi)
                     for turns in (0, 1, 255, 256, 257)],
    sine_of_turns: [-0.125, 0.0, 0.125], arctangent_integral: [0.8]}


@pytest.mark.parametrize("function", BORDERS)
def test_monotone_across_borders(function: Callable[[float], float]) -> None:
    """Number by number, where one way to compute a value ends and another begins."""
    for border in BORDERS[function]:
        does_not_fall(function, border - 200.0 * math.ulp(border), 400)


@given(st.one_of(st.floats(), st.integers(-2**55, 2**55).map(lambda k: k / 2)))
def test_rounded_down(x: float) -> None:
    found = rounded_down(x)
    assert math.isnan(found) if math.isnan(x) else found == x if math.isinf(x) else found == math.floor(x)


@given(st.one_of(st.floats(-1e17, 1e17), st.integers(-2**55, 2**55).map(lambda k: k / 2)))
def test_fraction(x: float) -> None:
    """Exactly what is left next to the nearest whole number."""
    found = fraction(x)
    assert -0.5 <= found <= 0.5 and (x - found).is_integer()
