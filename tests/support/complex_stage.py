"""The equations of motion of both stages with numpy, for complex numbers: derivatives by complex step.

Exact to rounding. Written from the page with the constants of `reference_stage`; nothing is shared with the blocks.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from reference_stage import B0, FIELD, HM, LAG, MU_REC, T1, TAU, G, ReferenceStage, park_matrix

NOMINAL_MASSES = {2: (4.350, 1.594), 3: (6.9, 10.6, 8.6)}   # kg, Tables 4.1 and 5.1
STEP = 1e-40   # imaginary, so small that its square vanishes


def shape_functions(g: complex) -> tuple[Any, Any, Any, Any]:
    """f1 to f4 at a gap (m) of 8…40 mm."""
    lam = 1 - B0**2 / (4 * T1 * (g + B0 / 2 + HM / MU_REC))
    u = B0 / (2 * g)
    kc = T1 / (T1 - g * 4 / np.pi * (u * np.arctan(u) - np.log(np.sqrt(1 + u**2))))
    b = np.polynomial.polynomial.polyval((g - 24e-3) / 16e-3, FIELD)
    a = np.pi / TAU * (HM + g)
    coth = np.cosh(a) / np.sinh(a)
    return lam / (kc * np.sinh(a)), lam * b**2, lam * b * coth / kc, lam * coth**2 / kc**2


def accelerations(stage: ReferenceStage, x: np.ndarray, v: np.ndarray, dq: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Accelerations (m/s²) at positions, velocities, currents (motors, 2) and external forces, smooth effects only."""
    f1, f2, f3, f4 = shape_functions(x[0])
    f2 = f2 * (1 - stage.modulation * np.sin(np.pi * x[1] / T1)**2)
    c = stage.constants
    if len(x) == 2:
        rows = [G - c[3] * f4 * np.sum(dq**2) + c[2] * f3 * dq[0, 0] - c[1] * f2, -c[0] * f1 * dq[0, 1]]
    else:
        rows = [G - 2 * c[4] * f4 * np.sum(dq**2) + 2 * c[3] * f3 * np.sum(dq[:, 0]) - 4 * c[2] * f2,
                -2 * c[0] * f1 * dq[0, 1], -2 * c[1] * f1 * dq[1, 1]]
    rows = [row + axis.ripple * np.sin(2 * np.pi * place / axis.period + 0.5)
            for row, axis, place in zip(rows, stage.axes, x, strict=True)]
    # The constants are accelerations at the nominal masses; gravity is one at any mass.
    rows[0] = rows[0] - G
    found = [row * nominal / axis.mass + axis.bias + (push - axis.viscous * speed) / axis.mass for row, nominal, axis,
             push, speed in zip(rows, NOMINAL_MASSES[len(x)], stage.axes, force, v, strict=True)]
    return np.array([found[0] + G, *found[1:]])


def rates(stage: ReferenceStage, state: np.ndarray, inputs: np.ndarray, phases: bool, lag: bool) -> np.ndarray:
    """Rates of positions, velocities and, with lag, of i_d, i_q of each motor.

    Inputs are the commands of all motors, in d and q at the true displacement or in phases, then the external forces.
    """
    n = len(stage.axes)
    x, v = state[:n], state[n:2 * n]
    commands, force = inputs[:-n], inputs[-n:]
    angles = [np.pi / TAU * (d - TAU / 2) + np.array([0, -2 * np.pi / 3, 2 * np.pi / 3]) for d in x[1:]]
    if phases:
        commanded = np.array([2 / 3 * np.array([np.cos(a) @ i, -np.sin(a) @ i])
                              for a, i in zip(angles, commands.reshape(-1, 3), strict=True)])
    else:
        commanded = commands.reshape(-1, 2)
    if not lag:
        return np.concatenate([v, accelerations(stage, x, v, commanded, force)])
    dq = state[2 * n:].reshape(-1, 2)
    # The phase currents lag; what d and q see of them turns with the mover.
    turning = np.pi / TAU * v[1:, None] * np.stack([dq[:, 1], -dq[:, 0]], axis=1)
    return np.concatenate([v, accelerations(stage, x, v, dq, force), ((commanded - dq) / LAG + turning).ravel()])


def complex_step(function: Callable[[np.ndarray], np.ndarray], at: Sequence[float] | np.ndarray) -> np.ndarray:
    """Jacobian of an analytic function at a real point."""
    point = np.array(at, dtype=complex)
    columns = []
    for k in range(len(point)):
        moved = point.copy()
        moved[k] += 1j * STEP
        columns.append(function(moved).imag / STEP)
    return np.array(columns).T


def rest_currents(stage: ReferenceStage, x: Sequence[float]) -> np.ndarray:
    """i_d, i_q of each motor (A), shape (motors, 2), by Newton's method on the accelerations; equal i_d."""
    n = len(x)
    spread = np.zeros((2 * n - 2, n))
    spread[0::2, 0], spread[1::2, 1:] = 1.0, np.eye(n - 1)
    currents = np.zeros(n)

    def residual(i: np.ndarray) -> np.ndarray:
        return accelerations(stage, np.array(x), np.zeros(n), (spread @ i).reshape(-1, 2), np.zeros(n))

    for _ in range(30):
        currents = currents - np.linalg.solve(complex_step(residual, currents), residual(currents))
    assert np.abs(residual(currents)).max() < 1e-12
    return (spread @ currents).reshape(-1, 2)


def phase_commands(dq: np.ndarray, x: Sequence[float] | np.ndarray) -> np.ndarray:
    """Phase currents of all motors that make i_d, i_q at the positions."""
    return np.concatenate([3 / 2 * park_matrix(d).T @ i for i, d in zip(dq, x[1:], strict=True)])
