"""The map of outcomes over the varied quantities of a study, for the script of its page."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from maglev.files.arrays import Array
from maglev.pages.sample_commands import command_of, row_options
from maglev.pages.shell import packed_text
from maglev.pages.study_text import numbers, units_of
from maglev.scenario.quantities import shown_in

PASSES, TOUCHED, ASTRAY, TRIPPED, STOPPED, BROKEN = range(6)
OUTCOMES = ("passes", "passes after it touched a stop", "is beyond a limit", "trips", "ends at a stop",
            "is not run to its end")

TIMES = ("trip time", "stop contact time")   # columns of the times of a loss; a stage without a trip has no trip time
LEAST_CELLS = 100   # of a map; fewer have their numbers in them

Outcomes = NDArray[np.uint8]   # indices of `OUTCOMES`


@dataclass(frozen=True)
class Factor:
    """One varied quantity, along a side of a map or by its layers: its values, and the settings of a run for each."""

    name: str
    unit: str                          # SI
    values: Array                      # shape (n,)
    sets: Mapping[str, NDArray[Any]]   # by the set quantity, shape (n,)

    def shown(self) -> dict[str, Any]:
        """Return the data for the page's script, with None for a target that is set to the values themselves."""
        unit, scale = shown_in(self.values.tolist(), self.unit)
        return {"name": self.name, "unit": unit, "values": self.values.tolist(), "scale": scale, "sets": {
            target: None if values.dtype != bool and np.array_equal(values, self.values) else values.tolist()
            for target, values in self.sets.items()}}


@dataclass(frozen=True)
class LawMap:
    """Outcomes of a law: the first factor upwards, the second to the right, a layer for each value of the others."""

    name: str
    command: str                     # of a run, without what the factors set
    factors: Sequence[Factor]
    cells: Outcomes                  # shape (layers, values of the first, values of the second)


def maps_data(maps: Sequence[LawMap], words: Sequence[str]) -> dict[str, Any]:
    """Return the data to draw maps over the same values, with words for `OUTCOMES`."""
    return {"factors": [factor.shown() for factor in maps[0].factors], "outcomes": words,
            "laws": [{"name": law.name, "command": law.command, "packed": packed_text(law.cells.tobytes())}
                     for law in maps]}


def outcomes_of(table: pa.Table) -> Outcomes:
    """Outcomes of a study's samples, shape (samples,)."""
    passed = np.array(table["passed"].to_pylist(), bool)
    early = np.array([why is not None for why in table["failure"].to_pylist()])
    tripped, touched = (np.isfinite(numbers(table, name)) if name in table.column_names else np.zeros(len(passed), bool)
                        for name in TIMES)
    # A trip lets the mover fall on a stop: the first cause counts.
    return np.select([early, tripped, passed & ~touched, passed, touched],
                     [BROKEN, TRIPPED, PASSES, TOUCHED, STOPPED], ASTRAY).astype(np.uint8)


def grid_of(table: pa.Table, about: Mapping[str, Any]) -> list[Factor]:
    """Return the varied quantities of a full grid, in order; samples of a grid stand in it."""
    units, factors = units_of(table), []
    for parameter in about["vary"]:
        values, first = np.unique(numbers(table, parameter["name"]), return_index=True)
        order = np.argsort(first, kind="stable")   # of a list its own
        rows = [table.slice(int(k), 1).to_pylist()[0] for k in first[order]]
        runs = [row_options(about, row)["set"] for row in rows]
        factors.append(Factor(parameter["name"], units[parameter["name"]], values[order],
                              {target: np.array([run[target] for run in runs]) for target in parameter["set"]}))
    return factors


def map_of(table: pa.Table, about: Mapping[str, Any]) -> LawMap | None:
    """Return the map of a study: a large grid of samples with different outcomes."""
    if about["design"]["kind"] != "grid" or len(about["vary"]) < 2:
        return None
    grid = grid_of(table, about)
    sides = [len(factor.values) for factor in grid]
    # The two with most values are the sides of the map.
    order = sorted(range(len(grid)), key=lambda i: (-sides[i], i))
    down, across, *others = order
    if sides[down] * sides[across] < LEAST_CELLS or sides[across] < 2:
        return None
    outcomes = outcomes_of(table)
    if (outcomes == outcomes[0]).all():
        return None
    cells = outcomes.reshape(sides).transpose([*others, down, across]).reshape(-1, sides[down], sides[across])
    return LawMap("", command_of(about, None), [grid[i] for i in order], cells)
