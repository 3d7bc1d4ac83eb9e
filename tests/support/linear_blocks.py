"""Blocks at an operating point, and their one-sample maps differentiated by central differences."""

from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from typing import Any

import numpy as np
from motor import MOTOR
from named_blocks import named_block

from maglev.linear.loop import Loop
from maglev.linear.model import Equilibrium
from maglev.linear.parameters import plants
from pmlsm.dq_transform import phase_currents

AXES = {name: stage.axis_names for name, stage in plants().items()}
MOTORS = {name: stage.motor_names for name, stage in plants().items()}
TILTING = {name for name, stage in plants().items() if stage.rotations}


def smooth_stage(name: str, lag: bool, modes: Mapping[str, float] | None = None) -> Any:
    """Stage with what is smooth: no Coulomb friction, no rounding, no stops; with or without lag, with modes."""
    stage = named_block(name)
    set_all(stage, [*(modes or {})], [*(modes or {}).values()])
    stage.encoder.resolution = 0.0
    for axis in AXES[name]:
        part = getattr(stage, axis)
        part.friction.coulomb = part.stop.stiffness = part.stop.damping = 0.0
    for motor in MOTORS[name] if name in TILTING else ():
        stop = getattr(stage, f"{motor}_mount").stop
        stop.stiffness = stop.damping = 0.0
    if not lag:
        for motor in MOTORS[name]:
            getattr(stage, motor).amplifier.lag = 0.0
    return stage


def plant_at(name: str, stage: Any, positions: Sequence[float], rest: Equilibrium) -> None:
    """Start a stage at positions, with the phase currents of an equilibrium commanded and flowing."""
    for axis, position in zip(AXES[name], positions, strict=True):
        getattr(stage, axis).position_start = position
    assert stage.start() == 0
    for name_of, value in rest.phases.items():
        motor, _, phase = name_of.rpartition(".")
        setattr(getattr(stage, motor), f"{phase}_cmd", value)


def plant_state(name: str, stage: Any, state: Sequence[float]) -> None:
    """Set positions, velocities, i_d, i_q of each motor and deflections with rates of modes of a started stage."""
    axes, motors = AXES[name], MOTORS[name]
    n = len(axes)
    for axis, position, velocity in zip(axes, state[:n], state[n:2 * n], strict=True):
        getattr(stage, axis).position, getattr(stage, axis).velocity = float(position), float(velocity)
    mover = stage.block.mover
    mover.place(stage.block.axes)
    places = [mover.displacements[getattr(stage, motor).axis] for motor in motors]
    for k, part in enumerate(flexible(name, stage)):
        first = 2 * n + 2 * len(motors) + 2 * k
        part.mode.deflection, part.mode.rate = (float(value) for value in state[first:first + 2])
        part.swing = part.mode.encoder_share * part.mode.deflection
    for k, motor in enumerate(motors):
        i_d, i_q = (float(i) for i in state[2 * n + 2 * k:2 * n + 2 * k + 2])
        supply = getattr(stage, motor)
        angle = MOTOR.electrical_angle(places[k])
        for amplifier, value in zip(supply.phases, phase_currents(i_d, i_q, angle), strict=True):
            amplifier.current, amplifier.started = value, True


def read_plant(name: str, stage: Any) -> list[float]:
    """The same, read."""
    axes = [getattr(stage, axis) for axis in AXES[name]]
    supplies = [getattr(stage, motor) for motor in MOTORS[name]]
    return [*(axis.position for axis in axes), *(axis.velocity for axis in axes),
            *(current for supply in supplies for current in (supply.i_d, supply.i_q)),
            *(value for axis in flexible(name, stage) for value in (axis.mode.deflection, axis.mode.rate))]


def flexible(name: str, stage: Any) -> list[Any]:
    """Axes of a stage that have a flexible mode."""
    return [axis for axis in (getattr(stage, each) for each in AXES[name]) if axis.mode.frequency > 0.0]


def set_all(block: Any, names: Sequence[str], values: Sequence[float]) -> None:
    """Set attribute paths of a block."""
    for name, value in zip(names, values, strict=True):
        path, _, attribute = name.rpartition(".")
        setattr(attrgetter(path)(block), attribute, float(value))


def read_all(block: Any, names: Sequence[str]) -> list[float]:
    """Values of attribute paths of a block."""
    return [attrgetter(name)(block) for name in names]


def rest(plant: str, controller: Any, stage: Any, loop: Loop) -> np.ndarray:
    """State of the blocks at rest: the controller's integrators are moved until it holds the plant."""
    positions = list(loop.plant.equilibrium.positions.values())
    plant_at(plant, stage, positions, loop.plant.equilibrium)
    for axis, position in loop.plant.equilibrium.positions.items():
        getattr(controller, axis).reference = position
    measure(plant, controller, stage)
    assert controller.step(0.0, controller.sample_time) == 0
    held = np.array(list(loop.plant.equilibrium.currents.values()))
    integrators = [k for k, name in enumerate(loop.controller.states) if name.endswith((".xi1", ".integral"))]
    for _ in range(20):
        missing = held - read_all(controller, loop.controller.outputs)
        if np.abs(missing).max() < 1e-11:
            break
        change = np.linalg.lstsq(loop.controller.C[:, integrators], missing, rcond=None)[0]
        names = [loop.controller.states[k] for k in integrators]
        set_all(controller, names, (np.array(read_all(controller, names)) + change).tolist())
        assert controller.step(0.0, controller.sample_time) == 0
    state = read_all(controller, loop.controller.states)
    modes = np.zeros(2 * len(flexible(plant, stage)))
    return np.array([*positions, *np.zeros(len(positions)), *held, *modes, *state])


def measure(name: str, controller: Any, stage: Any, axis: str = "", change: float = 0.0) -> None:
    """Let a controller measure a stage, exactly except for a change of what it sees of one axis (m or rad)."""
    for each in AXES[name]:
        part = getattr(stage, each)
        getattr(controller, each).measured = part.position + part.swing + (change if each == axis else 0.0)
    for motor in MOTORS[name] if name in TILTING else ():
        mount = getattr(stage, f"{motor}_mount")
        moved = {"y": 1.0, "roll": -mount.z, "pitch": mount.x}.get(axis, 0.0)
        seen = mount.gap + stage.y.swing - mount.z * stage.roll.swing + mount.x * stage.pitch.swing
        getattr(controller, f"{motor}_place").gap_measured = seen + moved * change


def step_both(name: str, controller: Any, stage: Any) -> None:
    """Step a controller, which has its measurements, and a stage under its currents."""
    assert controller.step(0.0, controller.sample_time) == 0
    for motor in MOTORS[name]:
        for phase in "abc":
            setattr(getattr(stage, motor), f"i_{phase}_cmd", getattr(getattr(controller, motor), f"i_{phase}_cmd"))
    assert stage.step(0.0, controller.sample_time) == 0


def jacobian(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Central differences, each entry of the argument by its own step."""
    columns = []
    for k, step in enumerate(steps):
        ends = []
        for sign in (1.0, -1.0):
            moved = at.copy()
            moved[k] += sign * step
            ends.append(function(moved))
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.array(columns).T
