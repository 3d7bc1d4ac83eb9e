"""Maps of tolerances as a picture: a column for each law, a row for each question and step of the gap."""

from pathlib import Path

import numpy as np

from maglev.maps.tolerances import OUTCOMES, QUESTIONS, RigMaps

COLOURS = ("#2a9d5c", "#f4c152", "#c8503c", "#8e6bb0")


def write_picture(path: Path, title: str, rig: RigMaps) -> None:
    """Write a PNG of all maps of a rig."""
    from matplotlib.colors import ListedColormap  # an extra: only who draws needs it
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    rows = [(question, k) for question in QUESTIONS if question.name in rig.maps for k in range(len(rig.sizes))]
    laws = list(next(iter(rig.maps.values())))
    figure = Figure(figsize=(2.5 * len(laws) + 1.0, 2.3 * len(rows) + 0.9), layout="constrained")
    grid = figure.subplots(len(rows), len(laws), squeeze=False)
    figure.suptitle(f"{title}: what each law tolerates")
    colours = ListedColormap(COLOURS)
    for row, (question, k) in enumerate(rows):
        for column, law in enumerate(laws):
            axes = grid[row][column]
            axes.pcolormesh(rig.maps[question.name][law][k], cmap=colours, vmin=-0.5, vmax=len(OUTCOMES) - 0.5,
                            edgecolors="white", linewidth=0.4)
            for ticks, labels, side in ((axes.set_xticks, axes.set_xticklabels, question.along),
                                        (axes.set_yticks, axes.set_yticklabels, question.down)):
                ticks(np.arange(len(side.values)) + 0.5)
                labels([side.text(value).partition(" ")[0].replace("no", "∞") for value in side.values], fontsize=7)
            axes.tick_params(length=0)
            if row == 0:
                axes.set_title(law)
            unit = question.along.unit.replace("um", "µm")
            axes.set_xlabel(f"{question.along.name}, {unit}", fontsize=8)
        unit = question.down.unit.replace("um", "µm")
        grid[row][0].set_ylabel(f"step {rig.sizes[k]:g} mm\n{question.down.name}, {unit}", fontsize=9)
    seen = np.unique(np.concatenate([found.ravel() for laws in rig.maps.values() for found in laws.values()]))
    figure.legend(handles=[Patch(color=COLOURS[outcome], label=OUTCOMES[outcome]) for outcome in seen.tolist()],
                  loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(path, dpi=100)
