"""Phase currents and direct and quadrature current, (2.1), at the electrical angle of `MotorGeometry` (4.4)."""

from math import cos, pi, sin, sqrt

THIRD_OF_TURN = 2.0 * pi / 3.0
SQRT3 = sqrt(3.0)


def clarke(i_a: float, i_b: float, i_c: float) -> tuple[float, float]:
    """Stator-frame components (A) of three phase currents (A), amplitude invariant.

    A current common to the three phases makes no force and drops out. (2.1) is this, then `park`.
    """
    return (2.0 * i_a - i_b - i_c) / 3.0, (i_b - i_c) / SQRT3


def park(i_alpha: float, i_beta: float, theta: float) -> tuple[float, float]:
    """Direct and quadrature current i_d, i_q (A) of the stator-frame components (A) at an angle θ (rad)."""
    c = cos(theta)
    s = sin(theta)
    return c * i_alpha + s * i_beta, c * i_beta - s * i_alpha


def phase_currents(i_d: float, i_q: float, theta: float) -> tuple[float, float, float]:
    """Phase currents i_a, i_b, i_c (A) that make i_d, i_q (A) at an angle θ (rad), equation (C.1)."""
    theta_b = theta - THIRD_OF_TURN
    theta_c = theta + THIRD_OF_TURN
    return (cos(theta) * i_d - sin(theta) * i_q,
            cos(theta_b) * i_d - sin(theta_b) * i_q,
            cos(theta_c) * i_d - sin(theta_c) * i_q)
