"""What maps of every kind are to who draws them: rows of them, a law in each column; and digits, as files have them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from maglev.arrays import Bools

Outcomes = NDArray[np.int64]   # indices of the outcomes of a kind


class Side(NamedTuple):
    """A side of a map: what it is, with its unit, and the label of each row or column, that of the lowest row first."""

    title: str
    labels: list[str]


@dataclass(frozen=True)
class MapRow:
    """Maps of every law that are drawn beside each other."""

    heading: str                    # what was asked of the laws
    down: Side
    along: Side
    cells: Mapping[str, Outcomes]   # outcomes by law, shape (down, along)
    # Cells that are marked, by law, shape (down, along)
    dots: Mapping[str, Bools] = field(default_factory=dict)


@dataclass(frozen=True)
class Origin:
    """What maps rest on: version and commit that ran them, the FMUs' GUIDs by model, where they are kept."""

    version: str
    commit: str | None
    guids: Mapping[str, str] = field(default_factory=dict)


def seen(maps: Iterable[Outcomes]) -> list[int]:
    return sorted({int(outcome) for cells in maps for outcome in np.unique(cells)})


def texts_of(cells: Outcomes) -> Any:
    """An array as nested lists of texts, in which the last dimension is digits."""
    return "".join(map(str, cells.tolist())) if cells.ndim == 1 else [texts_of(part) for part in cells]


def cells_of(texts: Any) -> Outcomes:
    return np.array([*map(int, texts)] if isinstance(texts, str) else [*map(cells_of, texts)])
