"""What became of flights in which two things get worse: outcomes as maps, and up to where all of them hold."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.errors import MaglevError
from maglev_files.whole_file import write_whole

FOUND = Path(__file__).with_name("found.json")

HOLDS, ASTRAY, STOPPED, TRIPPED = range(4)
OUTCOMES = ("holds", "ends off by more than 1 mm", "touches a stop", "trips")
FAR, TILTED = 1e-3, 5e-3   # m; rad of a tilt: as `fail_error` and `fail_tilt` of scenarios


@dataclass(frozen=True)
class Worse:
    """What gets worse along a side of a map, from what it is without.

    Attributes
    ----------
    name, unit : str
    values : tuple of float
        In the unit, the harmless one first.
    sets : str
        The parameter that it is; {} stands for each encoder.
    """

    name: str
    unit: str
    values: tuple[float, ...]
    sets: str

    def text(self, value: float) -> str:
        """A value as a table has it."""
        unit = self.unit.replace("um", "µm")
        return "no limit" if self.sets == VOLTAGE and not value else f"{value:g} {unit}"


@dataclass(frozen=True)
class Question:
    """Two things that get worse together: the sides of a map."""

    name: str
    along: Worse
    down: Worse


VOLTAGE = "plant.bus_voltage"

QUESTIONS = (
    Question("late-noisy",
             Worse("delay", "ms", (0, 1, 2, 4, 6, 8, 10, 12, 15), "measurement.delay"),
             Worse("noise", "um", (0, 2, 5, 10, 20, 50, 100, 200), "measurement.{}.noise")),
    Question("lost-weak",
             Worse("lost samples", "%", (0, 20, 40, 60, 80, 90, 95, 98, 99), "measurement.{}.lost"),
             Worse("bus voltage", "V", (0, 48, 24, 18, 12, 9, 6, 4), VOLTAGE)))

Outcomes = NDArray[np.int64]   # of `OUTCOMES`, shape (steps, down, along)


@dataclass(frozen=True)
class RigMaps:
    """Maps of a rig by question and law, of steps of the gap by sizes (mm), with version and commit that flew them."""

    sizes: tuple[float, ...]
    maps: Mapping[str, Mapping[str, Outcomes]]
    version: str
    commit: str | None


def outcomes(columns: Mapping[str, NDArray[Any]], tilts: tuple[str, ...]) -> Outcomes:
    """Outcome of each sample of a study by its metrics, shape (samples,); the first cause counts.

    Parameters
    ----------
    columns : mapping of str to ndarray, shape (samples,)
        "trip time", "stop contact time", and "end error of" every axis.
    tilts : tuple of str
        Axes that are rotations.
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
    units = {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in table.schema}
    tilts = tuple(name.removeprefix("end error of ") for name, unit in units.items()
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


def last_that_holds(found: NDArray[np.int64], side: Worse) -> str:
    """The worst value of a side up to which every flight holds, of those flown; `found` has the outcomes along it."""
    held = int(np.argmax(np.append(found != HOLDS, True)))
    return "—" if not held else side.text(side.values[held - 1]) + (" and worse" if held == len(found) else "")


def table(rig: RigMaps) -> str:
    """Up to where each law holds along each side, the other one being harmless, in Markdown."""
    sides = [(question, side) for question in QUESTIONS if question.name in rig.maps
             for side in (question.down, question.along)]
    lines = ["| law | step of the gap | " + " | ".join(side.name for _, side in sides) + " |",
             "|---|---|" + "---:|" * len(sides)]
    for law in next(iter(rig.maps.values())):
        for k, size in enumerate(rig.sizes):
            cells = [last_that_holds(found[:, 0] if side is question.down else found[0], side)
                     for question, side in sides for found in [rig.maps[question.name][law][k]]]
            lines.append(f"| {law} | {size:g} mm | {' | '.join(cells)} |")
    return "\n".join(lines)


def write_found(path: Path, rigs: Mapping[str, RigMaps]) -> None:
    """Write maps as JSON: a text of digits, indices of "outcomes", for each value down a map."""
    data = {name: {"version": rig.version, "commit": rig.commit, "steps of the gap, mm": rig.sizes, "maps": {
        question: {law: [["".join(map(str, row)) for row in of_step] for of_step in found.tolist()]
                   for law, found in laws.items()} for question, laws in rig.maps.items()}}
            for name, rig in rigs.items()}
    sides = {question.name: {side: {"name": worse.name, "unit": worse.unit, "values": worse.values}
                             for side, worse in (("down", question.down), ("along", question.along))}
             for question in QUESTIONS}
    write_whole(path, json.dumps({"outcomes": OUTCOMES, "sides": sides, "rigs": data}, indent=1) + "\n")


def read_found(path: Path = FOUND) -> dict[str, RigMaps]:
    """Maps by rig as `write_found` wrote them."""
    rigs = json.loads(path.read_text(encoding="utf-8"))["rigs"]
    return {name: RigMaps(tuple(rig["steps of the gap, mm"]), {
        question: {law: np.array([[[int(digit) for digit in row] for row in of_step] for of_step in texts])
                   for law, texts in laws.items()} for question, laws in rig["maps"].items()},
        rig["version"], rig["commit"]) for name, rig in rigs.items()}
