"""Maps of tolerances as a picture: a column for each law, a row for each question and step of the gap."""

from itertools import cycle
from pathlib import Path

import numpy as np

from maglev.maps.rows import seen
from maglev.maps.tolerances import OUTCOMES, RigMaps

COLOURS = ("#2a9d5c", "#f4c152", "#c8503c", "#8e6bb0")


def write_picture(path: Path, title: str, rig: RigMaps) -> None:
    """Write a PNG of all maps of a rig."""
    from matplotlib.colors import ListedColormap  # an extra: only who draws needs it
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    rows = rig.rows()
    laws = list(rows[0].cells)
    figure = Figure(figsize=(2.5 * len(laws) + 1.0, 2.3 * len(rows) + 0.9), layout="constrained")
    grid = figure.subplots(len(rows), len(laws), squeeze=False)
    figure.suptitle(f"{title}: what each law tolerates")
    colours = ListedColormap(COLOURS)
    for row, size, places in zip(rows, cycle(rig.sizes), grid, strict=False):
        for law, axes in zip(laws, places, strict=True):
            axes.pcolormesh(row.cells[law], cmap=colours, vmin=-0.5, vmax=len(OUTCOMES) - 0.5, edgecolors="white",
                            linewidth=0.4)
            for ticks, labels, side in ((axes.set_xticks, axes.set_xticklabels, row.along),
                                        (axes.set_yticks, axes.set_yticklabels, row.down)):
                ticks(np.arange(len(side.labels)) + 0.5)
                labels(side.labels, fontsize=7)
            axes.tick_params(length=0)
            axes.set_xlabel(row.along.title, fontsize=8)
        places[0].set_ylabel(f"step {size:g} mm\n{row.down.title}", fontsize=9)
    for law, axes in zip(laws, grid[0], strict=True):
        axes.set_title(law)
    found = seen(cells for row in rows for cells in row.cells.values())
    figure.legend(handles=[Patch(color=COLOURS[outcome], label=OUTCOMES[outcome]) for outcome in found],
                  loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(path, dpi=100)
