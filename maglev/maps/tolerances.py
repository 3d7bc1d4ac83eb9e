"""What laws tolerate: outcomes of flights in which two things get worse at a time, as maps.

Studies find them; those of the rigs come with the package, as data that `studies/tolerances` writes.
"""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from maglev.schema.layers import PACKAGED

HOLDS, ASTRAY, STOPPED, TRIPPED = range(4)
OUTCOMES = ("holds", "ends off by more than 1 mm", "touches a stop", "trips")

FILE = PACKAGED / "studies" / "tolerances.json"
TOOL = "python -m studies.tolerances"


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


def last_that_holds(found: NDArray[np.int64], side: Worse) -> str:
    """The worst value of a side up to which every flight holds, of those flown; `found` has the outcomes along it."""
    held = int(np.argmax(np.append(found != HOLDS, True)))
    return "—" if not held else side.text(side.values[held - 1]) + (" and worse" if held == len(found) else "")


def limits_table(rig: RigMaps) -> list[tuple[str, ...]]:
    """Up to where each law holds along each side, the other being harmless, as rows of texts, the heading first."""
    sides = [(question, side) for question in QUESTIONS if question.name in rig.maps
             for side in (question.down, question.along)]
    rows = [("law", "step of the gap", *(side.name for _, side in sides))]
    for law in next(iter(rig.maps.values())):
        for k, size in enumerate(rig.sizes):
            rows.append((law, f"{size:g} mm", *(last_that_holds(
                rig.maps[question.name][law][k][:, 0] if side is question.down else rig.maps[question.name][law][k][0],
                side) for question, side in sides)))
    return rows


def seen(rigs: Iterable[RigMaps]) -> list[int]:
    """Outcomes that occur in maps."""
    return sorted({int(outcome) for rig in rigs for laws in rig.maps.values() for found in laws.values()
                   for outcome in np.unique(found)})


def read_tolerances(path: Path = FILE) -> dict[str, RigMaps]:
    """Maps by rig as `write_found` of `studies/tolerances` wrote them; without a path those of the package."""
    rigs = json.loads(path.read_text(encoding="utf-8"))["rigs"]
    return {name: RigMaps(tuple(rig["steps of the gap, mm"]), {
        question: {law: np.array([[[int(digit) for digit in row] for row in of_step] for of_step in texts])
                   for law, texts in laws.items()} for question, laws in rig["maps"].items()},
        rig["version"], rig["commit"]) for name, rig in rigs.items()}
