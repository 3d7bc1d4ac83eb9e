"""Steps of one axis run by the FMUs: what the limit does to the stage itself."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from maglev.analysis.pair import Settings
from maglev.errors import StabilityError
from maglev.experiment.preparation import prepare
from maglev.linear.equilibrium import read_positions
from maglev.linear.parameters import Quantity, block_of
from maglev.linear.places import MotorPlaces
from maglev.own_stage.loop import loop_table
from maglev.quantities import printed
from maglev.schema.loading import load_plan
from maglev.stability.axis_loop import currents_of, rig_named
from maglev.stability.simulation import SHOWN, Response
from maglev.studies.flying.flight import Flight

BEFORE = 1.0            # s, at rest before the step
HELD = 1e-3             # m, error at the end that counts as held, as in the scenarios; of a tilt at the outermost motor
NEAR_STOP = 0.5e-3      # m, that a run begins away from a stop
HALVINGS = 7


class Flights(Flight):
    """Steps of one axis of a stage, run one by one; a context manager that frees the FMUs.

    A horizontal axis steps from one side of the middle to the other, so that the stops are as far away as can be; the
    vertical one steps to the gap (m or with a unit), a tilt to level. With `locked` the gap is held by force, as the
    linear model of a horizontal axis has it. `plant` and `settings` are parameters of plant and controller.
    """

    def __init__(self, rig: str, axis: str, gap: Quantity, controller: str, plant: Settings, settings: Settings,
                 fmus: Path, locked: bool = False):
        self.rig, self.stage, _ = rig_named(rig)
        self.axis, self.vertical = axis, self.rig.vertical.name
        plant = {**plant, f"{self.vertical}.locked": True} if locked else plant
        self.middle = read_positions(self.stage, {self.vertical: gap})
        self.plant, dt = block_of(self.stage, plant), block_of(controller, settings).sample_time
        self.centred = axis in [axis.name for axis in self.rig.horizontal]
        self.before, count = round(BEFORE / dt), round((BEFORE + SHOWN) / dt)
        self.command = f"controller.{currents_of(self.rig, axis)[0]}_cmd"
        table = loop_table(self.rig) | {
            "name": "region", "title": "Steps of one axis", "step": dt, "output_interval": dt, "stop_time": count * dt,
            "fmus": {"controller": {"model": controller, "start": settings},
                     "plant": {"model": self.stage, "start": plant}},
            "signals": [{"to": f"controller.{name}.reference", "kind": "steps", "times": [0.0, self.before * dt],
                         "values": [position, position]} for name, position in self.middle.items()]}
        experiment = prepare(load_plan(table), fmus, {}, {})
        experiment.require_current()
        super().__init__(experiment, {*(f"plant.{name}.position" for name in self.rig.axis_names), self.command,
                                      "plant.at_stop"})

    def stops(self) -> tuple[float, float, float]:
        """Where the axis meets its stops, at the motors where the platform tilts, and how near a run may begin."""
        rig, plant, middle = self.rig, self.plant, self.middle[self.axis]
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

    def respond(self, step: float, gains: Mapping[str, float | bool]) -> tuple[Response, bool]:
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
            size, begin, low, high = (printed(value, unit) for value in (step, start[self.axis], lower, upper))
            raise StabilityError(f"{self.stage}: a step of {self.axis} by {size} begins at {begin}, expected a "
                                 f"start from {low} to {high}")
        changes: dict[str, float | bool] = {f"controller.{name}": gain for name, gain in gains.items()}
        for axis in self.middle:
            changes |= {f"plant.{axis}.position_start": start[axis], f"reference.{axis}.start": start[axis],
                        f"reference.{axis}.end": end[axis]}
        time, columns = self.fly(changes)
        shown = slice(self.before, None)
        response = Response(step, time[shown] - time[self.before],
                            columns[f"plant.{self.axis}.position"][shown] - start[self.axis],
                            columns[self.command][shown].copy())
        ends = {axis.name: abs(columns[f"plant.{axis.name}.position"][-1] - end[axis.name])
                * (self.rig.arm if axis.rotation else 1.0) for axis in self.rig.axes}
        return response, bool(max(ends.values()) < HELD and not columns["plant.at_stop"].any())

    def largest(self, gains: Mapping[str, float | bool]) -> float:
        """Largest step, m, up to which halving finds every run held in both directions, within the stops."""
        return min(self.largest_of(sign, reach, gains) for sign, reach in zip((-1.0, 1.0), self.room(), strict=True))

    def largest_of(self, sign: float, reach: float, gains: Mapping[str, float | bool]) -> float:
        """Largest step of one sign, m."""
        low, high = 0.0, abs(reach)
        if self.respond(sign * high, gains)[1]:
            return high
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.respond(sign * middle, gains)[1] else (low, middle)
        return low
