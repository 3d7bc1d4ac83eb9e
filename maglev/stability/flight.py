"""Steps of one axis flown by the FMUs: what the limit does to the stage itself."""

from collections.abc import Mapping
from operator import attrgetter
from pathlib import Path

import numpy as np

from maglev.cosim.master import FmuSetup, Master
from maglev.errors import StabilityError
from maglev.linear.equilibrium import read_positions
from maglev.linear.parameters import Quantity, block_of
from maglev.stability.axis_loop import currents_of, rig_named
from maglev.stability.simulation import SHOWN, Response

BEFORE = 1.0            # s, at rest before the step
HELD = 1e-3             # m, error at the end that counts as held, as in the scenarios
NEAR_STOP = 0.5e-3      # m, that a flight begins away from a stop
HALVINGS = 7

Settings = Mapping[str, Quantity | bool]


class Flights:
    """Steps of one axis of a stage, flown one by one.

    A horizontal axis steps from one side of the middle to the other, so that the stops are as far away as can be; the
    vertical one steps to the gap.

    Parameters
    ----------
    rig, axis, controller : str
        As of `axis_loop`.
    gap : float or str
        Of the vertical axis, m or with a unit.
    plant, settings : mapping
        Parameters of plant and controller that differ from their start values.
    fmus : Path
        Folder with the FMUs.
    locked : bool
        Whether the gap is held by force, as the linear model of a horizontal axis has it.
    """

    def __init__(self, rig: str, axis: str, gap: Quantity, controller: str, plant: Settings, settings: Settings,
                 fmus: Path, locked: bool = False):
        self.rig, stage, _ = rig_named(rig)
        self.axis, self.vertical, self.names = axis, self.rig.vertical.name, (controller, stage)
        plant = {**plant, f"{self.vertical}.locked": True} if locked else plant
        self.middle = read_positions(stage, {self.vertical: gap})
        self.blocks = block_of(controller, settings), block_of(self.names[1], plant)
        self.given = settings, plant
        self.files = [fmus / f"{name}.fmu" for name in self.names]

    def room(self) -> tuple[float, float]:
        """Steps (m) that begin and end within the stops, downwards or to the left, and upwards or to the right."""
        stop = getattr(self.blocks[1], self.axis).stop
        if self.axis == self.vertical:
            gap = self.middle[self.axis]
            return gap + NEAR_STOP - stop.upper, gap - NEAR_STOP - stop.lower
        reach = 2.0 * (min(-stop.lower, stop.upper) - NEAR_STOP)
        return -reach, reach

    def fly(self, step: float, gains: Mapping[str, float | bool]) -> tuple[Response, bool]:
        """Response to a step (m) with antiwindup gains by their names, and whether the stage holds off its stops."""
        start = dict(self.middle)
        end = dict(self.middle)
        if self.axis == self.vertical:
            start[self.axis] -= step
        else:
            start[self.axis], end[self.axis] = -0.5 * step, 0.5 * step
        stop = getattr(self.blocks[1], self.axis).stop
        if not stop.lower < start[self.axis] < stop.upper:
            raise StabilityError(f"{self.names[1]}: a step of {self.axis} by {1e3 * step:g} mm begins at "
                                 f"{1e3 * start[self.axis]:g} mm, expected a start within {1e3 * stop.lower:g}…"
                                 f"{1e3 * stop.upper:g} mm")
        dt = self.blocks[0].sample_time
        count, before = int(round((BEFORE + SHOWN) / dt)), int(round(BEFORE / dt))
        resting = np.arange(count + 1) < before
        drives = {f"controller.{axis}.reference": np.where(resting, start[axis], end[axis]).tolist()
                  for axis in self.rig.axis_names}
        controller = {name: self.value(0, name) for name in self.given[0]} | dict(gains)
        plant = {name: self.value(1, name) for name in self.given[1]} | {
            f"{axis}.position_start": position for axis, position in start.items()}
        connections = [*((f"plant.{axis}.encoder", f"controller.{axis}.measured") for axis in self.rig.axis_names),
                       *((f"controller.{phase}_cmd", f"plant.{phase}_cmd") for phase in self.rig.phase_names)]
        with Master([FmuSetup("controller", self.files[0], controller), FmuSetup("plant", self.files[1], plant)],
                    connections, dt) as master:
            found = master.run(count * dt, drives)
        position = found.columns[f"plant.{self.axis}.position"][before:]
        current = currents_of(self.rig, self.axis)[0]
        response = Response(step, found.time[before:] - found.time[before], position - start[self.axis],
                            found.columns[f"controller.{current}_cmd"][before:])
        held = all(abs(found.columns[f"plant.{axis}.position"][-1] - end[axis]) < HELD for axis in self.rig.axis_names)
        return response, held and not found.columns["plant.at_stop"].any()

    def value(self, which: int, name: str) -> float | bool:
        """Value of a parameter as the block has read it, SI."""
        found: float | bool = attrgetter(name)(self.blocks[which])
        return found

    def largest(self, gains: Mapping[str, float | bool]) -> float:
        """Largest step, m, up to which halving finds every flight held in both directions, within the stops."""
        return min(self.largest_of(sign, reach, gains) for sign, reach in zip((-1.0, 1.0), self.room(), strict=True))

    def largest_of(self, sign: float, reach: float, gains: Mapping[str, float | bool]) -> float:
        """Largest step of one sign, m."""
        low, high = 0.0, abs(reach)
        if self.fly(sign * high, gains)[1]:
            return high
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.fly(sign * middle, gains)[1] else (low, middle)
        return low
