"""One axis of a loop at a frozen gap, with the limit of its command and the antiwindup (5.13)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from maglev.errors import RigError, StabilityError, nearest
from maglev.linear.linearise import linearise
from maglev.linear.model import LinearModel, Matrix, equivalents, slowest_first
from maglev.linear.parameters import BLOCKS, Quantity, block_of
from maglev.own_stage.adoption import rig_named as own_or_ours
from pmlsm.rig import Rig

INTERNAL_MODEL = ("model.xi1", "model.xi2", "model.xi3")


@dataclass(frozen=True, eq=False)
class AxisLoop:
    """Deviations χ of one axis from rest at its reference: (χ[k+1] − χ[k])/Ts = A χ − (B + E Ec) φ(u), u = K χ.

    φ(u) = u − sat(u) is what the limit cuts off the command. A divided difference in place of χ[k+1] keeps the numbers
    of a fast sampled loop well apart from 1; with Ts = 0 the same letters are a loop in continuous time, χ' = ….

    Attributes
    ----------
    name : str
        Plant, controller, axis and gap.
    axis : str
        Its name.
    states : tuple of str
        Names of the n states: position, velocity, current of the amplifiers, observer, internal model.
    A : ndarray, shape (n, n)
        1/s, the loop while no limit is reached.
    B : ndarray, shape (n,)
        Effect of the commanded current, 1/(s A) times the unit of the state.
    E : ndarray, shape (n, 3)
        Where the antiwindup acts: on ξ1, ξ2, ξ3.
    K : ndarray, shape (n,)
        Commanded current for a state, A.
    at_step : ndarray, shape (n,)
        State in which the loop rests 1 m beyond its reference: a step of the reference by r starts at −r at_step.
    in_motion : ndarray, shape (n,)
        State that passes the reference at 1 m/s with an observer that has seen it coming.
    sample_time : float
        Ts, s; 0 for continuous time.
    lower, upper : float
        What the command may deviate from that at rest, A, below and above 0.
    gains : ndarray, shape (3,)
        Ec as set; zeros where the antiwindup is off.
    """

    name: str
    axis: str
    states: tuple[str, ...]
    A: Matrix
    B: Matrix
    E: Matrix
    K: Matrix
    at_step: Matrix
    in_motion: Matrix
    sample_time: float
    lower: float
    upper: float
    gains: Matrix

    @property
    def limit(self) -> float:
        """Deviation of the command that both sides allow, A."""
        return min(-self.lower, self.upper)

    @property
    def at_rest(self) -> float:
        """Command at rest, A."""
        return -0.5 * (self.lower + self.upper)

    @property
    def rates(self) -> Any:
        """Poles of the loop while no limit is reached, as rates, 1/s, the slowest first."""
        poles = np.linalg.eigvals(self.A).astype(np.complex128)
        return slowest_first(equivalents(1.0 + self.sample_time * poles, self.sample_time)
                             if self.sample_time else poles)


def rig_named(rig: str) -> tuple[Rig, str, list[str]]:
    """Description of a rig, and the names of its plant and of its output regulators, the nonlinear one first.

    Raises
    ------
    StabilityError
        If there is no such rig, or its platform tilts.
    """
    try:
        described = own_or_ours(rig if rig.endswith(".toml") else rig.lower())
    except RigError as error:
        raise StabilityError(str(error)) from None
    if described.rotations:
        raise StabilityError(f"{rig}: its platform tilts, expected a stage without tilt: where it tilts, motors come "
                             "to their limits one by one, and what one of them cuts off acts on several axes, but a "
                             "certificate is of one axis with one limit")
    plant, *controllers = (definition.name for definition in BLOCKS[described.name])
    return described, plant, [name for name in controllers if "Regulator" in name]


def axis_loop(rig: str, axis: str, gap: Quantity, *, controller: str | None = None,
              plant_parameters: Mapping[str, Quantity | bool] | None = None,
              controller_parameters: Mapping[str, Quantity | bool] | None = None) -> AxisLoop:
    """Linear loop of one axis, all others at rest, with what limits it.

    The loop is that of `maglev.linear`: sampled, with observer and the lag of the amplifiers. At a frozen gap a
    horizontal axis of the feedback-linearised motor is linear; the vertical one is linearised.

    Parameters
    ----------
    rig : str
        "2dof", "3dof", or the description of a stage of yours, "mine.toml".
    axis : str
        "v", "h" or "y", "x", "z".
    gap : float or str
        Air gap, m or text such as "25 mm".
    controller : str, optional
        An output regulator; `Regulator2DOF` or `Regulator3DOF` if not given.
    plant_parameters, controller_parameters : mapping, optional
        Parameters of the FMUs that differ from their start values.

    Raises
    ------
    StabilityError
        If there is no such rig, axis or output regulator, its commands have no limit, or the loop is not stable.
    LinearModelError
        If a parameter cannot be used, or the stage cannot rest at this gap.
    """
    described, stage, regulators = rig_named(rig)
    vertical = described.vertical.name
    if axis not in described.axis_names:
        raise StabilityError(f"{rig}: axis = {axis!r}, expected one of {', '.join(described.axis_names)}")
    name = controller or regulators[0]
    if name not in regulators:
        raise StabilityError(f"{rig}: controller = {name!r}, expected an output regulator, which has an antiwindup: "
                             f"{', '.join(regulators)}; nearest is {nearest(name, regulators)}")
    settings = controller_parameters or {}
    block = block_of(name, settings)
    if block.current_limit <= 0.0:
        raise StabilityError(f"{name}: current_limit = {block.current_limit:g} A is none, expected a limit above 0 A: "
                             "without one the region is as large as the model holds")
    plant = linearise(stage, {vertical: gap}, hold=block.sample_time, parameters=plant_parameters)
    law = linearise(name, plant.equilibrium, parameters=settings)
    currents = currents_of(described, axis)
    loop = close(f"{axis} of {stage} with {name} at {vertical} = {1e3 * plant.equilibrium.positions[vertical]:g} mm",
                 axis, currents, plant, law,
                 plant.equilibrium.currents[currents[0]], block)
    if loop.rates[0].real >= 0.0:
        raise StabilityError(f"{loop.name}: the loop is unstable, its slowest pole is {loop.rates[0]:.4g} 1/s, "
                             "expected gains with which it is stable while no limit is reached")
    return loop


def currents_of(rig: Rig, axis: str) -> list[str]:
    """Currents that move an axis; the direct currents of all motors, which are one, move the vertical one."""
    if axis == rig.vertical.name:
        return [f"{motor}.i_d" for motor in rig.motor_names]
    return [f"{motor.name}.i_q" for motor in rig.motors if motor.drives == axis]


def close(name: str, axis: str, currents: list[str], plant: LinearModel, law: LinearModel, at_rest: float,
          block: Any) -> AxisLoop:
    """Close the loop of one axis, with what its command is at rest (A)."""
    dt = block.sample_time
    motion = [f"{axis}.position", f"{axis}.velocity"]
    lagged = [current for current in currents if current in plant.states]
    # Currents that are always the same in all motors are one state: each column says where a state stands in the plant.
    spread = np.zeros((len(plant.states), 2 + bool(lagged)))
    for column, names in enumerate([[motion[0]], [motion[1]], *([lagged] if lagged else [])]):
        spread[[plant.states.index(each) for each in names], column] = 1.0
    gathered = np.linalg.pinv(spread)
    a = gathered @ plant.A @ spread
    b = gathered @ plant.B[:, [plant.inputs.index(f"{current}_cmd") for current in currents]].sum(axis=1)
    mine = [k for k, state in enumerate(law.states) if state.startswith(f"{axis}.")]
    measured, reference = (law.inputs.index(f"{axis}.{signal}") for signal in ("measured", "reference"))
    command = law.outputs.index(f"{currents[0]}_cmd")
    p, n = len(a), len(a) + len(mine)
    full = np.zeros((n, n))
    full[:p, :p], full[p:, p:] = a, law.A[np.ix_(mine, mine)]
    full[p:, 0] = law.B[mine, measured]
    drive = np.concatenate([b, np.zeros(len(mine))])
    k = np.concatenate([[law.D[command, measured]], np.zeros(p - 1), law.C[command, mine]])
    full += np.outer(drive, k)
    by_reference = drive * law.D[command, reference] + np.concatenate([np.zeros(p), law.B[mine, reference]])
    states = (*motion, *(lagged[:1]), *(law.states[each] for each in mine))
    places = {state.removeprefix(f"{axis}."): place for place, state in enumerate(states)}
    inject = np.zeros((n, 3))
    inject[[places[state] for state in INTERNAL_MODEL], range(3)] = 1.0
    in_motion = np.zeros(n)
    in_motion[[places["velocity"], places["observer.velocity"]]] = 1.0
    # At a constant speed the low-passed position is behind by Ts/a1 when the next measurement comes.
    in_motion[places["observer.position"]] = -dt / block_share(block)
    of_axis = getattr(block, axis)
    gains = np.array([of_axis.ec1, of_axis.ec2, of_axis.ec3]) if block.antiwindup else np.zeros(3)
    return AxisLoop(name, axis, states, (full - np.eye(n)) / dt, drive / dt, inject, k,
                    np.linalg.solve(np.eye(n) - full, by_reference), in_motion, dt,
                    -block.current_limit - at_rest, block.current_limit - at_rest, gains)


def block_share(block: Any) -> float:
    """Share a1 of the observer's first filter at the sample time of a controller."""
    block.observer.prepare(block.sample_time)
    return float(block.observer.share1)
