"""Limits of each law: outcomes over initial gap, target gap, further steps and constants, as maps.

Studies compute them. Those of the stages come with the package, as data that `studies/operating_range` writes.
"""

import numpy as np

from maglev.files.arrays import Bools
from maglev.pages.grids import Grid, StageGrids
from maglev.pages.law_map import Factor, LawMap, Outcomes, seen
from maglev.scenario.layers import PACKAGED

SETTLED, RECOVERED, LIMITED, ASTRAY, TRIPPED, STOPPED = range(6)
OUTCOMES = ("settles", "settles after it touched a stop", "ends with a command at its limit",
            "does neither settle nor fail", "trips", "stays at a stop")
SETTLED_ALWAYS = "settles with all constants"
SETTLED_NOMINAL = "settles only with the constants as they are"   # what is marked in maps

NEAR = 1e-4   # m, the steady state that the specification asks for; rad of a tilt
STEPS = {"horizontal step": "mm", "tilt": "mrad"}   # what steps next to the gap, in thousandths of its SI unit

FILE = PACKAGED / "studies" / "operating_range.json"   # varied are one of STEPS, constants, initial and target gap, SI
TOOL = "python -m studies.operating_range"


def nominal(grid: Grid, law: str) -> Outcomes:
    """Return the outcomes with the nominal constants, shape (steps, initial gaps, target gaps)."""
    return np.asarray(grid.laws[law][:, np.argmin(np.abs(grid.varied["constants"] - 1.0))])


def always_settles(grid: Grid, law: str) -> Bools:
    """Return where a law settles with all constants, of the same shape."""
    return np.asarray((grid.laws[law] == SETTLED).all(axis=1))


def steps(grid: Grid) -> tuple[str, list[str]]:
    """Return the further quantity that steps, and the sizes of its steps, such as "20 mm"."""
    what = next(iter(grid.varied))
    return what, [f"{1e3 * step:g} {STEPS[what]}" for step in grid.varied[what]]


def about(of_stage: StageGrids) -> str:
    grid, = of_stage.grids.values()
    *others, last = (f"{value:g}" for value in grid.varied["constants"])
    factors = f"{', '.join(others)} and {last}" if others else last
    return f"""\
Moves from rest at one air gap to another, alone and with a step of something else: which of them
each controller can do. A move settles if every axis ends within {1e3 * NEAR:g} mm of its reference, a tilt within as
many mrad, and no stop was touched.
Each was run with all force constants of the plant times {factors}, of which the controller does not know.
The maps show the constants as they are; dotted places settle with these only."""


def maps_of(of_stage: StageGrids) -> list[list[LawMap]]:
    """Return for each law a layer for each further step; a marked outcome is one that settles only nominally."""
    grid, = of_stage.grids.values()
    what, sizes = steps(grid)
    factors = [Factor(name, "mm", np.array([f"{1e3 * gap:g}" for gap in grid.varied[name]]))
               for name in ("initial gap", "target gap")]
    factors.append(Factor("with", "", np.array([f"{what} {size}".capitalize() if step else f"No {what}"
                                                for step, size in zip(grid.varied[what], sizes, strict=True)])))
    return [[LawMap(law, "", factors, np.where((nominal(grid, law) == SETTLED) & ~always_settles(grid, law),
                                               len(OUTCOMES), nominal(grid, law)).astype(np.uint8))
             for law in grid.laws]]


def table(of_stage: StageGrids) -> list[tuple[str, ...]]:
    """Shares of the maps of all laws as rows of texts, the heading first; of outcomes those that occur."""
    grid, = of_stage.grids.values()
    what, sizes = steps(grid)
    occurring = seen(nominal(grid, law) for law in grid.laws)
    rows = [("controller", what, *(OUTCOMES[outcome] for outcome in occurring), SETTLED_ALWAYS)]
    return rows + [(law, size, *(f"{100 * np.mean(share):.0f} %" for share in (
        *(cells == outcome for outcome in occurring), always)))
        for law in grid.laws for size, cells, always in zip(sizes, nominal(grid, law), always_settles(grid, law),
                                                            strict=True)]
