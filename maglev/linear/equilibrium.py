"""Equilibria of a stage: the currents that hold it at a gap, and whether its amplifiers can."""

from collections.abc import Mapping
from math import hypot, sqrt
from typing import Any

import numpy as np
from scipy.linalg import null_space

from controller_fmu.motor_layout import MotorLayout
from controller_fmu.pid import PID
from maglev.descriptions.registry import known_stages
from maglev.files.arrays import Array
from maglev.files.errors import LinearModelError, one_of, require_table
from maglev.files.units import parse_quantity, refused_as
from maglev.linear.model import Equilibrium
from maglev.linear.parameters import Quantity, block_of, controllers, linear_names, linear_stage, regulator_in
from maglev.linear.places import MotorPlaces
from maglev.linear.plant_model import BALANCED, at_rest, moved
from plant_fmu.stage import Stage
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.stage_description import StageDescription

ITERATIONS = 20              # more than Newton's method takes where there is one


def equilibrium(name: str, at: Mapping[str, Quantity], parameters: Mapping[str, Quantity | bool] | None = None
                ) -> Equilibrium:
    """Find the equilibrium of a stage, or of the stage as a controller models it, at given positions.

    The horizontal rows give i_q, against the bias; the vertical one then i_d, the same in all motors: the smaller root
    of (4.12), (5.7). Where the platform tilts, i_d changes evenly over it, so that the torques balance too. A regulator
    that linearises each motor at its own gap changes the normal forces evenly instead, see `linearise_loop`. Friction
    holds nothing, ripple, the modulation of the attraction, guides against a tilt and a payload count. A controller's
    model has none of these, and no bias.

    For names, positions and parameters see `linearise`. LinearModelError if an axis or a parameter is unknown, the gap
    is outside 8…40 mm or beyond a stop, or no current holds the mover there. Also if the amplifiers cannot hold that
    current, or the controller does not command it.
    """
    return equilibrium_of(name, block_of(name, parameters or {}), read_positions(name, at))


def equilibrium_of(name: str, block: Any, positions: dict[str, float], split: Any = None) -> Equilibrium:
    """Find the equilibrium of a block at the positions of its axes (m); see `equilibrium`.

    With a `split` that is a stage whose normal forces change evenly over a platform that tilts; without one the direct
    currents do.
    """
    stage = linear_stage(name)
    place = f"{name} at {', '.join(spelled(stage, positions, stage.vertical.name))}"
    places = MotorPlaces.of(stage, block)
    check_gaps(place, stage, block, places, positions)
    if name in controllers():
        equilibrium = solve(place, stage, modelled(stage, block), places, positions, split or model_of(name, block))
        check_limit(place, block, equilibrium)
        return equilibrium
    for (axis_name, position), text in zip(positions.items(), spelled(stage, positions, *positions), strict=True):
        axis = block.axes[stage.axis_number(axis_name)]
        if axis.locked:
            raise LinearModelError(f"{name}: {axis_name}.locked = true, expected an axis that is free to move")
        if axis.stop.touched(position):
            raise LinearModelError(f"{name} at {text}: beyond the end stops, expected "
                                   f"{axis_name} within {1e3 * axis.stop.lower:g}…{1e3 * axis.stop.upper:g} mm")
    equilibrium = solve(place, stage, block, places, positions, split)
    check_amplifiers(place, block, equilibrium)
    return equilibrium


def spelled(stage: StageDescription, positions: Mapping[str, float], *axes: str) -> list[str]:
    """Positions of some axes as text; where the platform is tilted, of the tilts as well."""
    tilts = [tilt.name for tilt in stage.rotations if positions[tilt.name] != 0.0 and tilt.name not in axes]
    return [f"{axis} = {1e3 * positions[axis]:g} m{stage.axis(axis).unit('m')}"
            for axis in (*axes, *tilts)]


def modelled(description: StageDescription, controller: Any) -> Any:
    """The stage as a controller models it: with its constants, masses and places, and with nothing else."""
    stage = known_stages().definition(linear_names(description)[0]).new_block()
    magnetics, mover, model = stage.magnetics, stage.mover, controller.model
    magnetics.kinds = model.layout.kinds
    magnetics.thrust = list(model.thrust)
    magnetics.attraction, magnetics.coils, magnetics.iron = model.attraction, model.coils, model.iron
    magnetics.modulation = magnetics.magnet_rise = 0.0
    for axis in stage.axes:
        axis.bias = axis.ripple.amplitude = 0.0
    if description.rotations:
        part: Any = controller.holding if isinstance(controller, PID) else controller.currents
        allocation = part.allocation
        mover.height, mover.payload.mass = controller.platform.height, 0.0
        masses = (allocation.mass_y, allocation.mass_x, allocation.mass_z, allocation.inertia_roll,
                  allocation.inertia_pitch)
        for axis, mass in zip(stage.axes, masses if len(description.horizontal) == 2 else (*masses[:2], masses[3]),
                              strict=True):
            axis.mass = axis.nominal_mass = mass
        for spot, mount in zip(controller.platform.places, mover.mounts, strict=True):
            mount.x, mount.z = spot.x, spot.z
        for guide in mover.guides:
            guide.stiffness = 0.0
    return stage


def model_of(name: str, block: Any) -> Any:
    """The stage by which a controller makes the normal forces change evenly over a platform; None if currents do."""
    stage = linear_stage(name)
    return modelled(stage, block) if stage.rotations and regulator_in(name).startswith("Regulator") else None


def check_gaps(place: str, stage: StageDescription, block: Any, places: MotorPlaces,
               positions: Mapping[str, float]) -> None:
    """Raise for a tilt at which the gap of a motor is beyond the motor's field or a stop."""
    if not stage.rotations:
        return
    mounts = block.mover.mounts if isinstance(block, Stage) else [None] * len(stage.motors)
    for motor, mount, gap in zip(stage.motor_names, mounts, (places.gaps @ list(positions.values())).tolist(),
                                 strict=True):
        field = geometry_at(stage, block, motor).field
        low, high = (field.lower, field.upper) if mount is None else (mount.stop.lower, mount.stop.upper)
        if not low <= gap <= high:
            raise LinearModelError(f"{place}: {motor}.gap = {1e3 * gap:.4g} mm, expected it within {1e3 * low:g}…"
                                   f"{1e3 * high:g} mm{'' if mount is None else ', its end stops'}")


def solve(place: str, description: StageDescription, block: Any, places: MotorPlaces, positions: dict[str, float],
          split: Any) -> Equilibrium:
    """Currents under which no axis of a stage accelerates.

    The closed form neglects all effects of axes on each other but the iron, which is exact on a stage without tilts.
    Otherwise Newton's method starts from it.
    """
    stage = at_rest(description, block, positions)
    currents = np.zeros(2 * len(description.motors))
    rates, slopes = moved(description, stage, currents)
    for k, axis in enumerate(description.driven):
        thrust = sum(slopes[axis, 2 * j + 1] for j, driven in enumerate(description.driven) if driven == axis)
        needed = rates[axis]   # all that drive it have the same current
        if thrust == 0.0 and needed != 0.0:   # also of a constant that is nearly no number above 0
            raise LinearModelError(f"{place}: no current holds {description.axis_names[axis]} against {needed:g} m/s², "
                                   "expected a thrust constant above 0")
        currents[2 * k + 1] = -needed / thrust if needed else 0.0
    # a i_d² − b i_d + c = 0; the smaller root as 2 c / (b + √(b² − 4 a c)), which holds for a = 0 as well.
    rates, slopes = moved(description, stage, currents)
    b, c = float(slopes[0, 0::2].sum()), -float(rates[0])
    _, slopes = moved(description, stage, currents + np.tile([1.0, 0.0], len(description.motors)))
    a = 0.5 * (b - float(slopes[0, 0::2].sum()))
    discriminant = b * b - 4.0 * a * c
    if discriminant <= 0.0:
        raise LinearModelError(f"{place}: no direct current holds the mover: the coils push it off by at most "
                               f"{b * b / (4.0 * a) if a else 0.0:.3g} m/s², the attraction exceeds gravity by "
                               f"{c:.3g} m/s², expected a larger gap or other constants")
    currents[0::2] = 2.0 * c / (b + sqrt(discriminant))
    if description.rotations:
        split = None if split is None else at_rest(description, split, positions)
        currents = balanced(place, description, stage, places, currents, split)
    along = tuple((places.along @ list(positions.values())).tolist())
    return Equilibrium(positions, tuple(currents[0::2].tolist()), tuple(currents[1::2].tolist()), description, along,
                       tuple(geometry_at(description, block, motor) for motor in description.motor_names))


def geometry_at(stage: StageDescription, block: Any, motor: str) -> MotorGeometry:
    if isinstance(block, Stage):
        group = block.magnetics.groups[block.motors[stage.motor_names.index(motor)].group]
        return block.magnetics.kinds[group.kind].geometry
    layout: MotorLayout = block.model.layout
    return layout.kinds[layout.kind[stage.motor_names.index(motor)]].geometry


def balanced(place: str, description: StageDescription, stage: Any, places: MotorPlaces, currents: Array,
             split: Any) -> Array:
    """Currents (A) from which no axis accelerates, and of which, or of whose forces, all is spread evenly."""
    uneven = null_space(places.even.T).T
    forces = [f"{motor}.{force}" for motor in description.motor_names for force in ("normal", "thrust")]
    for _ in range(ITERATIONS):
        rates, by_current = moved(description, stage, currents)
        spread, by_spread = (currents, np.eye(len(currents))) if split is None else moved(description, split, currents,
                                                                                          forces)
        miss = np.concatenate([rates, uneven @ spread])
        if np.abs(miss).max() < BALANCED:
            return currents
        slopes = np.vstack([by_current, uneven @ by_spread])
        if not np.all(np.isfinite(slopes)) or np.linalg.matrix_rank(slopes) < len(currents):
            break
        currents = currents - np.linalg.solve(slopes, miss)
    raise LinearModelError(f"{place}: no currents hold the platform, expected less tilt, a larger gap or other "
                           "constants")


def check_amplifiers(place: str, block: Any, equilibrium: Equilibrium) -> None:
    """Raise for currents that amplifiers cannot hold for ever.

    At rest the I²t limit has followed the current, and the clamp is at the continuous rating where that is the lower
    one. Any phase has to carry the whole current at some displacement, by the voltage of the bus.
    """
    for motor, supply, d, q in zip(equilibrium.motors, block.motors, equilibrium.i_d, equilibrium.i_q, strict=True):
        rating, phases = supply.amplifier, supply.phases
        faults = {"amplifier.off": rating.off, "amplifier.stuck": rating.stuck,
                  **{f"phase_{letter}.open": phase.open for letter, phase in zip("abc", phases, strict=True)}}
        for fault in (name for name, there in faults.items() if there):
            raise LinearModelError(f"{place}: {motor}.{fault} = true, expected false: a linear model has no faults")
        needed = supply.winding.resistance * hypot(d, q)
        if 0.0 < block.bus_voltage < needed:
            raise LinearModelError(f"{place}: {motor} needs {needed:.3g} V for i_d = {d:.3g} A, i_q = {q:.3g} A, "
                                   f"expected at most bus_voltage = {block.bus_voltage:g} V")
        bound, which = rating.peak, "peak"
        if 0.0 < rating.continuous < rating.peak and rating.thermal_time > 0.0:
            bound, which = rating.continuous, "continuous"
        if 0.0 < bound < hypot(d, q):
            raise LinearModelError(
                f"{place}: {motor} needs i_d = {d:.3g} A, i_q = {q:.3g} A, expected at most "
                f"{motor}.amplifier.{which} = {bound:g} A: choose a {'smaller' if d < 0.0 else 'larger'} gap, or a "
                "larger rating to see beyond it")


def check_limit(place: str, block: Any, equilibrium: Equilibrium) -> None:
    """Raise for currents that a controller does not command."""
    for name, value in equilibrium.currents.items():
        layout = block.model.layout
        motor = equilibrium.motors.index(name.partition(".")[0])
        limit = block.current_limit * layout.kinds[layout.kind[motor]].ratio.limit
        if 0.0 < limit < abs(value):
            raise LinearModelError(
                f"{place}: {name}_cmd = {value:.3g} A is beyond current_limit = {limit:g} A, where the "
                f"controller is not linear, expected a {'smaller' if equilibrium.i_d[0] < 0.0 else 'larger'} gap or "
                "another limit (0 = none)")


def read_positions(name: str, at: Mapping[str, Quantity]) -> dict[str, float]:
    """Positions of all axes (m) from a user's values; see `equilibrium`."""
    stage = linear_stage(name)
    require_table(at, f"{name} at", LinearModelError, f"{{{stage.axis_names[0]!r}: '25 mm'}}")
    positions = dict.fromkeys(stage.axis_names, 0.0)
    for axis, given in at.items():
        if axis not in positions:
            raise LinearModelError(f"{name} at {axis} = {given}: no axis {axis!r}, expected "
                                   f"{one_of(axis, stage.axis_names)}")
        with refused_as(LinearModelError, f"{name} at {axis}"):
            positions[axis] = parse_quantity(given, stage.axis(axis).unit("m"))
    vertical = stage.vertical.name
    if vertical not in at:
        raise LinearModelError(f"{name}: no {vertical}, expected the air gap to linearise at, such as "
                               f"{vertical} = 25 mm")
    for field in (stage.motor(motor).field for motor in stage.motors):
        if not field.lower <= positions[vertical] <= field.upper:
            raise LinearModelError(f"{name} at {vertical} = {positions[vertical]:g} m: expected an air gap of "
                                   f"{field.lower:g}…{field.upper:g} m, where the motor's field is known")
    return positions
