"""Outcomes of runs on grids, as files that come with the package, with their origin."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from maglev.files.arrays import Array
from maglev.files.whole_file import write_whole
from maglev.pages.law_map import Outcomes


@dataclass(frozen=True)
class Origin:
    """The origin of runs: their version and commit, and the FMUs' GUIDs by model, if known."""

    version: str
    commit: str | None
    guids: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Grid:
    """Outcomes of laws at every combination of the varied quantities."""

    varied: Mapping[str, Array]     # values by name
    laws: Mapping[str, Outcomes]    # by law, shape (values of the first, values of the second, …)


@dataclass(frozen=True)
class StageGrids:
    """Grids of a stage by question, with their origin."""

    grids: Mapping[str, Grid]
    origin: Origin


def read_grids(path: Path) -> dict[str, StageGrids]:
    """Grids by stage, as `write_grids` wrote them."""
    return {stage: StageGrids({name: Grid({what: np.array(values) for what, values in grid["varied"].items()},
                                      {law: cells_of(texts) for law, texts in grid["laws"].items()})
                           for name, grid in data["grids"].items()},
                          Origin(data["version"], data["commit"], data["guids"]))
            for stage, data in json.loads(path.read_text(encoding="utf-8"))["stages"].items()}


def write_grids(path: Path, outcomes: Sequence[str], stages: Mapping[str, StageGrids]) -> None:
    """Write grids as JSON: of each law texts of digits, indices of the outcomes, along what varies last."""
    data = {stage: {**vars(of.origin), "grids": {name: {
        "varied": {what: values.tolist() for what, values in grid.varied.items()},
        "laws": {law: texts_of(cells) for law, cells in grid.laws.items()}} for name, grid in of.grids.items()}}
        for stage, of in stages.items()}
    write_whole(path, json.dumps({"outcomes": outcomes, "stages": data}, indent=1) + "\n")


def texts_of(cells: Outcomes) -> Any:
    """An array as nested lists of texts, in which the last dimension is digits."""
    return "".join(map(str, cells.tolist())) if cells.ndim == 1 else [texts_of(part) for part in cells]


def cells_of(texts: Any) -> Outcomes:
    return np.array([*map(int, texts)] if isinstance(texts, str) else [*map(cells_of, texts)], np.uint8)
