"""The controllers' motor models, linearised by scipy."""

import numpy as np
from named_controllers import Regulator2DOF, Regulator3DOF
from reference_stage import G, shape_functions
from scipy.differentiate import derivative
from scipy.optimize import brentq

Regulator = Regulator2DOF | Regulator3DOF


def vertical_row(regulator: Regulator, gap: float, i_d: float) -> float:
    """Vertical acceleration (m/s²) by (4.3), (5.3) with the regulator's constants and no thrust."""
    _, f2, f3, f4 = shape_functions(gap)
    r = regulator
    if isinstance(r, Regulator2DOF):
        return float(G - r.C4 * f4 * i_d**2 + r.C3 * f3 * i_d - r.C2 * f2)
    return float(G - 4 * r.C5 * f4 * i_d**2 + 4 * r.C4 * f3 * i_d - 4 * r.C3 * f2)


def thrusts(regulator: Regulator, gap: float) -> list[float]:
    """Horizontal accelerations for one ampere (m/(s² A)), with their signs in the equations of motion."""
    f1 = shape_functions(gap)[0]
    if isinstance(regulator, Regulator2DOF):
        return [-regulator.C1 * f1]
    return [-2 * regulator.C1 * f1, -2 * regulator.C2 * f1]


def linearised(regulator: Regulator, gap: float) -> tuple[float, float]:
    """∂g''/∂g and ∂g''/∂i_d at the equilibrium, by scipy."""
    current = brentq(lambda i: vertical_row(regulator, gap, i), -12.0, 12.0, xtol=1e-14)
    row = np.vectorize(lambda g, i: vertical_row(regulator, g, i))

    def at_current(g: np.ndarray) -> np.ndarray:
        return np.asarray(row(g, current))

    def at_gap(i: np.ndarray) -> np.ndarray:
        return np.asarray(row(gap, i))

    alpha, beta = derivative(at_current, gap, initial_step=1e-3).df, derivative(at_gap, current).df
    return float(alpha), float(beta)
