"""The rigs as the estimators see them: x' = A(y, u) θ + b(y, u), equations (4.3) and (5.3).

Only the velocity rows carry constants, and no constant is in two of them: the rows decouple.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmlsm.data_sheet import GRAVITY
from pmlsm.gap_functions import gap_functions

Array = NDArray[np.float64]

Columns = Callable[[Array, Array, Array], Array]   # shape functions (4, n), i_d and i_q (n, motors) to A (n, p)


@dataclass(frozen=True)
class Row:
    """Velocity row of one axis.

    Attributes
    ----------
    axis : str
    constants : tuple of str
        Names of the p constants that it carries.
    offset : float
        b, m/s².
    columns : callable
        A at n samples, shape (n, p).
    """

    axis: str
    constants: tuple[str, ...]
    offset: float
    columns: Columns


@dataclass(frozen=True)
class Rig:
    """Axes, the vertical one first, motors and rows of a rig."""

    name: str
    axes: tuple[str, ...]
    motors: tuple[str, ...]
    rows: tuple[Row, ...]

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of all constants, C1 first."""
        return tuple(sorted(name for row in self.rows for name in row.constants))


@dataclass(frozen=True)
class RowData:
    """One row at n samples: velocity' = a θ + b.

    Attributes
    ----------
    row : Row
    a : ndarray, shape (n, p)
    b : ndarray, shape (n,)
        m/s².
    velocity : ndarray, shape (n,)
        m/s, measured or observed.
    """

    row: Row
    a: Array
    b: Array
    velocity: Array


def thrust(motor: int, factor: float) -> Columns:
    """A of a horizontal axis: −factor f1 i_q."""
    return lambda f, i_d, i_q: np.asarray(-factor * f[0] * i_q[:, motor])[:, None]


def lift_2dof(f: Array, i_d: Array, i_q: Array) -> Array:
    """A of (4.3), vertical: −f2, f3 i_d, −f4 (i_q² + i_d²)."""
    return np.stack([-f[1], f[2] * i_d[:, 0], -f[3] * (i_q[:, 0] ** 2 + i_d[:, 0] ** 2)], axis=1)


def lift_3dof(f: Array, i_d: Array, i_q: Array) -> Array:
    """A of (5.3), vertical: −4 f2, 2 f3 (i_dα + i_dβ), −2 f4 (i_qα² + i_dα² + i_qβ² + i_dβ²)."""
    return np.stack([-4.0 * f[1], 2.0 * f[2] * i_d.sum(axis=1),
                     -2.0 * f[3] * (i_q**2 + i_d**2).sum(axis=1)], axis=1)


RIGS = {
    "2dof": Rig("2dof", ("v", "h"), ("motor",), (
        Row("v", ("C2", "C3", "C4"), GRAVITY, lift_2dof),
        Row("h", ("C1",), 0.0, thrust(0, 1.0)))),
    # (5.3) prints the x and z rows without the factor 2; it belongs there (corrected).
    "3dof": Rig("3dof", ("y", "x", "z"), ("alpha", "beta"), (
        Row("y", ("C3", "C4", "C5"), GRAVITY, lift_3dof),
        Row("x", ("C1",), 0.0, thrust(0, 2.0)),
        Row("z", ("C2",), 0.0, thrust(1, 2.0)))),
}


def shape_functions(gaps: Array) -> Array:
    """f1…f4 of `pmlsm` at n air gaps (m), shape (4, n)."""
    # Encoders repeat themselves: most recordings have a few thousand different gaps.
    distinct, inverse = np.unique(gaps, return_inverse=True)
    values = np.array([gap_functions(gap) for gap in distinct.tolist()])
    return np.ascontiguousarray(values[inverse.reshape(-1)].T)


def regressors(rig: Rig, positions: Array, i_d: Array, i_q: Array, velocities: Array) -> list[RowData]:
    """Rows of a rig from data.

    Parameters
    ----------
    rig : Rig
    positions, velocities : ndarray, shape (n, axes)
        m and m/s.
    i_d, i_q : ndarray, shape (n, motors)
        Delivered currents, A.
    """
    f = shape_functions(positions[:, 0])
    return [RowData(row, row.columns(f, i_d, i_q), np.full(len(positions), row.offset), velocities[:, k])
            for k, row in enumerate(rig.rows)]


def accelerations(rig: Rig, positions: Array, i_d: Array, i_q: Array, constants: dict[str, float]) -> Array:
    """Accelerations of the axes by the model (m/s²), shape (n, axes)."""
    f = shape_functions(positions[:, 0])
    rows: Sequence[Array] = [row.columns(f, i_d, i_q) @ np.array([constants[name] for name in row.constants])
                             + row.offset for row in rig.rows]
    return np.stack(rows, axis=1)
