"""Gap functions against printed values, the field's closed form, and mpmath."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motor import MOTOR
from scipy.optimize import brentq

from pmlsm.gap_functions import gap_functions
from pmlsm.velocity_rows import GRAVITY


@pytest.mark.parametrize(("gap", "field"), [(10e-3, 0.2333), (20e-3, 0.1102), (30e-3, 0.0498)])
def test_field_values(gap: float, field: float) -> None:
    assert MOTOR.field.value(gap) == pytest.approx(field, abs=5e-5)


def test_field_polynomial_is_the_closed_form() -> None:
    """The polynomial was made from an exponential; it follows it to nanotesla over its range."""
    gaps = np.linspace(8e-3, 40e-3, 201)
    x = (gaps - 20e-3) / 10e-3
    closed = 0.11020958 * np.exp(-0.7723413 * x - 0.0222132 * x**2)
    assert np.abs([MOTOR.field.value(g) for g in gaps] - closed).max() < 1e-8


@pytest.mark.parametrize(("constant", "gap"), [(796.99, 19.45e-3), (4 * 327.50, 22.69e-3)])
def test_gap_without_current(constant: float, gap: float) -> None:
    """Magnets alone carry the mover there: identified constants of Tables 4.3 and 5.3."""
    found = brentq(lambda g: GRAVITY - constant * gap_functions(MOTOR, g)[1], 10e-3, 35e-3)
    assert found == pytest.approx(gap, abs=5e-6)


@given(st.floats(8e-3, 40e-3))
def test_shape_functions_in_high_precision(gap: float) -> None:
    with mpmath.workdps(40):
        g = mpmath.mpf(gap)
        b0, t1, hm, tau = (mpmath.mpf(text) for text in ("0.0127", "0.01905", "0.005", "0.05715"))
        permeance = 1 - b0**2 / (4 * t1 * (g + b0 / 2 + hm / mpmath.mpf("1.05")))
        u = b0 / (2 * g)
        carter = t1 / (t1 - g * 4 / mpmath.pi * (u * mpmath.atan(u) - mpmath.log(mpmath.sqrt(1 + u**2))))
        a = mpmath.pi / tau * (hm + g)
        b = mpmath.mpf(MOTOR.field.value(gap))
        expected = (permeance / (carter * mpmath.sinh(a)), permeance * b**2, permeance * b * mpmath.coth(a) / carter,
                    permeance * mpmath.coth(a)**2 / carter**2)
        for value, exact in zip(gap_functions(MOTOR, gap), expected, strict=True):
            assert value == pytest.approx(float(exact), rel=1e-13)


@given(st.floats(allow_nan=False))
def test_any_gap_is_taken_to_the_range_of_the_field(gap: float) -> None:
    assert 8e-3 <= MOTOR.field.clamp(gap) <= 40e-3
    assert gap_functions(MOTOR, gap) == gap_functions(MOTOR, MOTOR.field.clamp(gap))
    assert all(value > 0 for value in gap_functions(MOTOR, gap))


def test_forces_fall_with_the_gap() -> None:
    table = np.array([gap_functions(MOTOR, g) for g in np.linspace(9e-3, 39e-3, 61)])
    assert (np.diff(table[:, :3], axis=0) < 0).all()
