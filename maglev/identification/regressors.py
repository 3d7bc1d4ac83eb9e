"""The stages as the estimators see them: x' = A(y, u) θ + b(y, u), equations (4.3) and (5.3).

Only the velocity rows carry constants, and no constant is in two of them, those of tilts apart: the rows decouple.
Where the platform tilts, each motor has a gap of its own. From constants they predict thrust and equilibrium currents.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from controller_fmu.feedback_linearisation import equilibrium_current
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.arrays import Array
from maglev.files.errors import IdentificationError
from maglev.linear.places import MotorPlaces
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.stage_description import StageDescription
from pmlsm.velocity_rows import GRAVITY, normal_terms, thrust_term

# Shape functions (4, n, motors), or (4, n, 1) where all have the same gap, i_d and i_q (n, motors) to A (n, p).
Columns = Callable[[Array, Array, Array], Array]

# The rows are plain arithmetic: they take n samples as they take one.
thrusts = cast(Callable[[float, Array, Array], Array], thrust_term)
normals = cast(Callable[..., tuple[Array, Array, Array]], normal_terms)


@dataclass(frozen=True)
class ConstantRow:
    """Velocity row of one axis."""

    axis: str
    constants: tuple[str, ...]   # names of the p constants that it carries
    offset: float                # b, m/s²
    columns: Columns             # A at n samples, shape (n, p)


@dataclass(frozen=True)
class EstimatedStage:
    """A stage with the rows of all its axes, the vertical one first, and the geometry of a motor.

    `guess` has the first guess of each constant, C1 first.
    """

    described: StageDescription
    places: MotorPlaces
    motion: tuple[ConstantRow, ...]
    motor: MotorGeometry
    guess: Mapping[str, float]

    @property
    def name(self) -> str:
        return self.described.name

    @property
    def axes(self) -> tuple[str, ...]:
        return self.described.axis_names

    @property
    def motors(self) -> tuple[str, ...]:
        return self.described.motor_names

    @property
    def rows(self) -> tuple[ConstantRow, ...]:
        """The rows that say something about the constants: those of the tilts need an inertia that is assumed."""
        return self.motion[:len(self.axes) - len(self.described.rotations)]

    def gaps(self, positions: Array) -> Array:
        """Air gaps at the motors (m), shape (n, motors), or (n, 1) where all are the same."""
        return positions @ self.places.gaps.T if self.described.rotations else positions[:, :1]

    @property
    def geometries(self) -> dict[str, MotorGeometry]:
        return {motor.name: self.described.motor(motor) for motor in self.described.motors}

    @property
    def constants(self) -> tuple[str, ...]:
        return tuple(self.guess)


@dataclass(frozen=True)
class RowData:
    """One row at n samples: velocity' = a θ + b."""

    row: ConstantRow
    a: Array          # shape (n, p)
    b: Array          # m/s², shape (n,)
    velocity: Array   # m/s, measured or observed, shape (n,)


def columns(normal: Array, thrust: Array, sharing: float) -> Columns:
    """A of a row: a column for each thrust that moves its axis, then for attraction, coils and iron if these do.

    `normal`, (motors,), is the effect of the motors' vertical accelerations on the axis. `thrust`, (motors, thrusts),
    is the effect of the horizontal ones, each column for the motors of one constant. `sharing` is the number of motors
    with one current.
    """
    def of(f: Array, i_d: Array, i_q: Array) -> Array:
        columns = [thrusts(sharing, f[0], i_q) @ thrust]
        if normal.any():
            terms = normals(sharing, sharing, sharing, f[1], f[2], f[3], i_d, i_q**2 + i_d**2)
            columns.append(np.stack([np.broadcast_to(term, i_d.shape) @ normal for term in terms], axis=1))
        return np.concatenate(columns, axis=1)

    return of


def row_of_axis(described: StageDescription, places: MotorPlaces, k: int) -> ConstantRow:
    """Velocity row of an axis of a stage, by its number."""
    normal, drive = places.effects[k, 0::2], places.effects[k, 1::2]
    by_axis = {axis.name: drive * [motor.drives == axis.name for motor in described.motors]
               for axis in described.horizontal}
    driven = {axis: weights for axis, weights in by_axis.items() if weights.any()}
    names = [name for axis in driven for name in described.constants_of(axis)]
    names += described.constants_of(described.vertical.name) if normal.any() else ()
    thrust = np.array(list(driven.values())).reshape(-1, len(described.motors)).T
    return ConstantRow(described.axis_names[k], tuple(names), GRAVITY if k == 0 else 0.0,
                       columns(normal, thrust, described.sharing))


def estimated_stage(described: StageDescription) -> EstimatedStage:
    """A stage as the estimators see it: the vertical row, then a row for each other axis."""
    places = MotorPlaces.of(described)
    guess = {constant.name: constant.guess for constant in described.constants}
    return EstimatedStage(described, places,
                            tuple(row_of_axis(described, places, k) for k in range(len(described.axes))),
               described.motor(), guess)


ESTIMATED_STAGES = {name: estimated_stage(described) for name, described in PACKAGED_STAGES.items()}


def shape_functions(motor: MotorGeometry, gaps: Array) -> Array:
    """f1…f4 of `pmlsm` at air gaps (m), shape (4, …) for gaps of shape (…)."""
    # Encoders repeat themselves: most recordings have a few thousand different gaps.
    distinct, inverse = np.unique(gaps, return_inverse=True)
    values = np.array([gap_functions(motor, gap) for gap in distinct.tolist()])
    return np.ascontiguousarray(values[inverse.reshape(-1)].T).reshape(4, *gaps.shape)


def functions(stage: EstimatedStage, positions: Array) -> Array:
    """Shape functions at positions, shape (4, n, motors), or (4, n, 1) where all motors have the same gap.

    Of a motor that is unlike the others times the ratios of its constants, which the rows thus share.
    """
    gaps = stage.gaps(positions)
    if not stage.described.unlike:
        return shape_functions(stage.motor, gaps)
    motors = stage.described.motors
    return np.stack([np.array(motor.ratios)[:, None] * shape_functions(stage.geometries[motor.name], gap)
                     for motor, gap in zip(motors, np.broadcast_to(gaps, (len(gaps), len(motors))).T, strict=True)],
                    axis=2)


def regressors(stage: EstimatedStage, positions: Array, i_d: Array, i_q: Array, velocities: Array) -> list[RowData]:
    """Rows at positions and velocities (m, m/s), shape (n, axes), with delivered currents (A), (n, motors)."""
    f = functions(stage, positions)
    return [RowData(row, row.columns(f, i_d, i_q), np.full(len(positions), row.offset), velocities[:, k])
            for k, row in enumerate(stage.rows)]


def accelerations(stage: EstimatedStage, positions: Array, i_d: Array, i_q: Array,
                  constants: dict[str, float]) -> Array:
    """Accelerations of the axes by the model (m/s²), shape (n, axes)."""
    f = functions(stage, positions)
    rows: Sequence[Array] = [row.columns(f, i_d, i_q) @ np.array([constants[name] for name in row.constants])
                             + row.offset for row in stage.motion]
    return np.stack(rows, axis=1)


def row_of(stage: EstimatedStage, axis: str) -> ConstantRow:
    return next(row for row in stage.motion if row.axis == axis)


def thrust_shape(stage: EstimatedStage, gaps: Array) -> Array:
    """L/C = f1 at air gaps (m), shape (n,); L is the thrust of one motor per current, m/(s² A), of (4.3) and (5.3)."""
    return np.asarray(shape_functions(stage.motor, gaps)[0])


def fitted_parabola(time: Array, position: Array) -> tuple[float, float]:
    """Start (m) and acceleration (m/s²) of x(t) = x(0) + ½ x'' t², from rest, by least squares; shape (n,) each."""
    columns = np.stack([np.ones_like(time), 0.5 * time**2], axis=1)
    start, acceleration = np.linalg.lstsq(columns, position, rcond=None)[0].tolist()
    return start, acceleration


def thrust_of_parabola(stage: EstimatedStage, axis: str, time: Array, position: Array, i_q: float) -> float:
    """L (m/(s² A)) by least squares of x(t) = x(0) − ½ n L i_q t², (4.6) and (5.5), n motors at the current i_q (A).

    `time` (s) from the start at rest, `position` (m), shape (n,) each. IdentificationError without a current.
    """
    if i_q == 0.0:
        raise IdentificationError(f"axis {axis}: i_q = 0 A, expected a current that drives it")
    _, acceleration = fitted_parabola(time, position)
    return -acceleration / (stage.described.sharing * len(stage.described.motors_of(axis)) * i_q)


def equilibrium_currents(stage: EstimatedStage, gaps: Array, constants: Mapping[str, float]) -> Array:
    """Direct currents (A), the same in all motors, that hold air gaps (m), shape (n,), without quadrature current.

    The smaller root of the vertical row, (4.10) and its like in section 5.4.2; NaN without a root.
    """
    attraction, coils, iron = (stage.described.carrying * constants[name] for name in stage.rows[0].constants)
    currents = [equilibrium_current(stage.motor, attraction, coils, iron, gap) for gap in gaps.tolist()]
    return np.array([current if there else np.nan for current, there in currents])


def attraction_force(stage: EstimatedStage, gaps: Array, constant: float, mass: float) -> Array:
    """Force (N) of one motor's attraction at air gaps (m): M C f2, with a constant or a difference of constants."""
    return np.asarray(mass * constant * shape_functions(stage.motor, gaps)[1])
