"""A linear state-space model whose states, inputs and outputs have names and units."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from maglev.errors import LinearModelError, nearest

if TYPE_CHECKING:
    from maglev.linear.equilibrium import Equilibrium

Matrix = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Deviations from an equilibrium: x' = A x + B u, y = C x + D u, or x[k+1] = A x[k] + B u[k] if it is sampled.

    Attributes
    ----------
    name : str
        What was linearised.
    states, inputs, outputs : tuple of str
        Names, such as "y.velocity"; what a block has as a variable is called what the block calls it.
    A, B, C, D : ndarray
        Shapes (n, n), (n, m), (p, n), (p, m) for n states, m inputs and p outputs, SI units.
    units : dict of str to str
        Unit of every state, input and output.
    sample_time : float or None
        s; None for a continuous-time model.
    equilibrium : Equilibrium
        Positions and currents that the model holds about.
    """

    name: str
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix
    units: dict[str, str]
    sample_time: float | None
    equilibrium: "Equilibrium"

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

    def discretise(self, sample_time: float) -> "LinearModel":
        """Sample a continuous-time model (s) whose inputs are held between the samples, exactly.

        Raises
        ------
        LinearModelError
            If the model is sampled already, or the sample time is not positive.
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
        step = expm(held * sample_time)
        return replace(self, A=step[:n, :n], B=step[:n, n:], sample_time=sample_time)

    def select(self, inputs: Sequence[str], outputs: Sequence[str]) -> "LinearModel":
        """Return the model with only these inputs and outputs, in this order.

        Raises
        ------
        LinearModelError
            If the model has no such input or output.
        """
        columns = [self.index("input", name) for name in inputs]
        rows = [self.index("output", name) for name in outputs]
        return replace(self, inputs=tuple(inputs), outputs=tuple(outputs), B=self.B[:, columns], C=self.C[rows],
                       D=self.D[np.ix_(rows, columns)])

    def index(self, kind: str, name: str) -> int:
        """Place of a name among the states, inputs or outputs; `kind` is "state", "input" or "output"."""
        names = {"state": self.states, "input": self.inputs, "output": self.outputs}[kind]
        if name not in names:
            raise LinearModelError(f"{self.name}: no {kind} {name!r}, expected one of {', '.join(names)}; "
                                   f"nearest is {nearest(name, names)}")
        return names.index(name)

    def frequency_response(self, frequencies: Matrix) -> Complex:
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
        """Return the model as python-control's StateSpace, with the same names.

        Raises
        ------
        LinearModelError
            If python-control is not installed.
        """
        try:
            import control
        except ModuleNotFoundError:
            raise LinearModelError("to_control needs python-control, expected it to be installed: "
                                   "pip install 'maglev-fmus[design]'") from None
        # It uses the dot for results of its own, such as "sys.y".
        names = {kind: [name.replace(".", "_") for name in of] for kind, of in
                 (("states", self.states), ("inputs", self.inputs), ("outputs", self.outputs))}
        dt = 0 if self.sample_time is None else self.sample_time
        return control.ss(self.A, self.B, self.C, self.D, dt, name=self.name.replace(".", "_"), **names)

    def __str__(self) -> str:
        """The model as text."""
        from maglev.linear.text import text_of

        return text_of(self)


def equivalents(poles: Complex, sample_time: float) -> Complex:
    """Continuous equivalents ln(z)/Ts (1/s) of poles in the z-plane; −∞ of z = 0."""
    rates = np.full(len(poles), complex(-np.inf))
    rates[poles != 0.0] = np.log(poles[poles != 0.0]) / sample_time
    return rates


def slowest_first(rates: Complex) -> Complex:
    """Rates by their real parts, the largest first; of conjugates that with the negative imaginary part first."""
    return rates[np.lexsort((rates.imag, -rates.real))]
