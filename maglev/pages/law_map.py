"""A map of the outcomes of runs over two varied quantities, for a script of pages and for pictures: one for each law.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.pages.shell import packed_text
from maglev.scenario.quantities import shown_in

Outcomes = NDArray[np.uint8]   # indices of the words of a kind of maps


@dataclass(frozen=True)
class Factor:
    """One varied quantity, along a side of a map or by its layers: its values, and the settings of a run for each."""

    name: str
    unit: str                  # SI, or that of texts
    values: NDArray[Any]       # numbers or texts, shape (n,)
    sets: Mapping[str, NDArray[Any]] = field(default_factory=dict)   # by the set quantity, shape (n,)

    def shown(self) -> dict[str, Any]:
        """Return the data for the page's script, with None for a target that is set to the values themselves."""
        unit, scale = shown_in(self.values.tolist(), self.unit) if self.values.dtype.kind == "f" else (self.unit, 1.0)
        return {"name": self.name, "unit": unit, "values": self.values.tolist(), "scale": scale, "sets": {
            target: None if values.dtype != bool and np.array_equal(values, self.values) else values.tolist()
            for target, values in self.sets.items()}}


@dataclass(frozen=True)
class LawMap:
    """Outcomes of a law: the first factor upwards, the second to the right, a layer for each value of the others."""

    name: str
    command: str                     # of a run, without what the factors set; empty if there is none
    factors: Sequence[Factor]
    cells: Outcomes                  # shape (layers, values of the first, values of the second)


def maps_data(maps: Sequence[LawMap], words: Sequence[str]) -> dict[str, Any]:
    """Return the data to draw maps over the same values."""
    return {"factors": [factor.shown() for factor in maps[0].factors], "outcomes": words,
            "laws": [{"name": law.name, "command": law.command, "packed": packed_text(law.cells.tobytes())}
                     for law in maps]}


def seen(maps: Iterable[Outcomes]) -> list[int]:
    return sorted({int(outcome) for cells in maps for outcome in np.unique(cells)})
