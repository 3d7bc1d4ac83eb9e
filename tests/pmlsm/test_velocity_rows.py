"""The velocity rows against the page, and one for all who use them."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference_stage import G, shape_functions

from pmlsm.velocity_rows import normal_acceleration, normal_terms, thrust_term

gaps = st.floats(9e-3, 32e-3)
currents = st.floats(-5.0, 5.0)


@given(gaps, currents, currents)
def test_rows_of_4_3(gap: float, i_d: float, i_q: float) -> None:
    f1, f2, f3, f4 = shape_functions(gap)
    squares = i_q**2 + i_d**2
    assert thrust_term(14.2, f1, i_q) == pytest.approx(-14.2 * f1 * i_q, rel=1e-14, abs=0.0)
    assert normal_acceleration(791.0, 30.9, 0.12, f2, f3, f4, i_d, squares) == pytest.approx(
        G - 0.12 * f4 * squares + 30.9 * f3 * i_d - 791.0 * f2, rel=1e-13, abs=1e-13)


@given(gaps, currents, currents, currents, currents)
def test_a_pair_is_two_motors(gap: float, i_da: float, i_qa: float, i_db: float, i_qb: float) -> None:
    """(5.3) by four motors, each with its own attraction, and the current of its pair."""
    _, f2, f3, f4 = shape_functions(gap)
    row = G + sum(0.2 * f3 * i_d - 0.0045 * f4 * (i_q**2 + i_d**2) - 334.52 * f2
                  for i_d, i_q in [(i_da, i_qa)] * 2 + [(i_db, i_qb)] * 2)
    squares = i_qa**2 + i_da**2 + i_qb**2 + i_db**2
    assert normal_acceleration(4 * 334.52, 2 * 0.2, 2 * 0.0045, f2, f3, f4, i_da + i_db, squares) == pytest.approx(
        row, rel=1e-12, abs=1e-12)


def test_terms_take_samples_as_they_take_one() -> None:
    """Identification hands arrays to the same arithmetic."""
    f: Any = np.array([shape_functions(gap) for gap in (12e-3, 20e-3, 28e-3)]).T
    direct: Any
    squares: Any
    direct, squares = np.array([-1.0, 0.5, 2.0]), np.array([1.0, 3.0, 4.0])
    together: Any = normal_terms(4.0, 2.0, 2.0, f[1], f[2], f[3], direct, squares)
    for k in range(3):
        f2, f3, f4, i_d, square = (float(each[k]) for each in (f[1], f[2], f[3], direct, squares))
        one = normal_terms(4.0, 2.0, 2.0, f2, f3, f4, i_d, square)
        assert [float(term[k]) for term in together] == list(one)
