"""References that a stage cannot follow because of its stops: they raise an error before a run."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError
from maglev.linear.places import MotorPlaces
from maglev.scenario.run_plan import RunPlan
from pmlsm.stage_description import StageDescription

Start = Callable[[str], float | None]   # start value of a variable `fmu.variable`; None where there is none


def require_reachable(plan: RunPlan, times: Array, references: Mapping[str, Array], start: Start) -> None:
    """Refuse references that are known before the run, (n,), SI, if they go beyond the end stops of the stage.

    `start` has the initial positions of the plant, and its stops. ScenarioError with the file, the reference, its first
    value that is out of reach and its time, the stops, and the initial position.
    """
    known = {axis.position: references[axis.reference] for axis in plan.axes.values() if axis.reference in references}
    vertical = next((axis.position for axis in plan.axes.values() if axis.vertical), None)
    begin = None if vertical is None else start(f"{vertical.rpartition('.')[0]}.position_start")
    gap = "" if begin is None else f", for a stage that begins with a gap of {in_mm(begin)}"
    for name, axis in plan.axes.items():
        if axis.position in known:
            place = axis.position.rpartition(".")[0]
            require_between(f"{plan.source}: reference of {name}", times, known[axis.position], place, start, gap)
    stage = plan.stage
    if stage is not None and stage.rotations and f"plant.{stage.vertical.name}.position" in known:
        # If tilts are not known, the platform counts as level: in a tilted one, one of its motors would only be further
        # out.
        positions = np.array([known.get(f"plant.{axis}.position", np.zeros(len(times))) for axis in stage.axis_names])
        for motor, gaps in zip(stage.motor_names, gaps_of(stage, start) @ positions, strict=True):
            place = f"{plan.source}: gap at {motor} by the references"
            require_between(place, times, gaps, f"plant.{motor}", start, gap)


def gaps_of(stage: StageDescription, start: Start) -> Array:
    """Derivatives of the motors' gaps with respect to the positions, shape (motors, axes), with motors as in a run."""
    spots = []
    for motor in stage.motors:
        x, z = start(f"plant.{motor.name}.x"), start(f"plant.{motor.name}.z")
        spots.append(replace(motor, x=motor.x if x is None else x, z=motor.z if z is None else z))
    return MotorPlaces.at(stage, spots, stage.height).gaps


def require_between(what: str, times: Array, values: Array, place: str, start: Start, gap: str) -> None:
    """Refuse values (m) beyond the stops that a plant has at a place, `fmu.place`."""
    lower, upper = start(f"{place}.stop.lower"), start(f"{place}.stop.upper")
    if lower is None or upper is None:
        return
    beyond = np.flatnonzero((values < lower) | (values > upper))
    if len(beyond):
        k = int(beyond[0])
        raise ScenarioError(f"{what} = {in_mm(float(values[k]))} at t = {times[k]:g} s: out of reach, expected "
                            f"between the stops at {in_mm(lower)} and {in_mm(upper)}{gap}")


def in_mm(value: float) -> str:
    return f"{1e3 * value:g} mm"
