"""The rigs as the estimators see them: x' = A(y, u) θ + b(y, u), equations (4.3) and (5.3).

Only the velocity rows carry constants, and no constant is in two of them: the rows decouple.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.rig import Rig as RigDescription
from pmlsm.rigs import RIGS as DESCRIPTIONS
from pmlsm.velocity_rows import GRAVITY, normal_terms, thrust_acceleration

Array = NDArray[np.float64]

Columns = Callable[[Array, Array, Array], Array]   # shape functions (4, n), i_d and i_q (n, motors) to A (n, p)

# The rows are plain arithmetic: they take n samples as they take one.
thrusts = cast(Callable[[float, Array, Array], Array], thrust_acceleration)
normals = cast(Callable[..., tuple[Array, Array, Array]], normal_terms)


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
    """Axes, the vertical one first, motors and rows of a rig, and the geometry of a motor.

    Of each motor, `along` is the place of the axis that it drives among the axes; `guess` has the first guess of each
    constant, C1 first.
    """

    name: str
    axes: tuple[str, ...]
    motors: tuple[str, ...]
    along: tuple[int, ...]
    rows: tuple[Row, ...]
    motor: MotorGeometry
    guess: Mapping[str, float]

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of all constants, C1 first."""
        return tuple(self.guess)


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


def thrust(driving: list[int], sharing: float) -> Columns:
    """A of a horizontal axis, with the motors that drive it and the number of those with one current."""
    return lambda f, i_d, i_q: thrusts(sharing, f[0], i_q[:, driving].sum(axis=1))[:, None]


def lift(attracting: float, motors: float) -> Columns:
    """A of the vertical axis, with the number of all motors and of those with one current."""
    return lambda f, i_d, i_q: np.stack(normals(attracting, motors, motors, f[1], f[2], f[3], i_d.sum(axis=1),
                                                (i_q**2 + i_d**2).sum(axis=1)), axis=1)


def rig_of(described: RigDescription) -> Rig:
    """A rig as the estimators see it: the vertical row, then a row for each horizontal axis."""
    vertical, drives = described.vertical.name, [motor.drives for motor in described.motors]
    rows = (Row(vertical, described.constants_of(vertical), GRAVITY, lift(described.carrying, described.sharing)),
            *(Row(axis.name, described.constants_of(axis.name), 0.0,
                  thrust([k for k, driven in enumerate(drives) if driven == axis.name], described.sharing))
              for axis in described.horizontal))
    along = tuple(described.axis_names.index(axis) for axis in drives)
    guess = {constant.name: constant.guess for constant in described.constants}
    return Rig(described.name, described.axis_names, described.motor_names, along, rows, described.motor(), guess)


# Where the platform tilts, each motor has an air gap of its own: its rows are not these.
RIGS = {name: rig_of(described) for name, described in DESCRIPTIONS.items() if not described.rotations}


def shape_functions(motor: MotorGeometry, gaps: Array) -> Array:
    """f1…f4 of `pmlsm` at n air gaps (m), shape (4, n)."""
    # Encoders repeat themselves: most recordings have a few thousand different gaps.
    distinct, inverse = np.unique(gaps, return_inverse=True)
    values = np.array([gap_functions(motor, gap) for gap in distinct.tolist()])
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
    f = shape_functions(rig.motor, positions[:, 0])
    return [RowData(row, row.columns(f, i_d, i_q), np.full(len(positions), row.offset), velocities[:, k])
            for k, row in enumerate(rig.rows)]


def accelerations(rig: Rig, positions: Array, i_d: Array, i_q: Array, constants: dict[str, float]) -> Array:
    """Accelerations of the axes by the model (m/s²), shape (n, axes)."""
    f = shape_functions(rig.motor, positions[:, 0])
    rows: Sequence[Array] = [row.columns(f, i_d, i_q) @ np.array([constants[name] for name in row.constants])
                             + row.offset for row in rig.rows]
    return np.stack(rows, axis=1)
