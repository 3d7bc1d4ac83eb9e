"""How far a law can go: maps of a study over two gaps, what else steps and constants."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

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
    STEPS,
    STOPPED,
    TRIPPED,
    Map,
    RigMaps,
)
from maglev.maps.rows import Outcomes, texts_of
from maglev_files.whole_file import write_whole

CURRENT_LIMIT = 4.0   # A, of the commands of all laws
ENDING = 1.0          # s, in which a command at its limit counts


def outcomes(columns: Mapping[str, NDArray[Any]], at_limit: NDArray[np.bool_]) -> Outcomes:
    """Outcome of each sample, an index of `OUTCOMES`, by a study's metrics and whether a command ends at its limit.

    All have the shape (samples,); of the metrics "trip time", "stop contact time", and "end error of" every axis count.
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
