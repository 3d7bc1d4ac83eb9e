"""One axis of a loop at a frozen gap, with the limits of its commands and the antiwindup (5.13)."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import StabilityError, StageError, one_of
from maglev.linear.loop import Loop, linearise_loop
from maglev.linear.model import equivalents, slowest_first
from maglev.linear.parameters import Quantity, block_of, linear_names, regulator_in
from maglev.linear.places import MotorPlaces
from maglev.user.adoption import stage_named as own_or_ours
from pmlsm.stage_description import StageDescription

INTERNAL_MODEL = ("model.xi1", "model.xi2", "model.xi3")
ALIKE = 1e-7    # share of the largest command or push, below which a difference is rounding
MOST_AXES = 3   # that the solver takes at once


@dataclass(frozen=True, eq=False)
class AxisLoop:
    """Deviations χ of one axis from rest at its reference: (χ[k+1] − χ[k])/Ts = A χ − (B + E Ec wᵀ) φ(u), u = K χ.

    φ(u) = u − sat(u) is the part of the m commands beyond the limits. On a stage without tilts there is one command.
    Where the platform tilts, a limited current moves further axes than its own. They are states, too, and every motor
    has a limit of its own. A divided difference instead of χ[k+1] keeps the numbers of a fast sampled loop well apart
    from 1. With Ts = 0 the same letters are a loop in continuous time, χ' = ….
    """

    name: str   # plant, controller, axis and gap
    axis: str   # its name
    unit: str   # of its position, "m" or "rad": where m stands below, a tilt has rad
    axes: tuple[str, ...]   # those that move: itself first, then those that its limits move, if any
    # names of the n states: position and velocity of each axis, currents of the amplifiers, observers, internal models
    states: tuple[str, ...]
    # the m limited commands, each with the currents that are always the same; the first moves the axis
    commands: tuple[tuple[str, ...], ...]
    A: Array   # 1/s, the loop while no limit is reached; shape (n, n)
    # effect of the commanded currents, 1/(s A) times the unit of the state, with the antiwindup of the other axes;
    # shape (n, m)
    B: Array
    E: Array   # where the antiwindup of the axis acts: on ξ1, ξ2, ξ3; shape (n, 3)
    w: Array   # what each command counts in it: 1 where there is one; shape (m,)
    K: Array   # commanded currents for a state, A; shape (m, n)
    # state in which the loop rests 1 m beyond its reference: a step by r starts at −r at_step; shape (n,)
    at_step: Array
    in_motion: Array   # state that passes the reference at 1 m/s with an observer that has seen it coming; shape (n,)
    sample_time: float   # Ts, s; 0 for continuous time
    lower: Array   # what the commands may deviate from those at rest, A, below 0; shape (m,)
    upper: Array   # the same above 0
    gains: Array   # Ec as set; zeros where the antiwindup is off; shape (3,)

    @property
    def limits(self) -> Array:
        """Deviations of the commands that both sides allow, A, shape (m,)."""
        return np.minimum(-self.lower, self.upper)

    @property
    def at_rest(self) -> float:
        """The first command at rest, A."""
        return float(-0.5 * (self.lower[0] + self.upper[0]))

    def injected(self, gains: Array) -> Array:
        """B + E Ec wᵀ with antiwindup gains Ec, shape (n, m)."""
        return np.asarray(self.B + np.outer(self.E @ gains, self.w))

    @property
    def rates(self) -> Any:
        """Poles of the loop while no limit is reached, as rates, 1/s, the slowest first."""
        poles = np.linalg.eigvals(self.A).astype(np.complex128)
        return slowest_first(equivalents(1.0 + self.sample_time * poles, self.sample_time)
                             if self.sample_time else poles)


def stage_and_regulators(stage: str | Path) -> tuple[StageDescription, str, list[str]]:
    """Return the description of a stage, and the names of its plant and of its output regulators, the nonlinear one
    first.

    StabilityError if there is no such stage.
    """
    try:
        described = own_or_ours(stage if str(stage).endswith(".toml") else str(stage).lower())
    except StageError as error:
        raise StabilityError(str(error)) from None
    for motor in described.unlike:
        raise StabilityError(f"{stage}: motors.{motor.name} has its own constants, expected equal motors: the region "
                             "assumes that all reach their limit at once")
    plant, *controllers = linear_names(described)
    return described, plant, [name for name in controllers if "Regulator" in name and regulator_in(name) == name]


def axis_loop(description: str | Path, axis: str, gap: Quantity, *, controller: str | None = None,
              plant_parameters: Mapping[str, Quantity | bool] | None = None,
              controller_parameters: Mapping[str, Quantity | bool] | None = None) -> AxisLoop:
    """Return the linear loop of one axis, all others at rest, with its limits.

    The loop is that of `maglev.linear`: sampled, with observer and the lag of the amplifiers. At a frozen gap a
    horizontal axis of the feedback-linearised motor is linear; the vertical one is linearised. Where the platform
    tilts, the loop is that without bias along the horizontal axes, so that level motors carry alike; the bias reduces
    the limit of each current.

    See `maglev.region` for stage, axis, gap and controller. The parameters are those of the FMUs that differ from
    their start values. StabilityError if there is no such stage, axis or output regulator, its commands have no limit,
    or the loop is not stable. LinearModelError if a parameter cannot be used, or the stage cannot rest at this gap.
    """
    described, stage, regulators = stage_and_regulators(description)
    vertical = described.vertical.name
    if axis not in described.axis_names:
        raise StabilityError(f"{description}: axis = {axis!r}, expected one of {', '.join(described.axis_names)}")
    name = controller or regulators[0]
    if name not in regulators:
        raise StabilityError(f"{description}: controller = {name!r}, expected an output regulator, which has an "
                             f"anti-windup: "
                             f"{one_of(name, regulators)}")
    settings = controller_parameters or {}
    block = block_of(name, settings)
    if block.current_limit <= 0.0:
        raise StabilityError(f"{name}: current_limit = {block.current_limit:g} A, expected a limit above 0 A: "
                             "without one the region is unbounded")
    parameters = dict(plant_parameters or {})
    level = {**parameters, **{f"{axis.name}.bias": 0.0 for axis in described.horizontal if described.rotations}}
    loop = linearise_loop(stage, name, {vertical: gap}, plant_parameters=level, controller_parameters=settings)
    rest = (linearise_loop(stage, name, {vertical: gap}, plant_parameters=parameters, controller_parameters=settings)
            if described.rotations else loop).plant.equilibrium
    swinging = [state.removesuffix(".deflection") for state in loop.plant.states if state.endswith(".mode.deflection")]
    if swinging:
        raise StabilityError(f"{stage}: {swinging[0]}.frequency is above 0 Hz, expected 0 Hz: a certificate assumes a "
                             "rigid mover")
    title = f"{axis} of {stage} with {name} at {vertical} = {1e3 * rest.positions[vertical]:g} mm"
    closed = close(title, described, axis, loop, rest.currents, block)
    if closed.rates[0].real >= 0.0:
        raise StabilityError(f"{title}: the loop is unstable, its slowest pole is {closed.rates[0]:.4g} 1/s, "
                             "expected gains that stabilise it within the limits")
    return closed


def currents_of(stage: StageDescription, axis: str) -> list[str]:
    """Currents that move an axis: of the motors that drive it, or the direct ones of those that lift or tilt it."""
    shares = MotorPlaces.of(stage).even[:, stage.axis_names.index(axis)]
    return [current for current, share in zip(stage.dq_names, shares, strict=True) if share != 0.0]


def coupled(loop: Loop, stage: StageDescription, axis: str, commanded: Array) -> tuple[list[str], list[list[str]]]:
    """The axes that an axis and the limits of its currents move, itself first, and the commands that are always alike.

    A current that the limit cuts off moves what it would have moved, whoever asked for it; several that are alike in
    all these axes are cut off together.
    """
    if not stage.rotations:
        return [axis], [currents_of(stage, axis)]
    closed, plant = loop.closed, loop.plant
    pushed = plant.B[[plant.index("state", f"{axis}.velocity") for axis in stage.axis_names]]
    moving = [axis]
    while True:
        rows = commanded[:, [k for k, state in enumerate(closed.states)
                             if state.removeprefix("controller.").partition(".")[0] in moving]]
        alike: list[list[int]] = []
        for k in np.flatnonzero(np.abs(rows).max(axis=1) > ALIKE * np.abs(rows).max()).tolist():
            same = next((group for group in alike if np.abs(rows[k] - rows[group[0]]).max()
                         <= ALIKE * np.abs(rows[k]).max()), None)
            if same is None:
                alike.append([k])
            else:
                same.append(k)
        pushes = np.array([np.abs(pushed[:, group].sum(axis=1)) for group in alike]).max(axis=0)
        more = [name for name, push in zip(stage.axis_names, pushes, strict=True)
                if name not in moving and push > ALIKE * pushes.max()]
        if not more:
            first = currents_of(stage, axis)[0]
            sets = [[plant.inputs[k].removesuffix("_cmd") for k in group] for group in alike]
            return moving, sorted(sets, key=lambda group: first not in group)
        moving += more


def close(name: str, stage: StageDescription, axis: str, loop: Loop, rest: Mapping[str, float], block: Any) -> AxisLoop:
    """Cut the loop of one axis, and of those that its limits move, out of a whole one with the currents at rest (A)."""
    closed, plant, dt = loop.closed, loop.plant, block.sample_time
    law = loop.controller.select(tuple(loop.signals), plant.inputs)
    commanded = np.hstack([law.D @ loop.sensed, law.C])
    axes, sets = coupled(loop, stage, axis, commanded)
    if len(axes) > MOST_AXES:
        raise StabilityError(f"{name}: its limits move {', '.join(axes)}, expected equal motors: at most {MOST_AXES} "
                             "axes are certified together")
    # Currents that are always the same in all motors are one state: each column says where a state stands in the loop.
    motion = [f"{axis}.{part}" for axis in axes for part in ("position", "velocity")]
    lagged = [currents for currents in sets if currents[0] in plant.states]
    mine = [state for axis in axes for state in closed.states if state.startswith(f"controller.{axis}.")]
    groups = [*([state] for state in motion), *lagged, *([state] for state in mine)]
    spread = np.zeros((len(closed.states), len(groups)))
    for column, names in enumerate(groups):
        spread[[closed.index("state", name) for name in names], column] = 1.0
    gathered = np.linalg.pinv(spread)
    full = gathered @ closed.A @ spread
    heads = [plant.inputs.index(f"{currents[0]}_cmd") for currents in sets]
    k = commanded[heads] @ spread
    drive = gathered[:, :len(plant.states)] @ np.column_stack(
        [plant.B[:, [plant.inputs.index(f"{current}_cmd") for current in currents]].sum(axis=1) for currents in sets])
    by_reference = gathered @ closed.B[:, closed.index("input", f"{axis}.reference")]
    n, states = len(groups), tuple(group[0].removeprefix("controller.") for group in groups)
    shares = np.linalg.pinv(MotorPlaces.of(stage, block).even)   # shares of the cut-off command, by axis and current
    gains, weights, inject = {}, {}, {}
    for moved in axes:
        row, part = shares[stage.axis_names.index(moved)], block.axes[stage.axis_number(moved)]
        weights[moved] = np.array([sum(row[stage.dq_names.index(current)] for current in alike) for alike in sets])
        weights[moved][np.abs(weights[moved]) < ALIKE * np.abs(weights[moved]).max()] = 0.0
        gains[moved] = np.array([part.ec1, part.ec2, part.ec3]) if block.antiwindup else np.zeros(3)
        inject[moved] = np.zeros((n, 3))
        inject[moved][[states.index(f"{moved}.{state}") for state in INTERNAL_MODEL], range(3)] = 1.0
    others = sum((np.outer(inject[other] @ gains[other], weights[other]) for other in axes[1:]),
                 np.zeros((n, len(sets))))
    block.observer.prepare(dt)
    in_motion = np.zeros(n)
    in_motion[[states.index(f"{axis}.{state}") for state in ("velocity", "observer.velocity")]] = 1.0
    # At a constant speed the low-passed position is behind by Ts/a1 when the next measurement comes.
    in_motion[states.index(f"{axis}.observer.position")] = -dt / block.observer.share1
    at_step: Array = np.linalg.solve(np.eye(n) - full, by_reference).astype(np.float64)
    return AxisLoop(name, axis, stage.axis(axis).unit("m"), tuple(axes), states,
                    tuple(tuple(currents) for currents in sets), (full - np.eye(n)) / dt,
                    np.asarray(drive / dt + others), inject[axis], weights[axis], k, at_step, in_motion, dt,
                    np.array([max(-block.current_limit - rest[group] for group in alike) for alike in sets]),
                    np.array([min(block.current_limit - rest[group] for group in alike) for alike in sets]),
                    gains[axis])
