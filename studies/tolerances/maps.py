"""What became of flights in which two things get worse: outcomes as maps, and up to where all of them hold."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.errors import MaglevError
from maglev.maps.rows import Outcomes, texts_of
from maglev.maps.tolerances import (
    ASTRAY,
    HOLDS,
    OUTCOMES,
    QUESTIONS,
    STOPPED,
    TRIPPED,
    Question,
    RigMaps,
    Worse,
)
from maglev.studies.page.text import units_of
from maglev_files.whole_file import write_whole

FAR, TILTED = 1e-3, 5e-3   # m; rad of a tilt: as `fail_error` and `fail_tilt` of scenarios


def outcomes(columns: Mapping[str, NDArray[Any]], tilts: tuple[str, ...]) -> Outcomes:
    """Outcome of each sample by a study's metrics, shape (samples,), some axes being tilts; the first cause counts.

    These are "trip time", "stop contact time", and "end error of" every axis.
    """
    far = np.any([~(values <= (TILTED if name.removeprefix("end error of ") in tilts else FAR))
                  for name, values in columns.items() if name.startswith("end error of ")], axis=0)
    tripped, touched = columns["trip time"], columns["stop contact time"]
    return np.select([np.isfinite(tripped) & (tripped <= touched), np.isfinite(touched), far],
                     [TRIPPED, STOPPED, ASTRAY], HOLDS)


def read_outcomes(path: Path, question: Question) -> Outcomes:
    """Outcomes in a study's dataset; what the sides vary over has to be there once for each step."""
    import pyarrow.parquet as pq  # an extra: only who studies needs it

    table = pq.read_table(path)
    columns = {name: table[name].to_numpy() for name in table.column_names if name != "failure"}
    tilts = tuple(name.removeprefix("end error of ") for name, unit in units_of(table).items()
                  if name.startswith("end error of ") and unit == "rad")
    found = outcomes(columns, tilts)
    # A flight that its FMUs ended, by running away, was beyond a stop before.
    found[[failure is not None for failure in table["failure"].to_pylist()]] = STOPPED
    shape = len(question.down.values), len(question.along.values)
    if len(found) % (shape[0] * shape[1]):
        raise MaglevError(f"{path}: {len(found)} samples, expected {shape[0]} by {shape[1]} for each step")
    order = np.lexsort([place(columns[question.along.name], question.along),
                        place(columns[question.down.name], question.down), -columns["target gap"]])
    return np.asarray(found[order].reshape(-1, *shape))


def place(values: NDArray[np.float64], side: Worse) -> NDArray[np.int64]:
    """Where values of a column (SI) lie along a side."""
    factor = {"ms": 1e3, "um": 1e6, "%": 1e2, "V": 1.0}[side.unit]
    return np.asarray(np.argmin(np.abs(factor * values[:, None] - np.array(side.values)), axis=1))


def write_found(path: Path, rigs: Mapping[str, RigMaps]) -> None:
    """Write maps as JSON: a text of digits, indices of "outcomes", for each value down a map."""
    data = {name: {"version": rig.origin.version, "commit": rig.origin.commit, "steps of the gap, mm": rig.sizes,
                   "maps": {question: {law: texts_of(found) for law, found in laws.items()}
                            for question, laws in rig.maps.items()}} for name, rig in rigs.items()}
    sides = {question.name: {side: {"name": worse.name, "unit": worse.unit, "values": worse.values}
                             for side, worse in (("down", question.down), ("along", question.along))}
             for question in QUESTIONS}
    write_whole(path, json.dumps({"outcomes": OUTCOMES, "sides": sides, "rigs": data}, indent=1) + "\n")
