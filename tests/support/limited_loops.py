"""Limited loops written down by hand, next to those that the tool makes of the stage."""

from math import pi

import numpy as np
from motor import MOTOR
from named_controllers import Regulator3DOF

from maglev.analysis.axis_loop import AxisLoop
from maglev.files.arrays import Array
from pmlsm.gap_functions import gap_functions

THESIS = np.full(3, 1.1e-4)   # Ecx (5.15)
K = (-463.0, -35.0, -15121.0, -997.0, -2548.0)   # Kx (5.14)


def five_states(limit: float = 4.0) -> AxisLoop:
    """The x-axis at 25 mm as the thesis writes it, in continuous time: e'' = −2 C1 f1 sat(i_q), ξ' = φ ξ + N e."""
    thrust = 2.0 * Regulator3DOF().C1 * gap_functions(MOTOR, 0.025)[0]
    demand = np.array([K[0], K[1], K[2] + 1.0, K[3], K[4]])
    a = np.zeros((5, 5))
    a[0, 1], a[2, 3], a[3, 4], a[4, 3], a[4, 0] = 1.0, 1.0, 1.0, -(1.5 * pi)**2, 1.0
    a[1] = demand
    inject = np.zeros((5, 3))
    inject[2:] = np.eye(3)
    return of_one_command("five states", ("e", "rate", "xi1", "xi2", "xi3"), a, np.array([0.0, -thrust, 0.0, 0.0, 0.0]),
                          inject, -demand / thrust, 0.0, limit, THESIS)


def of_one_command(name: str, states: tuple[str, ...], a: Array, b: Array, inject: Array, k: Array, dt: float,
                   limit: float, gains: Array) -> AxisLoop:
    """Loop of x alone, whose first state is the error and whose second one is its rate."""
    at_step, in_motion = np.eye(max(2, len(a)))[:2, :len(a)]
    return AxisLoop(name, "x", "m", ("x",), states, (("i_q",),), a, b[:, None], inject, np.ones(1), k[None], at_step,
                    in_motion, dt, np.array([-limit]), np.array([limit]), gains)


def first_order(pole: float, gain: float, limit: float, sample_time: float = 0.0) -> AxisLoop:
    """x' = pole x + sat(−gain x), or with x[k+1] − x[k] = Ts (…)."""
    return of_one_command("first order", ("x",), np.array([[pole - gain]]), np.array([1.0]), np.zeros((1, 3)),
                          np.array([-gain]), sample_time, limit, np.zeros(3))
