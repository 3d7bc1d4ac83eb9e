"""Linear models as text, and columns and lines of any text."""

import re
from collections.abc import Sequence
from math import inf, pi
from textwrap import fill

from maglev.files.arrays import Array, Complex

WIDTH = 80       # letters of a line
SLOWEST = 1e-9   # 1/s, below it a rate is written as 0


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


def aligned(cells: list[list[str]]) -> str:
    """Columns of text, the first one to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "\n".join("  ".join([row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in
                                                          zip(row[1:], widths[1:], strict=True))]).rstrip()
                     for row in cells)


def in_width(head: str, text: str) -> str:
    """A head and its text in lines of 80 letters, the text under itself, numbers with their units."""
    lines = fill(unbroken(text), WIDTH, initial_indent=" " * len(head), subsequent_indent=" " * len(head))
    return head + lines[len(head):].replace("\N{NO-BREAK SPACE}", " ")


def unbroken(text: str) -> str:
    """The text with numbers, their units and the sign before them kept on one line."""
    return re.sub(r"(?<=\d) (?=%|(?:mm|µm|ms|[mµ]rad|kg|[sANV])\b)|(?<=[<>≤≥]) (?=\d)", "\N{NO-BREAK SPACE}", text)
