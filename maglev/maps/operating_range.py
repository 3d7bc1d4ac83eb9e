"""How far each law can go: outcomes over initial gap, target gap, what else steps and constants, as maps.

Studies find them; those of the rigs come with the package, as data that `studies/operating_range` writes.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from maglev.arrays import Array, Bools
from maglev.maps.rows import MapRow, Origin, Outcomes, Side, cells_of, seen
from maglev.schema.layers import PACKAGED

SETTLED, RECOVERED, LIMITED, ASTRAY, TRIPPED, STOPPED = range(6)
OUTCOMES = ("settles", "settles after it touched a stop", "ends with a command at its limit",
            "does neither settle nor fail", "trips", "stays at a stop")
SETTLED_ALWAYS = "settles with all constants"
SETTLED_NOMINAL = "settles only with the constants as they are"

NEAR = 1e-4   # m, the steady state that the specification asks for; rad of a tilt
STEPS = {"horizontal step": "mm", "tilt": "mrad"}   # what steps beside the gap, in thousandths of its SI unit

FILE = PACKAGED / "studies" / "operating_range.json"
TOOL = "python -m studies.operating_range"


@dataclass(frozen=True)
class Map:
    """Outcomes of one law."""

    initial: Array                   # gaps at the start, m, shape (n,)
    target: Array                    # gaps at the end, m, shape (m,)
    steps: Array                     # what else steps, m or rad, shape (k,)
    constants: Array                 # factors on the plant's constants, shape (p,)
    outcomes: Outcomes               # indices of `OUTCOMES`, shape (n, m, k, p)
    what: str = "horizontal step"    # what else steps, of `STEPS`

    def size(self, step: float) -> str:
        """A step of what else steps as text, such as "20 mm"."""
        return f"{1e3 * step:g} {STEPS[self.what]}"

    @property
    def nominal(self) -> Outcomes:
        """Outcomes with the constants as they are, shape (n, m, k)."""
        return np.asarray(self.outcomes[..., np.argmin(np.abs(self.constants - 1.0))])

    @property
    def always_settles(self) -> Bools:
        """Where it settles with all constants, shape (n, m, k)."""
        return np.asarray((self.outcomes == SETTLED).all(axis=-1))

    @property
    def fragile(self) -> Bools:
        """Where it settles with the constants as they are, but not with all, shape (n, m, k)."""
        return np.asarray((self.nominal == SETTLED) & ~self.always_settles)


@dataclass(frozen=True)
class RigMaps:
    """Maps of a rig by law, on one grid, and what they rest on."""

    laws: Mapping[str, Map]
    origin: Origin

    @property
    def about(self) -> str:
        *others, last = (f"{value:g}" for value in next(iter(self.laws.values())).constants)
        factors = f"{', '.join(others)} and {last}" if others else last
        return f"""\
Moves from rest at one air gap to another, alone and with a step of something else: which of them
each controller can do. A move settles if every axis ends within {1e3 * NEAR:g} mm of its reference, a tilt within as
many mrad, and no stop was touched.
Each was run with all force constants of the plant times {factors}, of which the controller does not know.
The maps show the constants as they are; dotted is what settles with these only."""

    def rows(self) -> list[MapRow]:
        """Of each step beside the gap, with dots on what other constants do not let settle."""
        first = next(iter(self.laws.values()))
        down, along = (Side(f"{name} gap, mm", [f"{1e3 * gap:g}" for gap in gaps])
                       for name, gaps in (("initial", first.initial), ("target", first.target)))
        return [MapRow(f"{first.what} {first.size(step)}".capitalize() if step else f"No {first.what}", down, along,
                       {law: outcome_map.nominal[..., k] for law, outcome_map in self.laws.items()},
                       {law: outcome_map.fragile[..., k] for law, outcome_map in self.laws.items()})
                for k, step in enumerate(first.steps)]

    def table(self) -> list[tuple[str, ...]]:
        """Shares of all laws as rows of texts, the heading first; of outcomes those that occur."""
        occurring = seen(outcome_map.nominal for outcome_map in self.laws.values())
        rows = [("controller", next(iter(self.laws.values())).what, *(OUTCOMES[outcome] for outcome in occurring),
                 SETTLED_ALWAYS)]
        return rows + [(law, outcome_map.size(step), *(f"{100 * nominal[outcome]:.0f} %" for outcome in occurring),
                        f"{100 * always:.0f} %")
                       for law, outcome_map in self.laws.items() for step, nominal, always in shares(outcome_map)]


def shares(outcome_map: Map) -> list[tuple[float, list[float], float]]:
    """Of each step beside the gap (m or rad): the map's share of every outcome, nominal, and what always settles."""
    return [(float(step), [float(np.mean(outcome_map.nominal[..., i] == outcome)) for outcome in range(len(OUTCOMES))],
             float(np.mean(outcome_map.always_settles[..., i]))) for i, step in enumerate(outcome_map.steps)]


def read_maps(path: Path = FILE) -> dict[str, RigMaps]:
    """Maps by rig as `write_maps` of `studies/operating_range` wrote them; without a path those of the package."""
    return {rig: RigMaps({law: map_of(data, texts) for law, texts in data["laws"].items()},
                         Origin(data["version"], data["commit"], data["guids"]))
            for rig, data in json.loads(path.read_text(encoding="utf-8"))["rigs"].items()}


def map_of(data: Mapping[str, list[float]], texts: list[list[list[str]]]) -> Map:
    """Map of a law from its texts and the grid of its rig."""
    what = next(name for name in STEPS if name in data)
    initial, target, steps, constants = (np.array(data[name]) for name in ("initial gap", "target gap", what,
                                                                           "constants"))
    return Map(initial, target, steps, constants, cells_of(texts).transpose(2, 3, 0, 1), what)
