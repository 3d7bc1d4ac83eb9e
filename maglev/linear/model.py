"""A linear state-space model whose states, inputs and outputs have names and units, and the place it holds about."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from math import inf, pi
from typing import Any

import numpy as np

from maglev.files.arrays import Array, Complex
from maglev.files.errors import LinearModelError, extra, one_of
from maglev.files.text_columns import aligned
from pmlsm.dq_transform import phase_currents
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.stage_description import StageDescription

SLOWEST = 1e-9   # 1/s, below it a rate is written as 0


@dataclass(frozen=True)
class Equilibrium:
    """A stage at rest."""

    positions: dict[str, float]   # of each axis, the vertical one first, m
    i_d: tuple[float, ...]   # of each motor, A; both motors of the 3-DOF stage have the same
    i_q: tuple[float, ...]   # of each motor, A
    stage: StageDescription = field(repr=False)
    along: tuple[float, ...]   # displacement of each motor, m
    geometries: tuple[MotorGeometry, ...] = field(repr=False)

    @property
    def motors(self) -> tuple[str, ...]:
        return self.stage.motor_names

    @property
    def dq(self) -> Array:
        """Direct and quadrature current of each motor in turn, A, shape (2 motors,)."""
        return np.array(list(self.currents.values()))

    @property
    def currents(self) -> dict[str, float]:
        """Direct and quadrature current of each motor by name, such as "alpha.i_d", A."""
        return dict(zip(self.stage.dq_names, chain(*zip(self.i_d, self.i_q, strict=True)), strict=True))

    @property
    def phases(self) -> dict[str, float]:
        """Phase currents of each motor by name, such as "alpha.i_a", A."""
        values = [phase_currents(d, q, of.electrical_angle(along)) for of, along, d, q in
                  zip(self.geometries, self.along, self.i_d, self.i_q, strict=True)]
        return dict(zip(self.stage.phase_names, chain(*values), strict=True))

    def __str__(self) -> str:
        """The equilibrium in one line."""
        places = ", ".join(f"{axis.name} = {1e3 * self.positions[axis.name]:g} m{axis.unit('m')}"
                           for axis in self.stage.axes)
        return f"{places}; {', '.join(f'{name} = {value:.4g} A' for name, value in self.currents.items())}"


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Deviations from an equilibrium: x' = A x + B u, y = C x + D u, or x[k+1] = A x[k] + B u[k] if it is sampled.

    Attributes
    ----------
    name : str
        Name of the linearised block.
    states, inputs, outputs : tuple of str
        Names, such as "y.velocity"; a variable of the block has the name that the block uses.
    A, B, C, D : ndarray
        Shapes (n, n), (n, m), (p, n), (p, m) for n states, m inputs and p outputs, SI units.
    units : dict of str to str
        Unit of every state, input and output.
    sample_time : float or None
        s; None for a continuous-time model.
    equilibrium : Equilibrium
        Positions and currents that the model holds about.
    commutation : ndarray or None
        Of a plant whose held inputs in d and q are commutated with its sampled outputs: the share that an output adds
        to each input, shape (m, p), A/m. B commutation C is part of A. None if no measurement commutates anything.
    """

    name: str
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    A: Array
    B: Array
    C: Array
    D: Array
    units: dict[str, str]
    sample_time: float | None
    equilibrium: Equilibrium
    commutation: Array | None = None

    def __post_init__(self) -> None:
        """Raise for entries that are no finite numbers."""
        if not all(np.all(np.isfinite(matrix)) for matrix in (self.A, self.B, self.C, self.D)):
            at = "" if self.sample_time is None else f", held for {self.sample_time:g} s"
            raise LinearModelError(f"{self.name}{at}: its linear model overflows, expected a time and parameters "
                                   "nearer to those of the stage")

    def __repr__(self) -> str:
        every = "continuous" if self.sample_time is None else f"every {self.sample_time:g} s"
        return (f"<LinearModel {self.name}: {len(self.states)} states, {len(self.inputs)} inputs, {len(self.outputs)} "
                f"outputs, {every}>")

    @property
    def poles(self) -> Complex:
        """Eigenvalues of A, shape (n,): 1/s of a continuous-time model, in the z-plane of a sampled one."""
        return np.linalg.eigvals(self.A).astype(np.complex128)

    @property
    def rates(self) -> Complex:
        """Poles as rates of decay and oscillation, 1/s, the slowest first, shape (n,).

        Those of a sampled model are its continuous equivalents ln(z)/Ts; a pole at z = 0 has the rate −∞.
        """
        return slowest_first(self.poles if self.sample_time is None else equivalents(self.poles, self.sample_time))

    @np.errstate(over="ignore", invalid="ignore")   # values that are no numbers raise later
    def discretise(self, sample_time: float) -> "LinearModel":
        """Sample a continuous-time model (s) whose inputs are held between the samples, exactly.

        LinearModelError if the model is sampled already, or the sample time is not positive.
        """
        if self.sample_time is not None:
            raise LinearModelError(f"{self.name}: sampled already, at {self.sample_time:g} s, expected a "
                                   "continuous-time model")
        if not 0.0 < sample_time < float("inf"):
            raise LinearModelError(f"{self.name}: sample time = {sample_time!r} s, expected a positive, finite one")
        n, m = self.B.shape
        # [x; u]' = [A B; 0 0] [x; u], for u is constant.
        held = np.zeros((n + m, n + m))
        held[:n, :n], held[:n, n:] = self.A, self.B
        held *= sample_time
        from scipy.linalg import expm  # commands that linearise nothing start without it

        step = expm(held) if np.all(np.isfinite(held)) else held
        return replace(self, A=step[:n, :n], B=step[:n, n:], sample_time=sample_time)

    def select(self, inputs: Sequence[str], outputs: Sequence[str]) -> "LinearModel":
        """Return the model with these inputs and outputs only, in this order; LinearModelError for one that it lacks.
        """
        columns = [self.index("input", name) for name in inputs]
        rows = [self.index("output", name) for name in outputs]
        return replace(self, inputs=tuple(inputs), outputs=tuple(outputs), B=self.B[:, columns], C=self.C[rows],
                       D=self.D[np.ix_(rows, columns)], commutation=None if self.commutation is None else
                       self.commutation[np.ix_(columns, rows)])

    def index(self, kind: str, name: str) -> int:
        """Place of a name among the states, inputs or outputs; `kind` is "state", "input" or "output"."""
        names = {"state": self.states, "input": self.inputs, "output": self.outputs}[kind]
        if name not in names:
            raise LinearModelError(f"{self.name}: no {kind} {name!r}, expected {one_of(name, names)}")
        return names.index(name)

    def frequency_response(self, frequencies: Array) -> Complex:
        """Response C (s I − A)⁻¹ B + D at frequencies (rad/s), shape (frequencies, outputs, inputs).

        s is jω, of a sampled model z = exp(jω Ts).
        """
        s = 1j * np.asarray(frequencies, dtype=float)
        if self.sample_time is not None:
            s = np.exp(s * self.sample_time)
        resolvent = s[:, None, None] * np.eye(len(self.states)) - self.A
        # Twice the size of A would fit into memory for any number of frequencies that is plotted.
        return np.asarray(self.C @ np.linalg.solve(resolvent, self.B.astype(complex)[None]) + self.D)

    def to_control(self) -> Any:
        """The model as python-control's StateSpace, with the same names; LinearModelError if that is not installed."""
        control = extra("control", "design", "to_control", LinearModelError)
        # python-control uses the dot for results of its own, such as "sys.y".
        names = {kind: [name.replace(".", "_") for name in of] for kind, of in
                 (("states", self.states), ("inputs", self.inputs), ("outputs", self.outputs))}
        dt = 0 if self.sample_time is None else self.sample_time
        return control.ss(self.A, self.B, self.C, self.D, dt, name=self.name.replace(".", "_"), **names)

    def __str__(self) -> str:
        """Matrices with the names of rows and columns, units, equilibrium and poles."""
        kind = "continuous" if self.sample_time is None else f"sampled every {1e3 * self.sample_time:g} ms"
        parts = [f"{self.name}, {kind}, about {self.equilibrium}",
                 "\n".join(f"{title:<7}  {numbered(names, self.units)}" for title, names in
                           (("states", self.states), ("inputs", self.inputs), ("outputs", self.outputs))),
                 *(matrix_text(title, matrix, rows) for title, matrix, rows in (
                     ("A", self.A, self.states), ("B", self.B, self.states), ("C", self.C, self.outputs),
                     ("D", self.D, self.outputs)))]
        title = "poles" if self.sample_time is None else "poles, as rates ln(z)/Ts"
        return "\n\n".join([*parts, f"{title}\n{poles_text(self.rates)}"]) + "\n"

    def as_data(self) -> dict[str, Any]:
        """Model as JSON has it; matrices are lists of rows, a sample time of null is continuous time."""
        return {"name": self.name, "sample_time": self.sample_time, "states": list(self.states),
                "inputs": list(self.inputs), "outputs": list(self.outputs), "units": self.units,
                "A": self.A.tolist(), "B": self.B.tolist(), "C": self.C.tolist(), "D": self.D.tolist(),
                "equilibrium": {"positions": self.equilibrium.positions, "currents": self.equilibrium.currents,
                                "phases": self.equilibrium.phases}}


def equivalents(poles: Complex, sample_time: float) -> Complex:
    """Continuous equivalents ln(z)/Ts (1/s) of poles in the z-plane; −∞ of z = 0."""
    rates = np.full(len(poles), complex(-np.inf))
    rates[poles != 0.0] = np.log(poles[poles != 0.0]) / sample_time
    return rates


def slowest_first(rates: Complex) -> Complex:
    """Rates by their real parts, the largest first; of conjugates that with the negative imaginary part first."""
    return rates[np.lexsort((rates.imag, -rates.real))]


def numbered(names: Sequence[str], units: dict[str, str]) -> str:
    return ", ".join(f"{k} {name} ({units[name]})" for k, name in enumerate(names, 1))


def matrix_text(title: str, matrix: Array, rows: Sequence[str]) -> str:
    """Matrix with a name for each row, a number for each column; zeros are dots, a matrix of zeros is its size."""
    if not matrix.any():
        return f"{title} = 0, {matrix.shape[0]} × {matrix.shape[1]}"
    cells = [[title, *(str(k) for k in range(1, matrix.shape[1] + 1))]]
    cells += [[name, *(f"{value:.6g}" if value else "·" for value in values)]
              for name, values in zip(rows, matrix, strict=True)]
    return aligned(cells)


def poles_text(rates: Complex) -> str:
    """Table of rates: real and imaginary part, natural frequency, damping; a pair of conjugates in one row."""
    cells = [["real (1/s)", "imaginary (rad/s)", "frequency (Hz)", "damping"]]
    for rate in rates[rates.imag >= 0.0]:
        size = abs(rate)
        if size < SLOWEST:
            cells.append(["0", "", "", ""])
            continue
        known = [f"{size / (2.0 * pi):.4g}", f"{-rate.real / size:.3f}"] if size < inf else ["", ""]
        cells.append([f"{rate.real:.6g}", f"±{rate.imag:.6g}" if rate.imag else "", *known])
    return aligned(cells)
