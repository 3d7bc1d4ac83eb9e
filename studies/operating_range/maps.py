"""How far a law can go: maps of a study over two gaps, what else steps and constants, and pictures."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from maglev.errors import MaglevError
from maglev.maps.operating_range import (
    ASTRAY,
    LIMITED,
    NEAR,
    OUTCOMES,
    RECOVERED,
    SETTLED,
    SETTLED_NOMINAL,
    STEPS,
    STOPPED,
    TRIPPED,
    Map,
    RigMaps,
)
from maglev.maps.rows import Outcomes, seen, texts_of
from maglev_files.whole_file import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = ("#2a9d5c", "#a8d5a2", "#f4c152", "#8fa7c4", "#8e6bb0", "#c8503c")

CURRENT_LIMIT = 4.0   # A, of the commands of all laws
ENDING = 1.0          # s, in which a command at its limit counts


def outcomes(columns: Mapping[str, NDArray[Any]], at_limit: NDArray[np.bool_]) -> Outcomes:
    """Outcome of each sample.

    Parameters
    ----------
    columns : mapping of str to ndarray, shape (samples,)
        Metrics of a study: "trip time", "stop contact time", and "end error of" every axis.
    at_limit : ndarray of bool, shape (samples,)
        Whether a command ends at its limit.

    Returns
    -------
    ndarray of int, shape (samples,)
        Indices of `OUTCOMES`.
    """
    near = np.all([values <= NEAR for name, values in columns.items() if name.startswith("end error of ")],
                  axis=0)
    tripped, touched = (np.isfinite(columns[name]) for name in ("trip time", "stop contact time"))
    # A trip lets the mover fall on a stop, and what lies on a stop is at its limit: the first cause counts.
    return np.select([tripped, near & ~touched, near, touched, at_limit], [TRIPPED, SETTLED, RECOVERED, STOPPED,
                                                                           LIMITED], ASTRAY)


def read_map(path: Path) -> Map:
    """Map of a study's dataset, with the trajectories of its commands beside it."""
    import pyarrow.parquet as pq  # an extra: only who studies needs it

    table = pq.read_table(path)
    columns = {name: table[name].to_numpy() for name in table.column_names if name != "failure"}
    if not all(failure is None for failure in table["failure"].to_pylist()):
        raise MaglevError(f"{path}: some samples were not flown to their end, expected all to be")
    rows = pq.read_table(path.with_name(f"{path.stem}.trajectories.parquet"))
    time = rows["time"].to_numpy()
    commands = np.column_stack([np.abs(rows[name].to_numpy()) for name in rows.column_names
                                if name not in ("sample", "time")])
    beyond = (commands >= CURRENT_LIMIT).any(axis=1) & (time > time.max() - ENDING)
    at_limit = np.zeros(len(table), dtype=np.bool_)
    at_limit[rows["sample"].to_numpy()[beyond]] = True
    what = next(name for name in STEPS if name in columns)
    # Samples of a grid stand in the order of what varies.
    initial, target, steps, constants = (np.unique(columns[name]) for name in ("initial gap", "target gap", what,
                                                                               "constants"))
    found = outcomes(columns, at_limit).reshape(len(initial), len(target), len(steps), len(constants))
    return Map(initial, target, steps, constants, found, what)


def write_pictures(path: Path, title: str, laws: Mapping[str, Map]) -> None:
    """Write a PNG: a column for each law, a row for each step beside the gap."""
    from matplotlib.figure import Figure  # an extra: only who draws needs it
    from matplotlib.patches import Patch

    first = next(iter(laws.values()))
    rows = len(first.steps)
    figure = Figure(figsize=(2.6 * len(laws) + 0.6, 2.6 * rows + 1.2), layout="constrained")
    grid = figure.subplots(rows, len(laws), sharex=True, sharey=True, squeeze=False)
    figure.suptitle(title)
    for column, (law, found) in enumerate(laws.items()):
        for row in range(rows):
            draw(grid[row][column], found, row)
        grid[0][column].set_title(law)
        grid[-1][column].set_xlabel("target gap, mm")
    for row, step in enumerate(first.steps):
        grid[row][0].set_ylabel(f"{first.what} {first.size(step)}\ninitial gap, mm")
    handles: Sequence[Any] = [Patch(color=COLOURS[outcome], label=OUTCOMES[outcome])
                              for outcome in seen(found.nominal for found in laws.values())]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False,
                  title=f"·  {SETTLED_NOMINAL}")
    figure.savefig(path, dpi=110)


def draw(axes: "Axes", found: Map, step: int) -> None:
    """Draw the map of one step beside the gap; a dot where other constants have another end."""
    from matplotlib.colors import ListedColormap

    target, initial = 1e3 * found.target, 1e3 * found.initial
    axes.pcolormesh(target, initial, found.nominal[..., step], cmap=ListedColormap(COLOURS), vmin=-0.5,
                    vmax=len(OUTCOMES) - 0.5, edgecolors="white", linewidth=0.3)
    rows, columns = np.nonzero(found.fragile[..., step])
    axes.plot(target[columns], initial[rows], "k.", markersize=3)
    axes.set_aspect("equal")


def write_maps(path: Path, rigs: Mapping[str, RigMaps]) -> None:
    """Write maps as JSON, such as "2dof" to its maps: a text of digits, indices of "outcomes", for each initial gap.

    The texts of a law stand by what else steps and then by constants.
    """
    write_whole(path, json.dumps({"outcomes": OUTCOMES, "rigs": {rig: rig_data(maps) for rig, maps in rigs.items()}},
                                 indent=1) + "\n")


def rig_data(maps: RigMaps) -> dict[str, object]:
    """Maps of a rig as they stand in the file."""
    first = next(iter(maps.laws.values()))
    origin = maps.origin
    return {"version": origin.version, "commit": origin.commit, "guids": dict(origin.guids),
            "initial gap": lengths(first.initial), "target gap": lengths(first.target),
            first.what: lengths(first.steps), "constants": first.constants.tolist(),
            "laws": {law: texts_of(found.outcomes.transpose(2, 3, 0, 1)) for law, found in maps.laws.items()}}


def lengths(values: NDArray[np.float64]) -> list[float]:
    """Lengths in m, or tilts in rad, to nine digits, so that they read as they were set."""
    return [round(value, 9) for value in values.tolist()]
