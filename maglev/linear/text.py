"""Linear models as text."""

from collections.abc import Sequence
from math import pi

import numpy as np

from maglev.linear.model import Complex, LinearModel, Matrix

SLOWEST = 1e-9   # 1/s, below it a rate is written as 0


def text_of(model: LinearModel) -> str:
    """Matrices with the names of rows and columns, units, equilibrium and poles."""
    kind = "continuous" if model.sample_time is None else f"sampled every {1e3 * model.sample_time:g} ms"
    parts = [f"{model.name}, {kind}, about {model.equilibrium}",
             "\n".join(f"{title:<7}  {numbered(names, model.units)}" for title, names in
                       (("states", model.states), ("inputs", model.inputs), ("outputs", model.outputs)))]
    for title, matrix, rows in (("A", model.A, model.states), ("B", model.B, model.states),
                                ("C", model.C, model.outputs), ("D", model.D, model.outputs)):
        parts.append(matrix_text(title, matrix, rows) if matrix.any() else
                     f"{title} = 0, {matrix.shape[0]} × {matrix.shape[1]}")
    title = "poles" if model.sample_time is None else "poles, as rates ln(z)/Ts"
    return "\n\n".join([*parts, f"{title}\n{poles_text(model.rates)}"]) + "\n"


def numbered(names: Sequence[str], units: dict[str, str]) -> str:
    """Names with numbers and units in one line."""
    return ", ".join(f"{k} {name} ({units[name]})" for k, name in enumerate(names, 1))


def matrix_text(title: str, matrix: Matrix, rows: Sequence[str]) -> str:
    """Matrix with a name for each row, a number for each column; zeros are dots."""
    cells = [[title, *(str(k) for k in range(1, matrix.shape[1] + 1))]]
    cells += [[name, *(f"{value:.6g}" if value else "·" for value in values)]
              for name, values in zip(rows, matrix, strict=True)]
    return aligned(cells)


def poles_text(rates: Complex) -> str:
    """Table of rates: real and imaginary part, natural frequency, damping; a pair of conjugates in one row."""
    cells = [["real (1/s)", "imaginary (rad/s)", "frequency (Hz)", "damping"]]
    for rate in rates:
        if rate.imag < 0.0:
            continue
        size = abs(rate)
        if size < SLOWEST:
            cells.append(["0", "", "", ""])
            continue
        cells.append([f"{rate.real:.6g}", f"±{rate.imag:.6g}" if rate.imag else "",
                      f"{size / (2.0 * pi):.4g}" if np.isfinite(size) else "", f"{-rate.real / size:.3f}"
                      if np.isfinite(size) else ""])
    return aligned(cells)


def aligned(cells: list[list[str]]) -> str:
    """Columns of text, the first one to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "\n".join("  ".join([row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in
                                                          zip(row[1:], widths[1:], strict=True))]).rstrip()
                     for row in cells)


def data_of(model: LinearModel) -> dict[str, object]:
    """Model as plain data, for JSON; matrices are lists of rows, a sample time of null is continuous time."""
    return {"name": model.name, "sample_time": model.sample_time, "states": list(model.states),
            "inputs": list(model.inputs), "outputs": list(model.outputs), "units": model.units,
            "A": model.A.tolist(), "B": model.B.tolist(), "C": model.C.tolist(), "D": model.D.tolist(),
            "equilibrium": {"positions": model.equilibrium.positions, "currents": model.equilibrium.currents,
                            "phases": model.equilibrium.phases}}
