"""Linear models of the controllers, sampled."""

from typing import Any

import numpy as np
from scipy.linalg import block_diag

from controller_fmu.linearisation import Linearisation
from maglev.errors import LinearModelError
from maglev.linear.axis_laws import INPUTS, MEASURED, REFERENCE, output_regulator, pid
from maglev.linear.model import Equilibrium, LinearModel, Matrix
from maglev.linear.motor_forces import MotorForces
from maglev.linear.parameters import prepare
from maglev.linear.plant import inverse_park_matrix, rotation_of
from pmlsm.rig import Rig

ALWAYS = {"reference": "m", "reference_rate": "m/s", "measured": "m"}


def linear_controller(name: str, rig: Rig, block: Any, at: Equilibrium, phases: bool) -> LinearModel:
    """Linearise a controller about an equilibrium; see `maglev.linear.linearise.linearise`.

    Raises
    ------
    LinearModelError
        If its parameters are refused, or at this equilibrium no direct current changes the levitation.
    """
    prepare(name, block)
    law = pid if name.startswith("PID") else output_regulator
    laws = [law(getattr(block, axis), block) for axis in rig.axis_names]
    a, b, c, d = (np.asarray(block_diag(*(getattr(each, matrix) for each in laws))) for matrix in "ABCD")
    by_demand, by_input = current_law(name, rig, block, at)
    # Every motor gets the direct current of the vertical axis, and the quadrature current of the axis that it drives.
    spread = np.zeros((2 * len(rig.motors), len(rig.axes)))
    spread[0::2, 0] = 1.0
    for motor, axis in enumerate(rig.driven):
        spread[2 * motor + 1, axis] = 1.0
    c, d = spread @ by_demand @ c, spread @ (by_demand @ d + by_input)
    outputs = rig.dq_names
    if phases:
        inverse = inverse_park_matrix(rig, at)
        measured = np.zeros((len(rig.axes), d.shape[1]))
        measured[:, MEASURED::3] = np.eye(len(rig.axes))
        # Phase currents that make the same i_d, i_q at another measured displacement (C.1).
        c, d = inverse @ c, inverse @ (d - rotation_of(rig, at) @ measured)
        outputs = rig.phase_names
    states = {f"{axis}.{state}": unit for axis, each in zip(rig.axis_names, laws, strict=True)
              for state, unit in each.states.items()}
    inputs = {f"{axis}.{name}": ALWAYS[name] for axis in rig.axis_names for name in INPUTS}
    commands = tuple(f"{current}_cmd" for current in outputs)
    return LinearModel(name, tuple(states), tuple(inputs), commands, a, b, c, d,
                       {**states, **inputs, **dict.fromkeys(commands, "A")}, block.sample_time, at)


def current_law(name: str, rig: Rig, block: Any, at: Equilibrium) -> tuple[Matrix, Matrix]:
    """How i_d, i_q1, i_q2 … follow from what the axes ask for, and directly from the inputs.

    Shapes (axes, axes) and (axes, 3 axes). What a regulator's axes ask for are accelerations w. Nonlinear law: the
    currents are those for which the model has these accelerations (4.12), (5.7), so that δw = K δg + N δi. Linear and
    scheduled laws: the same at a set-point, with the error e in place of the gap (section 4.6.1).
    """
    axes = len(rig.axes)
    direct = np.zeros((axes, 3 * axes))
    if name.startswith("PID"):
        return np.eye(axes), direct
    forces = MotorForces.of(rig, block)
    if name.startswith("Regulator"):
        driving = np.array([[float(k == axis) for k in range(1, axes)] for axis in rig.driven])
        by_position, by_current = forces.slopes(tuple(at.positions.values()), at.i_d, at.i_q)
        model = np.column_stack([by_current[:, 0::2].sum(axis=1), by_current[:, 1::2] @ driving])
        if model[0, 0] <= 0.0:
            raise LinearModelError(f"{name} at {at}: in its model more direct current no longer lifts, expected an "
                                   "equilibrium with less current")
        inverse = np.linalg.inv(model)
        direct[:, MEASURED] = -inverse @ by_position[:, 0]
        return inverse, direct
    linear = linearisation(name, rig, block, forces, at.positions[rig.vertical.name])
    direct[0, MEASURED] = -linear.stiffness / linear.gain
    direct[0, REFERENCE] = linear.stiffness / linear.gain
    thrusts = np.bincount(rig.driven, forces.thrusts)[1:]
    return np.diag([1.0 / linear.gain, *(-1.0 / (thrusts * linear.f1))]), direct


def linearisation(name: str, rig: Rig, block: Any, forces: MotorForces, gap: float) -> Linearisation:
    """Linearisation that a linear law has, or a scheduled one at a gap (m)."""
    # With one direct current in all motors.
    constants = (forces.attraction, len(rig.motors) * forces.coils, len(rig.motors) * forces.iron)
    linear = Linearisation()
    if name.startswith("Scheduled"):
        schedule = block.schedule
        schedule.prepare(forces.motor, *constants)
        schedule.choose(gap, linear)
    else:
        linear.prepare(forces.motor, *constants, block.setpoint)
    return linear
