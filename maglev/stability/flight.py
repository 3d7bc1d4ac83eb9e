"""Steps of one axis flown by the FMUs: what the limit does to the stage itself."""

from collections.abc import Mapping
from operator import attrgetter
from pathlib import Path

import numpy as np

from maglev.cosim.master import FmuSetup, Master
from maglev.errors import StabilityError
from maglev.linear.equilibrium import read_positions
from maglev.linear.parameters import DEFINITIONS, Quantity, block_of
from maglev.linear.places import MotorPlaces
from maglev.own_fmus import current_fmu
from maglev.own_stage.loop import loop_table
from maglev.quantities import printed
from maglev.stability.axis_loop import currents_of, rig_named
from maglev.stability.simulation import SHOWN, Response

BEFORE = 1.0            # s, at rest before the step
HELD = 1e-3             # m, error at the end that counts as held, as in the scenarios; of a tilt at the outermost motor
NEAR_STOP = 0.5e-3      # m, that a flight begins away from a stop
HALVINGS = 7

Settings = Mapping[str, Quantity | bool]


class Flights:
    """Steps of one axis of a stage, flown one by one; a context manager that frees the FMUs.

    A horizontal axis steps from one side of the middle to the other, so that the stops are as far away as can be; the
    vertical one steps to the gap, a tilt to level.

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
        self.files = [current_fmu(name, fmus) for name in self.names]
        self.centred = axis in [each.name for each in self.rig.horizontal]
        self.master: Master | None = None

    def __enter__(self) -> "Flights":
        return self

    def __exit__(self, *_: object) -> None:
        if self.master is not None:
            self.master.__exit__()
        self.master = None

    def stops(self) -> tuple[float, float, float]:
        """Where the axis meets its stops, at the motors where the platform tilts, and how near a flight may begin."""
        rig, plant, middle = self.rig, self.blocks[1], self.middle[self.axis]
        if self.centred or not rig.rotations:
            stop = getattr(plant, self.axis).stop
            return stop.lower, stop.upper, NEAR_STOP
        shares = MotorPlaces.of(rig, plant).gaps[:, rig.axis_names.index(self.axis)]
        ways = [sorted((bound - self.middle[self.vertical]) / share for bound in (stop.lower, stop.upper))
                for stop, share in zip((getattr(plant, f"{motor}_mount").stop for motor in rig.motor_names), shares,
                                       strict=True) if share != 0.0]
        return (middle + max(way[0] for way in ways), middle + min(way[1] for way in ways),
                NEAR_STOP / float(np.abs(shares).max()))

    def room(self) -> tuple[float, float]:
        """Steps (m) that begin and end within the stops, downwards or to the left, and upwards or to the right."""
        lower, upper, near = self.stops()
        if not self.centred:
            end = self.middle[self.axis]
            return end + near - upper, end - near - lower
        reach = 2.0 * (min(-lower, upper) - near)
        return -reach, reach

    def fly(self, step: float, gains: Mapping[str, float | bool]) -> tuple[Response, bool]:
        """Response to a step (m) with antiwindup gains by their names, and whether the stage holds off its stops."""
        start = dict(self.middle)
        end = dict(self.middle)
        if not self.centred:
            start[self.axis] -= step
        else:
            start[self.axis], end[self.axis] = -0.5 * step, 0.5 * step
        lower, upper, _ = self.stops()
        if not lower < start[self.axis] < upper:
            unit = self.rig.axis(self.axis).unit("m")
            size, begin, low, high = (printed(each, unit) for each in (step, start[self.axis], lower, upper))
            raise StabilityError(f"{self.names[1]}: a step of {self.axis} by {size} begins at {begin}, expected a "
                                 f"start from {low} to {high}")
        dt = self.blocks[0].sample_time
        count, before = round((BEFORE + SHOWN) / dt), round(BEFORE / dt)
        resting = np.arange(count + 1) < before
        drives = {f"controller.{axis}.reference": np.where(resting, start[axis], end[axis]).tolist()
                  for axis in self.rig.axis_names}
        if self.master is None:
            setups = [FmuSetup(part, file, {variable.name: attrgetter(variable.place)(block) for variable
                                            in DEFINITIONS[name].variables if variable.name in given})
                      for part, name, file, block, given in zip(("controller", "plant"), self.names, self.files,
                                                                self.blocks, self.given, strict=True)]
            self.master = Master(setups, loop_table(self.rig)["connections"], dt)
            self.master.wire(count * dt, drives)
        self.master.drive(drives)
        found = self.master.fly({"controller": gains, "plant": {f"{axis}.position_start": position
                                                                for axis, position in start.items()}})
        position = found.columns[f"plant.{self.axis}.position"][before:]
        current = currents_of(self.rig, self.axis)[0]
        response = Response(step, found.time[before:] - found.time[before], position - start[self.axis],
                            found.columns[f"controller.{current}_cmd"][before:].copy())
        ends = {axis.name: abs(found.columns[f"plant.{axis.name}.position"][-1] - end[axis.name])
                * (self.rig.arm if axis.rotation else 1.0) for axis in self.rig.axes}
        return response, bool(max(ends.values()) < HELD and not found.columns["plant.at_stop"].any())

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
