"""Model for the design of the output regulator's gains: poles of a double integrator with the internal model."""

from collections.abc import Sequence

import numpy as np

from maglev.files.arrays import Array


def regulator_polynomial(gains: Sequence[float], omega0: float) -> Array:
    """Characteristic polynomial of e'' = K [e, ė, ξ1, ξ2, ξ3]ᵀ + ξ1, ξ' = φ ξ + N e (4.15), (4.16), of s⁵ first, (6,).

    s⁵ − k2 s⁴ + (ω0² − k1) s³ − (k2 ω0² + k5) s² − (k1 ω0² + k4) s − (k3 + 1): a feedback-linearised axis without
    sampling, observer and amplifiers. Gains k1…k5 in 1/s², 1/s, 1/s⁵, 1/s⁴, 1/s³; ω0 of the internal model in rad/s.
    """
    k1, k2, k3, k4, k5 = gains
    square = omega0 * omega0
    return np.array([1.0, -k2, square - k1, -(k2 * square + k5), -(k1 * square + k4), -(k3 + 1.0)])


def gains_of(polynomial: Sequence[float], omega0: float) -> tuple[float, float, float, float, float]:
    """Gains k1…k5 that give a loop this characteristic polynomial: the inverse of `regulator_polynomial`."""
    _, a4, a3, a2, a1, a0 = (float(coefficient) for coefficient in polynomial)
    square = omega0 * omega0
    k1, k2 = square - a3, -a4
    return k1, k2, -(a0 + 1.0), -(a1 + k1 * square), -(a2 + k2 * square)
