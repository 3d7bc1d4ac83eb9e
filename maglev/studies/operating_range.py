"""How far a law can go: outcomes of a study over initial gap, target gap, horizontal step and constants, as maps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from maglev.errors import MaglevError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SETTLED, RECOVERED, LIMITED, ASTRAY, TRIPPED, STOPPED = range(6)
OUTCOMES = ("settles", "settles after it touched a stop", "ends with a command at its limit",
            "does neither settle nor fail", "trips", "stays at a stop")
COLOURS = ("#2a9d5c", "#a8d5a2", "#f4c152", "#8fa7c4", "#8e6bb0", "#c8503c")

CURRENT_LIMIT = 4.0   # A, of the commands of all laws
NEAR = 1e-4           # m, the steady state that the specification asks for
ENDING = 1.0          # s, in which a command at its limit counts
VARIED = ("initial gap", "target gap", "horizontal step", "constants")   # in this order


@dataclass(frozen=True)
class Map:
    """Outcomes of one law.

    Attributes
    ----------
    initial, target, horizontal : ndarray
        m, the gaps at the start and at the end, shapes (n,) and (m,), and the horizontal steps, shape (k,).
    constants : ndarray, shape (p,)
        Factors on the plant's constants.
    outcomes : ndarray of int, shape (n, m, k, p)
        Indices of `OUTCOMES`.
    """

    initial: NDArray[np.float64]
    target: NDArray[np.float64]
    horizontal: NDArray[np.float64]
    constants: NDArray[np.float64]
    outcomes: NDArray[np.int64]

    @property
    def nominal(self) -> NDArray[np.int64]:
        """Outcomes with the constants as they are, shape (n, m, k)."""
        return np.asarray(self.outcomes[..., np.argmin(np.abs(self.constants - 1.0))])

    @property
    def always_settles(self) -> NDArray[np.bool_]:
        """Where it settles with all constants, shape (n, m, k)."""
        return np.asarray((self.outcomes == SETTLED).all(axis=-1))


def outcomes(columns: Mapping[str, NDArray[Any]], at_limit: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Outcome of each sample.

    Parameters
    ----------
    columns : mapping of str to ndarray, shape (samples,)
        Metrics of a study: "time of trip", "time of stop contact", and "error at the end of" every axis.
    at_limit : ndarray of bool, shape (samples,)
        Whether a command ends at its limit.

    Returns
    -------
    ndarray of int, shape (samples,)
        Indices of `OUTCOMES`.
    """
    near = np.all([values <= NEAR for name, values in columns.items() if name.startswith("error at the end of ")],
                  axis=0)
    tripped, touched = (np.isfinite(columns[name]) for name in ("time of trip", "time of stop contact"))
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
    initial, target, horizontal, constants = (np.unique(columns[name]) for name in VARIED)
    # Samples of a grid stand in the order of what varies.
    found = outcomes(columns, at_limit).reshape(len(initial), len(target), len(horizontal), len(constants))
    return Map(initial, target, horizontal, constants, found)


def shares(found: Map) -> list[tuple[float, list[float], float]]:
    """Of each horizontal step (m): the share of the map of every outcome, nominal, and that which always settles."""
    return [(float(step), [float(np.mean(found.nominal[..., i] == outcome)) for outcome in range(len(OUTCOMES))],
             float(np.mean(found.always_settles[..., i]))) for i, step in enumerate(found.horizontal)]


def shares_text(laws: Mapping[str, Map]) -> str:
    """Shares of all laws as a table in Markdown."""
    lines = ["| law | horizontal step | " + " | ".join(OUTCOMES) + " | settles with all constants |",
             "|---" * (len(OUTCOMES) + 3) + "|"]
    for law, found in laws.items():
        lines += [f"| {law} | {1e3 * step:g} mm | " + " | ".join(f"{100 * each:.0f} %" for each in (*nominal, always))
                  + " |" for step, nominal, always in shares(found)]
    return "\n".join(lines)


def write_maps(path: Path, title: str, laws: Mapping[str, Map]) -> None:
    """Write a PNG: a column for each law, a row for each horizontal step."""
    from matplotlib.figure import Figure  # an extra: only who draws needs it
    from matplotlib.patches import Patch

    rows = len(next(iter(laws.values())).horizontal)
    figure = Figure(figsize=(2.6 * len(laws) + 0.6, 2.6 * rows + 1.2), layout="constrained")
    grid = figure.subplots(rows, len(laws), sharex=True, sharey=True, squeeze=False)
    figure.suptitle(title)
    for column, (law, found) in enumerate(laws.items()):
        for row in range(rows):
            draw(grid[row][column], found, row)
        grid[0][column].set_title(law)
        grid[-1][column].set_xlabel("target gap, mm")
    for row, step in enumerate(next(iter(laws.values())).horizontal):
        grid[row][0].set_ylabel(f"horizontal step {1e3 * step:g} mm\ninitial gap, mm")
    seen = sorted({int(outcome) for found in laws.values() for outcome in np.unique(found.nominal)})
    handles: Sequence[Any] = [Patch(color=COLOURS[outcome], label=OUTCOMES[outcome]) for outcome in seen]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False,
                  title="·  settles only with the constants as they are")
    figure.savefig(path, dpi=110)


def draw(axes: "Axes", found: Map, step: int) -> None:
    """Draw the map of one horizontal step; a dot where other constants have another end."""
    from matplotlib.colors import ListedColormap

    target, initial = 1e3 * found.target, 1e3 * found.initial
    axes.pcolormesh(target, initial, found.nominal[..., step], cmap=ListedColormap(COLOURS), vmin=-0.5,
                    vmax=len(OUTCOMES) - 0.5, edgecolors="white", linewidth=0.3)
    fragile = (found.nominal[..., step] == SETTLED) & ~found.always_settles[..., step]
    rows, columns = np.nonzero(fragile)
    axes.plot(target[columns], initial[rows], "k.", markersize=3)
    axes.set_aspect("equal")
