"""What the model of a rig predicts from its constants: thrust and equilibrium currents over the air gap."""

from collections.abc import Mapping

import numpy as np

from controller_fmu.feedback_linearisation import equilibrium_current
from maglev.arrays import Array
from maglev.errors import IdentificationError
from maglev.identification.rigs import ConstantRow, Rig, shape_functions


def row_of(rig: Rig, axis: str) -> ConstantRow:
    return next(row for row in rig.motion if row.axis == axis)


def thrust_shape(rig: Rig, gaps: Array) -> Array:
    """L/C = f1 at air gaps (m), shape (n,); L is the thrust of one motor per current, m/(s² A), of (4.3) and (5.3)."""
    return np.asarray(shape_functions(rig.motor, gaps)[0])


def thrust_factor(rig: Rig, axis: str) -> float:
    """Acceleration of a horizontal axis over −L i_q: the number of motors that drive it."""
    return rig.described.sharing * len(rig.described.motors_of(axis))


def fitted_parabola(time: Array, position: Array) -> tuple[float, float]:
    """Start (m) and acceleration (m/s²) of x(t) = x(0) + ½ x'' t², from rest, by least squares; shape (n,) each."""
    columns = np.stack([np.ones_like(time), 0.5 * time**2], axis=1)
    start, acceleration = np.linalg.lstsq(columns, position, rcond=None)[0].tolist()
    return start, acceleration


def thrust_of_parabola(rig: Rig, axis: str, time: Array, position: Array, i_q: float) -> float:
    """L (m/(s² A)) by least squares of x(t) = x(0) − ½ n L i_q t², (4.6) and (5.5), n motors at the current i_q (A).

    `time` (s) from the start at rest, `position` (m), shape (n,) each. IdentificationError without a current.
    """
    if i_q == 0.0:
        raise IdentificationError(f"axis {axis}: i_q = 0 A, expected a current that drives it")
    _, acceleration = fitted_parabola(time, position)
    return -acceleration / (thrust_factor(rig, axis) * i_q)


def equilibrium_currents(rig: Rig, gaps: Array, constants: Mapping[str, float]) -> Array:
    """Direct currents (A), the same in all motors, that hold air gaps (m), shape (n,), without quadrature current.

    The smaller root of the vertical row, (4.10) and its like in section 5.4.2; NaN where there is none.
    """
    attraction, coils, iron = (rig.described.carrying * constants[name] for name in rig.rows[0].constants)
    currents = [equilibrium_current(rig.motor, attraction, coils, iron, gap) for gap in gaps.tolist()]
    return np.array([current if there else np.nan for current, there in currents])


def attraction_force(rig: Rig, gaps: Array, constant: float, mass: float) -> Array:
    """Force (N) of one motor's attraction at air gaps (m): M C f2, with a constant or a difference of constants."""
    return np.asarray(mass * constant * shape_functions(rig.motor, gaps)[1])
