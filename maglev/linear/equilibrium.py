"""Where a stage rests: the currents that hold it at a gap, and whether its amplifiers can."""

from collections.abc import Mapping, Sequence
from math import hypot, sqrt
from typing import Any

from maglev.errors import LinearModelError, QuantityError, nearest
from maglev.linear.model import Equilibrium
from maglev.linear.motor_forces import MotorForces
from maglev.linear.parameters import CONTROLLERS, Quantity, block_of, rig_of
from maglev.units import parse_quantity
from plant_fmu.attraction import attraction_factor
from pmlsm.gap_functions import gap_functions
from pmlsm.rig import Rig
from pmlsm.velocity_rows import GRAVITY


def equilibrium(name: str, at: Mapping[str, Quantity], parameters: Mapping[str, Quantity | bool] | None = None
                ) -> Equilibrium:
    """Find the equilibrium of a stage, or of the stage as a controller models it, at given positions.

    The horizontal rows give i_q, against the bias; the vertical one then i_d, the same in all motors: the smaller root
    of (4.12), (5.7). Friction holds nothing, ripple and the modulation of the attraction count. A
    controller's model has neither bias nor ripple nor modulation.

    Parameters
    ----------
    name : str
        A plant or controller, such as "Plant3DOF".
    at : mapping of str to float or str
        Position of each axis, m or text with a unit; the vertical one must be there, the others are 0 if not given.
    parameters : mapping, optional
        Parameters of the FMU that differ from their start values, by name.

    Raises
    ------
    LinearModelError
        If an axis or a parameter is unknown, the gap is outside 8…40 mm or beyond a stop, no current holds the mover
        there, or the amplifiers cannot hold that current, or the controller does not command it.
    """
    return equilibrium_of(name, block_of(name, parameters or {}), read_positions(name, at))


def equilibrium_of(name: str, block: Any, positions: dict[str, float]) -> Equilibrium:
    """Find the equilibrium of a block at the positions of its axes (m); see `equilibrium`."""
    rig = rig_of(name)
    place = f"{name} at {rig.vertical.name} = {1e3 * positions[rig.vertical.name]:g} mm"
    if name in CONTROLLERS:
        n = len(rig.axes)
        found = solve(place, rig, MotorForces.of(rig, block), positions, [0.0] * n, [0.0] * n, [1.0] * n)
        check_limit(place, block, found)
        return found
    axes = [getattr(block, axis) for axis in rig.axis_names]
    for axis_name, axis, position in zip(rig.axis_names, axes, positions.values(), strict=True):
        if axis.locked:
            raise LinearModelError(f"{name}: {axis_name}.locked = true, expected an axis that is free to move")
        if axis.stop.touched(position):
            raise LinearModelError(f"{name} at {axis_name} = {1e3 * position:g} mm: beyond the end stops, expected "
                                   f"{axis_name} within {1e3 * axis.stop.lower:g}…{1e3 * axis.stop.upper:g} mm")
    found = solve(place, rig, MotorForces.of(rig, block), positions, [axis.bias for axis in axes],
                  [axis.ripple.acceleration(position) for axis, position in zip(axes, positions.values(), strict=True)],
                  mass_factors(rig, block))
    check_amplifiers(place, block, found)
    return found


def mass_factors(rig: Rig, block: Any) -> list[float]:
    """Nominal over actual mass of each axis of a plant: the constants C are accelerations at the nominal masses."""
    axes = [getattr(block, axis) for axis in rig.axis_names]
    return [axis.nominal_mass / axis.mass for axis in axes]


def solve(place: str, rig: Rig, forces: MotorForces, positions: dict[str, float], biases: Sequence[float],
          ripples: Sequence[float], factors: Sequence[float]) -> Equilibrium:
    """Solve 0 = G + Δ + factor (motors + ripple) for i_d, and 0 = Δ + factor (motors + ripple) for each i_q.

    Biases and ripples (m/s²) and factors on the forces of the motors are those of each axis, the vertical one first.
    """
    gap, displacement = positions[rig.vertical.name], positions[rig.horizontal[0].name]
    f1, f2, f3, f4 = gap_functions(forces.motor, gap)
    i_q = []
    for axis, of_one in zip(forces.drives, forces.thrusts, strict=True):
        needed = biases[axis] / factors[axis] + ripples[axis]
        thrust = forces.drives.count(axis) * of_one   # all that drive it have the same current
        if thrust * f1 == 0.0 and needed != 0.0:   # also of a constant that is nearly no number above 0
            raise LinearModelError(f"{place}: no current holds {rig.axis_names[axis]} against {needed:g} m/s², "
                                   "expected a thrust constant above 0")
        i_q.append(needed / (thrust * f1) if needed else 0.0)
    # a i_d² − b i_d + c = 0; the smaller root as 2 c / (b + √(b² − 4 a c)), which holds for a = 0 as well.
    n = len(rig.motors)
    a = n * forces.iron * f4
    b = n * forces.coils * f3
    c = (forces.attraction * f2 * attraction_factor(forces.modulation, displacement, forces.motor.slot_pitch)
         + forces.iron * f4 * sum(q * q for q in i_q) - ripples[0] - (GRAVITY + biases[0]) / factors[0])
    discriminant = b * b - 4.0 * a * c
    if discriminant <= 0.0:
        raise LinearModelError(f"{place}: no direct current holds the mover, for the coils can push it off by "
                               f"{b * b / (4.0 * a) if a else 0.0:.3g} m/s² and it is attracted by {c:.3g} m/s² more "
                               "than gravity, expected a larger gap or other constants")
    i_d = 2.0 * c / (b + sqrt(discriminant))
    return Equilibrium(positions, (i_d,) * n, tuple(i_q), rig.motor_names, tuple(motor.drives for motor in rig.motors),
                       forces.motor)


def check_amplifiers(place: str, block: Any, found: Equilibrium) -> None:
    """Refuse currents that amplifiers do not hold for good.

    At rest the I²t limit has followed the current, and the clamp is at the continuous rating where that is the lower
    one. Any phase has to carry the whole current at some displacement.
    """
    for motor, d, q in zip(found.motors, found.i_d, found.i_q, strict=True):
        rating = getattr(block, motor).amplifier
        bound, which = rating.peak, "peak"
        if 0.0 < rating.continuous < rating.peak and rating.thermal_time > 0.0:
            bound, which = rating.continuous, "continuous"
        if 0.0 < bound < hypot(d, q):
            raise LinearModelError(
                f"{place}: {motor} needs i_d = {d:.3g} A, i_q = {q:.3g} A, expected at most "
                f"{motor}.amplifier.{which} = {bound:g} A: choose a {'smaller' if d < 0.0 else 'larger'} gap, or a "
                "larger rating to see beyond it")


def check_limit(place: str, block: Any, found: Equilibrium) -> None:
    """Refuse currents that a controller does not command."""
    for name, value in found.currents.items():
        if 0.0 < block.current_limit < abs(value):
            raise LinearModelError(
                f"{place}: {name}_cmd = {value:.3g} A is beyond current_limit = {block.current_limit:g} A, where the "
                f"controller is not linear, expected a {'smaller' if found.i_d[0] < 0.0 else 'larger'} gap or another "
                "limit (0 = none)")


def read_positions(name: str, at: Mapping[str, Quantity]) -> dict[str, float]:
    """Positions of all axes (m) from what a user gives; see `equilibrium`."""
    rig = rig_of(name)
    positions = dict.fromkeys(rig.axis_names, 0.0)
    for axis, given in at.items():
        if axis not in positions:
            raise LinearModelError(f"{name} at {axis} = {given}: no axis {axis!r}, expected one of "
                                   f"{', '.join(rig.axis_names)}; nearest is {nearest(axis, rig.axis_names)}")
        try:
            positions[axis] = parse_quantity(given, "m")
        except QuantityError as error:
            raise LinearModelError(f"{name} at {axis}: {error}") from None
    vertical = rig.vertical.name
    if vertical not in at:
        raise LinearModelError(f"{name}: no {vertical}, expected the air gap to linearise at, such as "
                               f"{vertical} = 25 mm")
    field = rig.motor().field
    if not field.lower <= positions[vertical] <= field.upper:
        raise LinearModelError(f"{name} at {vertical} = {positions[vertical]:g} m: expected an air gap of "
                               f"{field.lower:g}…{field.upper:g} m, where the motor's field is known")
    return positions
