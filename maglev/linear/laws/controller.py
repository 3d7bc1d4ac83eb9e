"""Linear models of the controllers, sampled."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from controller_fmu.linearisation import Linearisation
from maglev.arrays import Array
from maglev.errors import LinearModelError
from maglev.linear.laws.axis_laws import INPUTS, output_regulator, pid
from maglev.linear.model import Equilibrium, LinearModel
from maglev.linear.motors.forces import MotorForces
from maglev.linear.motors.places import MotorPlaces
from maglev.linear.parameters import prepare
from maglev.linear.plant import inverse_park_matrix, rotation_of
from pmlsm.rig import Rig


@dataclass(frozen=True, eq=False)
class Seen:
    """What a controller takes from its k inputs."""

    inputs: dict[str, str]   # names and units
    references: Array        # shape (axes, k)
    rates: Array             # shape (axes, k)
    measured: Array          # shape (axes, k); tilts and the gap at the centre are fitted to the gaps at the motors
    gaps: Array              # shape (motors, k)

    @classmethod
    def of(cls, rig: Rig, places: MotorPlaces) -> "Seen":
        """What a controller of a rig takes."""
        inputs: dict[str, str] = {}
        for axis in rig.axes:
            inputs |= {f"{axis.name}.reference": axis.unit("m"), f"{axis.name}.reference_rate": axis.unit("m/s")}
            inputs |= {f"{axis.name}.measured": "m"} if axis in rig.measured else {}
        at_motors = [f"{motor}.gap_measured" for motor in rig.motor_names if rig.rotations]
        inputs |= dict.fromkeys(at_motors, "m")

        def picked(names: Sequence[str]) -> Array:
            return np.array([[float(name == each) for each in inputs] for name in names])

        references, rates = (picked([f"{axis}.{kind}" for axis in rig.axis_names]) for kind in INPUTS[:2])
        measured = places.measuring(rig) @ picked([f"{axis.name}.measured" for axis in rig.measured] + at_motors)
        return cls(inputs, references, rates, measured, picked(at_motors) if at_motors else places.gaps @ measured)


def linear_controller(name: str, rig: Rig, block: Any, at: Equilibrium, phases: bool) -> LinearModel:
    """Linearise a controller about an equilibrium; see `maglev.linear.linearise.linearise`.

    LinearModelError if its parameters are refused, or at this equilibrium no direct current changes the levitation.
    """
    prepare(name, block)
    law = pid if name.startswith("PID") else output_regulator
    laws = [law(getattr(block, axis), block) for axis in rig.axis_names]
    a, b, c, d = (np.asarray(block_diag(*(getattr(each, matrix) for each in laws))) for matrix in "ABCD")
    places = MotorPlaces.of(rig, block)
    seen = Seen.of(rig, places)
    taken = np.stack([seen.references, seen.rates, seen.measured], axis=1).reshape(3 * len(rig.axes), -1)
    by_demand, by_gap, by_reference = current_law(name, rig, block, at)
    b, c = b @ taken, by_demand @ c
    d = by_demand @ d @ taken + by_gap @ seen.gaps + by_reference @ seen.references
    outputs = rig.dq_names
    if phases:
        inverse = inverse_park_matrix(at)
        # Phase currents that make the same i_d, i_q at another measured displacement (C.1).
        c, d = inverse @ c, inverse @ (d - rotation_of(places, at) @ seen.measured)
        outputs = rig.phase_names
    states = {f"{axis.name}.{state}": f"rad{unit[1:]}" if axis.rotation else unit
              for axis, each in zip(rig.axes, laws, strict=True) for state, unit in each.states.items()}
    commands = tuple(f"{current}_cmd" for current in outputs)
    return LinearModel(name, tuple(states), tuple(seen.inputs), commands, a, b, c, d,
                       {**states, **seen.inputs, **dict.fromkeys(commands, "A")}, block.sample_time, at)


def current_law(name: str, rig: Rig, block: Any, at: Equilibrium) -> tuple[Array, Array, Array]:
    """How i_d and i_q of each motor follow from what the axes ask for, from the gaps and from the references.

    Shapes (2 motors, axes), (2 motors, motors), (2 motors, axes). What a regulator's axes ask for are accelerations w.
    Nonlinear law: the currents are those for which the model has these accelerations (4.12), (5.7), so that
    δw = K δg + N δi. Linear and scheduled laws: the same at a set-point, with the error e in place of the gap (section
    4.6.1). Where the platform tilts, both hold at each motor.
    """
    forces, motors = MotorForces.of(rig, block), len(rig.motors)
    places = forces.places
    by_gap, no_reference = np.zeros((2 * motors, motors)), np.zeros((2 * motors, len(rig.axes)))
    if name.startswith("PID"):
        return places.even, by_gap, no_reference
    own = np.repeat(np.eye(motors), 2, axis=0)
    if name.startswith("Regulator"):
        _, slopes, _, by_current = forces.of_motors(list(at.positions.values()), at.dq)
        if not (by_current.diagonal()[0::2] > 0.0).all():
            raise LinearModelError(f"{name} at {at}: in its model more direct current no longer lifts, expected an "
                                   "equilibrium with less current")
        if rig.rotations:   # forces are spread evenly, and each motor makes its own
            inverse = np.linalg.inv(by_current)
            return (inverse @ places.even @ np.linalg.inv(places.effects @ places.even),
                    -inverse @ (slopes[:, None] * own), no_reference)
        by_demand = places.even @ np.linalg.inv(places.effects @ by_current @ places.even)
        return by_demand, -by_demand @ places.effects @ (slopes[:, None] * own), no_reference
    linear = linearisation(name, rig, block, forces, at.positions[rig.vertical.name])
    by_current = np.diag([slope for thrust in forces.thrusts for slope in (linear.gain / motors, -thrust * linear.f1)])
    by_gap[0::2] = -linear.stiffness / linear.gain * np.eye(motors)
    return places.even @ np.linalg.inv(places.effects @ by_current @ places.even), by_gap, -by_gap @ places.gaps


def linearisation(name: str, rig: Rig, block: Any, forces: MotorForces, gap: float) -> Linearisation:
    """Linearisation that a linear law has, or a scheduled one at a gap (m)."""
    # With one direct current in all motors.
    n = len(rig.motors)
    constants = (n * forces.attraction, n * forces.coils, n * forces.iron)
    linear = Linearisation()
    if name.startswith("Scheduled"):
        schedule = block.schedule
        schedule.prepare(forces.motor, *constants)
        schedule.choose(gap, linear)
    else:
        linear.prepare(forces.motor, *constants, block.setpoint)
    return linear
