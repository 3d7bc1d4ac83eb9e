"""Commutation: inverse of itself, the printed matrix, and the tables of Appendix C."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motor import MOTOR

from pmlsm.dq_transform import clarke, park, phase_currents
from pmlsm.sine_cosine import sine_cosine

POLE_PITCH = 57.15e-3   # m, Tables 4.1 and 5.1

amperes = st.floats(-20.0, 20.0)
metres = st.floats(-0.1, 0.1)


def dq(i_a: float, i_b: float, i_c: float, displacement: float) -> tuple[float, float]:
    """Both halves of (2.1)."""
    return park(*clarke(i_a, i_b, i_c), *sine_cosine(MOTOR.electrical_angle(displacement)))


@given(amperes, amperes, metres)
def test_inverse(i_d: float, i_q: float, displacement: float) -> None:
    phases = phase_currents(i_d, i_q, MOTOR.electrical_angle(displacement))
    assert dq(*phases, displacement) == pytest.approx((i_d, i_q), abs=1e-13)


@given(amperes, amperes, amperes, metres)
def test_printed_matrix(i_a: float, i_b: float, i_c: float, displacement: float) -> None:
    """(2.1) with the offset of (4.4)."""
    theta = math.pi / POLE_PITCH * (displacement - POLE_PITCH / 2)
    angles = np.array([theta, theta - 2 * math.pi / 3, theta + 2 * math.pi / 3])
    expected = 2 / 3 * np.array([np.cos(angles), -np.sin(angles)]) @ [i_a, i_b, i_c]
    assert dq(i_a, i_b, i_c, displacement) == pytest.approx(tuple(expected), abs=1e-13)


@given(amperes, amperes, amperes, amperes, metres)
def test_common_current_makes_no_force(i_a: float, i_b: float, i_c: float, common: float, displacement: float) -> None:
    with_common = dq(i_a + common, i_b + common, i_c + common, displacement)
    assert with_common == pytest.approx(dq(i_a, i_b, i_c, displacement), abs=1e-13)


# Orientations of phases u, w, v at displacements 0, τ/3, 2τ/3, τ; "" is no field. Table C.1: a positive current makes
# North in u and v, South in w. The thesis's phases: a = w, b = u, c = v.
TABLE_C2 = [("North", "North", "North"), ("South", "North", "North"), ("South", "South", "North"),
            ("South", "South", "South")]
TABLE_C3 = [("North", "", "South"), ("North", "North", ""), ("", "North", "North"), ("South", "", "North")]


def orientations(i_d: float, i_q: float, displacement: float) -> tuple[str, ...]:
    """Orientation of the phases u, w, v."""
    i_w, i_u, i_v = phase_currents(i_d, i_q, MOTOR.electrical_angle(displacement))
    return tuple("" if abs(i) < 1e-12 else "North" if i > 0 else "South" for i in (i_u, -i_w, i_v))


@pytest.mark.parametrize("row", range(4))
def test_orientations_of_appendix_c(row: int) -> None:
    displacement = row * POLE_PITCH / 3
    assert orientations(0.0, -1.0, displacement) == TABLE_C2[row]
    assert orientations(-1.0, 0.0, displacement) == TABLE_C3[row]


@pytest.mark.parametrize(("row", "i_u", "i_w", "i_v"), [
    (0, 0.5, -1.0, 0.5),
    # Table C.2 prints −I/4 and −I/√2 here and mirrored below: (C.3) itself gives halves, and only they sum to zero.
    (1, -0.5, -0.5, 1.0), (2, -1.0, 0.5, 0.5),
    (3, -0.5, 1.0, -0.5)])
def test_currents_of_table_c2(row: int, i_u: float, i_w: float, i_v: float) -> None:
    """i_q = −1 A."""
    a, b, c = phase_currents(0.0, -1.0, MOTOR.electrical_angle(row * POLE_PITCH / 3))
    assert (b, a, c) == pytest.approx((i_u, i_w, i_v), abs=1e-14)


@pytest.mark.parametrize(("row", "i_u", "i_w", "i_v"), [(0, 1, 0, -1), (1, 1, -1, 0), (2, 0, -1, 1), (3, -1, 0, 1)])
def test_currents_of_table_c3(row: int, i_u: float, i_w: float, i_v: float) -> None:
    """i_d = −1 A; the table is in units of √3/2 A."""
    a, b, c = phase_currents(-1.0, 0.0, MOTOR.electrical_angle(row * POLE_PITCH / 3))
    assert np.array((b, a, c)) / (math.sqrt(3) / 2) == pytest.approx((i_u, i_w, i_v), abs=1e-14)
