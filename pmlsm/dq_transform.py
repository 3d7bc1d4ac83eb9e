"""Phase currents and direct and quadrature current, (2.1), at the electrical angle of `MotorGeometry` (4.4)."""

from math import sqrt

from pmlsm.sine_cosine import sine_cosine

SQRT3 = sqrt(3.0)


def clarke(i_a: float, i_b: float, i_c: float) -> tuple[float, float]:
    """Stator-frame components (A) of three phase currents (A), amplitude invariant.

    A current common to the three phases makes no force and drops out. (2.1) is this, then `park`.
    """
    return (2.0 * i_a - i_b - i_c) / 3.0, (i_b - i_c) / SQRT3


def park(i_alpha: float, i_beta: float, sine: float, cosine: float) -> tuple[float, float]:
    """Direct and quadrature current i_d, i_q (A) of the stator-frame components (A); of sin θ and cos θ."""
    return cosine * i_alpha + sine * i_beta, cosine * i_beta - sine * i_alpha


def phase_currents(i_d: float, i_q: float, theta: float) -> tuple[float, float, float]:
    """Phase currents i_a, i_b, i_c (A) that make i_d, i_q (A) at an angle θ (rad), equation (C.1).

    Its three pairs of cosine and sine, a third of a turn apart, follow from one: it is `park` and `clarke` backwards.
    """
    s, c = sine_cosine(theta)
    i_alpha = c * i_d - s * i_q
    i_beta = s * i_d + c * i_q
    half = -0.5 * i_alpha
    side = 0.5 * SQRT3 * i_beta
    return i_alpha, half + side, half - side
