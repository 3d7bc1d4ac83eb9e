"""What laws tolerate: outcomes of runs in which two things get worse at a time, as maps.

Studies find them; those of the rigs come with the package, as data that `studies/tolerances` writes.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from maglev.maps.rows import MapRow, Origin, Outcomes, Side, cells_of
from maglev.schema.layers import PACKAGED

HOLDS, ASTRAY, STOPPED, TRIPPED = range(4)
OUTCOMES = ("holds", "ends off by more than 1 mm", "touches a stop", "trips")

FILE = PACKAGED / "studies" / "tolerances.json"
TOOL = "python -m studies.tolerances"


@dataclass(frozen=True)
class Worse:
    """What gets worse along a side of a map, from what it is without."""

    name: str
    unit: str
    values: tuple[float, ...]   # in the unit, the harmless one first
    sets: str                   # the parameter that it is; {} stands for each encoder

    def text(self, value: float) -> str:
        return "no limit" if self.sets == VOLTAGE and not value else f"{value:g} {self.printed_unit}"

    @property
    def printed_unit(self) -> str:
        return self.unit.replace("um", "µm")

    @property
    def side(self) -> Side:
        return Side(f"{self.name}, {self.printed_unit}",
                    ["∞" if self.text(value) == "no limit" else f"{value:g}" for value in self.values])


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


@dataclass(frozen=True)
class RigMaps:
    """Maps of a rig by question and law, shape (steps, down, along), of steps of the gap by sizes (mm)."""

    sizes: tuple[float, ...]
    maps: Mapping[str, Mapping[str, Outcomes]]
    origin: Origin

    @property
    def about(self) -> str:
        return """\
Two things get worse at a time: measurements come late and are noisy; samples are lost and the bus has little
voltage. Every controller makes a step of the air gap with them, and one of the horizontal axes or the tilts. A run
holds if no stop is touched, nothing trips, and every axis ends near its reference. The lowest row and the first
column of a map are without the one or the other."""

    def rows(self) -> list[MapRow]:
        """Of each question and each step of the gap."""
        return [MapRow(f"{question.down.name.capitalize()} and {question.along.name}, step of {size:g} mm",
                       question.down.side, question.along.side,
                       {law: outcomes[k] for law, outcomes in self.maps[question.name].items()})
                for question in QUESTIONS if question.name in self.maps for k, size in enumerate(self.sizes)]

    def table(self) -> list[tuple[str, ...]]:
        """Up to where each law holds along each side, the other being harmless, as rows of texts, the heading first."""
        sides = [(question.name, side, harmless) for question in QUESTIONS if question.name in self.maps
                 for side, harmless in ((question.down, np.s_[:, 0]), (question.along, np.s_[0, :]))]
        rows = [("controller", "step of the gap", *(side.name for _, side, _ in sides))]
        for law in next(iter(self.maps.values())):
            for k, size in enumerate(self.sizes):
                rows.append((law, f"{size:g} mm", *(last_that_holds(self.maps[name][law][k][harmless], side)
                                                    for name, side, harmless in sides)))
        return rows


def last_that_holds(outcomes: Outcomes, side: Worse) -> str:
    """The worst value of a side up to which every run holds; `found` has the outcomes along it."""
    held = int(np.argmax(np.append(outcomes != HOLDS, True)))
    return "—" if not held else side.text(side.values[held - 1]) + (" and worse" if held == len(outcomes) else "")


def read_tolerances(path: Path = FILE) -> dict[str, RigMaps]:
    """Maps by rig as `write_found` of `studies/tolerances` wrote them; without a path those of the package."""
    rigs = json.loads(path.read_text(encoding="utf-8"))["rigs"]
    return {name: RigMaps(tuple(rig["steps of the gap, mm"]), {
        question: {law: cells_of(texts) for law, texts in laws.items()} for question, laws in rig["maps"].items()},
        Origin(rig["version"], rig["commit"])) for name, rig in rigs.items()}
