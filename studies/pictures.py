"""Maps as a picture: a column for each law, a row for each thing that was asked of the laws."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from maglev.maps.rows import Row, seen


def write_picture(path: Path, title: str, rows: Sequence[Row], outcomes: Sequence[str], colours: Sequence[str],
                  dotted: str = "") -> None:
    """Write a PNG; the cells are numbers of outcomes, and `dotted` says what a dot on one means, if there are any."""
    from matplotlib.colors import ListedColormap  # an extra: only who draws needs it
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    laws = list(rows[0].cells)
    figure = Figure(figsize=(2.5 * len(laws) + 1.0, 2.3 * len(rows) + 0.9), layout="constrained")
    grid = figure.subplots(len(rows), len(laws), squeeze=False)
    figure.suptitle(title)
    for row, places in zip(rows, grid, strict=True):
        for law, axes in zip(laws, places, strict=True):
            axes.pcolormesh(row.cells[law], cmap=ListedColormap(colours), vmin=-0.5, vmax=len(outcomes) - 0.5,
                            edgecolors="white", linewidth=0.4)
            if law in row.dots:
                down, along = np.nonzero(row.dots[law])
                axes.plot(along + 0.5, down + 0.5, "k.", markersize=3)
            axes.set_xticks(np.arange(len(row.along.labels)) + 0.5, row.along.labels, fontsize=7)
            axes.set_yticks(np.arange(len(row.down.labels)) + 0.5, row.down.labels, fontsize=7)
            axes.tick_params(length=0)
            axes.set_xlabel(row.along.title, fontsize=8)
        # What two sides are about, which some headings begin with, stands at the sides.
        places[0].set_ylabel(f"{row.heading.rpartition(', ')[2]}\n{row.down.title}", fontsize=9)
    for law, axes in zip(laws, grid[0], strict=True):
        axes.set_title(law)
    found = seen(cells for row in rows for cells in row.cells.values())
    figure.legend(handles=[Patch(color=colours[outcome], label=outcomes[outcome]) for outcome in found],
                  loc="outside lower center", ncols=4, frameon=False, title=f"·  {dotted}" if dotted else None)
    figure.savefig(path, dpi=100)
