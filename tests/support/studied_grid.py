"""A study that fails from a value on, as its dataset and its description, without running."""

from typing import Any

import numpy as np
import pyarrow as pa

ABOUT: dict[str, Any] = {
    "name": "study", "title": "<b>odd</b>", "description": "", "scenario": "tiny", "correlated": [], "limits": {},
    "design": {"kind": "saltelli", "samples": 1024, "seed": 1}, "targets": ["plant.a", "plant.b"],
    "vary": [{"name": "plant.a", "set": ["plant.a"]}, {"name": "plant.b", "set": ["plant.b"]}],
    "run": {"scenario": "tiny.toml", "set": {}, "options": {}},
    "provenance": {"version": "0", "commit": None, "python": "3", "fmus": [], "changes": []}}
GRID = np.array([[a, b] for a in (1.0, 2.0, 3.0, 4.0) for b in (0.5, 0.7, 1.5)])


def table(values: np.ndarray[Any, Any], points: np.ndarray[Any, Any], failure: str | None = None) -> pa.Table:
    number = len(values)
    roles = {"plant.a": b"varied", "plant.b": b"varied", "overshoot of v": b"metric"}
    columns = {"sample": range(number), "plant.a": points[:, 0], "plant.b": points[:, 1], "overshoot of v": values,
               "failed": [False] * number, "passed": [True] * number,
               "ending": ["did not complete: " + failure if failure else "completed"] + ["completed"] * (number - 1),
               "failure": pa.array([failure] + [None] * (number - 1), pa.string())}
    made = pa.table(columns)
    return made.cast(pa.schema([field.with_metadata({b"unit": b"", b"role": roles.get(field.name, b"")})
                                for field in made.schema]))


def broken_at(points: np.ndarray[Any, Any] = GRID) -> tuple[pa.Table, dict[str, Any]]:
    """A grid that fails where a is 3 and more, whatever b is, and its description."""
    made = table(points[:, 0] / 10.0, points)
    made = made.set_column(made.schema.get_field_index("passed"), "passed", pa.array((points[:, 0] < 3.0).tolist()))
    return made, {**ABOUT, "design": {"kind": "grid"}, "limits": {"overshoot of v": {"min": None, "max": 0.25}}}
