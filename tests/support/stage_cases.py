"""Runs of a stage block next to the reference solution: cases, commands, and the largest differences."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from direct_loop import LAYOUTS
from named_stage import Stage2DOF, Stage3DOF
from reference_stage import TAU, G, ReferenceStage, reference_2dof, reference_3dof, shape_functions
from scipy.optimize import brentq

Commands = Callable[[int, np.ndarray], np.ndarray]



@dataclass(frozen=True)
class Case:
    """A run of 0.1 s or so: start positions (m), and phase commands by step and positions, shape (motors, 3)."""

    name: str
    stage: int
    start: tuple[float, ...]
    commands: Commands
    stop_time: float = 0.1


def reference(stage: int) -> ReferenceStage:
    """Reference of a stage."""
    return reference_2dof() if stage == 2 else reference_3dof()


def phases(i_d: float, i_q: float, displacement: float) -> np.ndarray:
    """Phase currents (C.1), shape (3,)."""
    angles = np.pi / TAU * (displacement - TAU / 2) + np.array([0, -2 * np.pi / 3, 2 * np.pi / 3])
    return np.cos(angles) * i_d - np.sin(angles) * i_q


def equilibrium_current(stage: int, gap: float) -> float:
    """Direct current (A) that holds the mover at a gap (m)."""
    _, f2, f3, f4 = shape_functions(gap)
    c = reference(stage).constants
    if stage == 2:
        return float(brentq(lambda i: G - c[3] * f4 * i**2 + c[2] * f3 * i - c[1] * f2, -20, 20))
    return float(brentq(lambda i: G - 4 * c[4] * f4 * i**2 + 4 * c[3] * f3 * i - 4 * c[2] * f2, -20, 20))


def near_equilibrium(stage: int, gap: float) -> Case:
    """Held near a gap, with both currents moving."""
    i_d = equilibrium_current(stage, gap)
    places = (0.004, -0.010)

    def commands(k: int, _: np.ndarray) -> np.ndarray:
        t = k * LAYOUTS[stage][2]
        i_q = (0.5 if stage == 2 else 1.5) * np.sin(90.0 * t + 1.0)
        return np.array([phases(i_d + sign * 0.3 * np.sin(100.0 * t), i_q, place)
                         for place, sign in zip(places[:stage - 1], (1, -1), strict=False)])

    return Case(f"{stage}-DOF near {1e3 * gap:g} mm", stage, (gap, *places[:stage - 1]), commands)


def falling(stage: int, gap: float) -> Case:
    """Without current into the lower stop."""
    return Case(f"{stage}-DOF into a stop from {1e3 * gap:g} mm", stage, (gap, *(0.0,) * (stage - 1)),
                lambda k, x: np.zeros((stage - 1, 3)), 0.15)


def parabola(stage: int, i_q: float) -> Case:
    """Constant quadrature current along the horizontal axes, commutated at the true place."""
    gap = 20e-3 if stage == 2 else 25e-3
    i_d = equilibrium_current(stage, gap)
    starts = (-0.05, 0.05)[:stage - 1]

    def commands(_: int, x: np.ndarray) -> np.ndarray:
        return np.array([phases(i_d, sign * i_q, place) for place, sign in zip(x[1:], (1, -1), strict=False)])

    return Case(f"{stage}-DOF parabola at {i_q:g} A", stage, (gap, *starts), commands)


def side_impact() -> Case:
    """The 2-DOF stage driven against a horizontal stop at more than 1 m/s."""
    i_d = equilibrium_current(2, 20e-3)
    return Case("2-DOF against a side stop", 2, (20e-3, 0.03),
                lambda k, x: np.array([phases(i_d, -6.0, x[1])]), 0.08)


SMOOTH = [*(near_equilibrium(2, gap) for gap in (15e-3, 18e-3, 21e-3, 24e-3)), parabola(2, -0.5), parabola(2, -2.5),
          *(near_equilibrium(3, gap) for gap in (20e-3, 23e-3, 26e-3, 29e-3)), parabola(3, -3.0)]
IMPACTS = [falling(2, 26e-3), falling(2, 26.017e-3), side_impact(), falling(3, 30.5e-3), falling(3, 31.5e-3)]


def run_block(description: int, start: Sequence[float], commands: Commands, dt: float, steps: int,
              bus_voltage: float = 0.0) -> tuple[np.ndarray, list[np.ndarray]]:
    """Positions and velocities of the block, shape (steps + 1, axes, 2), and the commands that it was given."""
    stage = Stage2DOF() if description == 2 else Stage3DOF()
    stage.bus_voltage = bus_voltage
    axes = [getattr(stage, name) for name in LAYOUTS[description][0]]
    motors = [getattr(stage, name) for name in LAYOUTS[description][1]]
    for axis, position in zip(axes, start, strict=True):
        axis.position_start = position
    assert stage.start() == 0
    rows, given = [[(a.position, a.velocity) for a in axes]], []
    for k in range(steps):
        given.append(commands(k, np.array([a.position for a in axes])))
        for motor, currents in zip(motors, given[-1], strict=True):
            motor.i_a_cmd, motor.i_b_cmd, motor.i_c_cmd = (float(i) for i in currents)
        assert stage.step(k * dt, dt) == 0
        rows.append([(a.position, a.velocity) for a in axes])
    return np.array(rows), given


def differences(case: Case) -> tuple[float, float]:
    """Largest difference of position (m) and velocity (m/s) from the reference, at every communication point."""
    dt = LAYOUTS[case.stage][2]
    steps = round(case.stop_time / dt)
    block, given = run_block(case.stage, case.start, case.commands, dt, steps)
    states = reference(case.stage).solve(case.start, lambda k, _: given[k], dt, steps)
    solved = states[:, :3 * len(case.start)].reshape(len(states), len(case.start), 3)[:, :, :2]
    difference = np.abs(block - solved).max(axis=(0, 1))
    return float(difference[0]), float(difference[1])
