"""Tolerances of laws: outcomes of runs in which two conditions get worse at a time, as maps.

Studies compute them. Those of the stages come with the package, as data that `studies/tolerances` writes.
"""

from dataclasses import dataclass

import numpy as np

from maglev.files.fmi_units import typeset_unit
from maglev.pages.grids import StageGrids
from maglev.pages.law_map import Factor, LawMap, Outcomes
from maglev.scenario.layers import PACKAGED

HOLDS, ASTRAY, STOPPED, TRIPPED = range(4)
OUTCOMES = ("holds", "ends off by more than 1 mm", "touches a stop", "trips")

FILE = PACKAGED / "studies" / "tolerances.json"   # varied are STEP, then what is down and along a map
TOOL = "python -m studies.tolerances"


@dataclass(frozen=True)
class Worse:
    """A condition that gets worse along a side of a map, from its harmless value."""

    name: str
    unit: str
    values: tuple[float, ...]   # in the unit, the harmless one first
    sets: str                   # its parameter; {} means each encoder

    def text(self, value: float) -> str:
        return "no limit" if self.sets == VOLTAGE and not value else f"{value:g} {typeset_unit(self.unit)}"

    @property
    def factor(self) -> Factor:
        return Factor(self.name, typeset_unit(self.unit), np.array(
            ["∞" if self.text(value) == "no limit" else f"{value:g}" for value in self.values]))


@dataclass(frozen=True)
class Question:
    """Two conditions that get worse together: the sides of a map."""

    name: str
    along: Worse
    down: Worse


STEP = "step of the gap, mm"
VOLTAGE = "plant.bus_voltage"

QUESTIONS = (
    Question("late-noisy",
             Worse("delay", "ms", (0, 1, 2, 4, 6, 8, 10, 12, 15), "measurement.delay"),
             Worse("noise", "um", (0, 2, 5, 10, 20, 50, 100, 200), "measurement.{}.noise")),
    Question("lost-weak",
             Worse("lost samples", "%", (0, 20, 40, 60, 80, 90, 95, 98, 99), "measurement.{}.lost"),
             Worse("bus voltage", "V", (0, 48, 24, 18, 12, 9, 6, 4), VOLTAGE)))


def about(_found: StageGrids) -> str:
    return """\
Two things get worse at a time: measurements come late and are noisy; samples are lost and the bus has little
voltage. Every controller makes a step of the air gap with them, and one of the horizontal axes or the tilts. A run
holds if no stop is touched, nothing trips, and every axis ends near its reference. The lowest row and the first
column of a map are without the one or the other."""


def maps_of(of_stage: StageGrids) -> list[list[LawMap]]:
    """Return a layer for each step of the gap, for each question and law."""
    maps = []
    for question in QUESTIONS:
        grid, asked = of_stage.grids[question.name], f"{question.down.name.capitalize()} and {question.along.name}"
        layers = Factor("with", "", np.array([f"{asked}, step of {size:g} mm" for size in grid.varied[STEP]]))
        factors = [question.down.factor, question.along.factor, layers]
        maps.append([LawMap(law, "", factors, cells) for law, cells in grid.laws.items()])
    return maps


def table(of_stage: StageGrids) -> list[tuple[str, ...]]:
    """Up to where each law holds along each side, the other being harmless, as rows of texts, the heading first."""
    sides = [(of_stage.grids[question.name], side, harmless) for question in QUESTIONS
             for side, harmless in ((question.down, np.s_[:, 0]), (question.along, np.s_[0, :]))]
    first = sides[0][0]
    return [("controller", "step of the gap", *(side.name for _, side, _ in sides))] + [
        (law, f"{size:g} mm", *(last_that_holds(grid.laws[law][k][harmless], side) for grid, side, harmless in sides))
        for law in first.laws for k, size in enumerate(first.varied[STEP])]


def last_that_holds(outcomes: Outcomes, side: Worse) -> str:
    """The worst value of a side up to which every run holds; `outcomes` are those along it."""
    held = int(np.argmax(np.append(outcomes != HOLDS, True)))
    return "—" if not held else side.text(side.values[held - 1]) + (" and worse" if held == len(outcomes) else "")
