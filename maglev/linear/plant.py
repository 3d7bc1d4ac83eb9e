"""Linear model of a stage with its amplifiers."""

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from maglev.linear.equilibrium import mass_factors, present_masses
from maglev.linear.model import Equilibrium, LinearModel, Matrix
from maglev.linear.motors.forces import MotorForces
from maglev.linear.motors.places import MotorPlaces
from plant_fmu.ripple import RIPPLE_PHASE
from pmlsm.dq_transform import phase_currents
from pmlsm.rig import Rig


@np.errstate(over="ignore", invalid="ignore")   # what is no number is refused as such
def linear_plant(name: str, rig: Rig, block: Any, at: Equilibrium, phases: bool, amplifier: bool, forces: bool,
                 hold: float | None) -> LinearModel:
    """Linearise a stage about an equilibrium; see `maglev.linear.linearise.linearise` for arguments and contents."""
    axes, motors = len(rig.axes), len(rig.motors)
    places = MotorPlaces.of(rig, block)
    by_position, by_velocity, by_current = acceleration_slopes(rig, block, at)
    by_force = np.diag(1.0 / present_masses(rig, block))
    rotation = rotation_of(places, at)
    lags = [getattr(block, motor).amplifier.lag if amplifier else 0.0 for motor in rig.motor_names]
    lagged = [lag > 0.0 for lag in lags for _ in "dq"]
    # Commands seen in the frame of the mover: phase currents stay where they are while it moves. Those in d and q move
    # with it, unless they are held from sample to sample.
    turning = rotation if phases or hold is not None else np.zeros_like(rotation)
    rates = np.repeat([1.0 / lag if lag > 0.0 else 0.0 for lag in lags], 2)
    kept = [k for k, lag in enumerate(lagged) if lag]
    at_once = by_current @ np.diag([0.0 if lag else 1.0 for lag in lagged])

    motion = np.block([
        [np.zeros((axes, axes)), np.eye(axes), np.zeros((axes, 2 * motors))],
        [by_position + at_once @ turning, by_velocity, by_current - at_once],
        [rates[:, None] * turning, rotation * np.array(lagged)[:, None], -np.diag(rates)]])
    states = [*range(2 * axes), *(2 * axes + k for k in kept)]
    drive = np.vstack([np.zeros((axes, 2 * motors)), at_once, np.diag(rates)])
    push = np.vstack([np.zeros((axes, axes)), by_force, np.zeros((2 * motors, axes))])
    if phases:
        drive = drive @ park_matrix(at)

    state_units = {**{f"{axis.name}.position": axis.unit("m") for axis in rig.axes},
                   **{f"{axis.name}.velocity": axis.unit("m/s") for axis in rig.axes},
                   **{rig.dq_names[k]: "A" for k in kept}}
    commands = tuple(f"{current}_cmd" for current in (rig.phase_names if phases else rig.dq_names))
    external = {axis.external: axis.unit("N") for axis in rig.axes}
    names = tuple(state_units)
    # Where the platform tilts, its encoders are at the motors.
    gaps = tuple(f"{motor}.gap" for motor in rig.motor_names) if rig.rotations else ()
    seen = np.vstack([np.eye(axes), places.gaps[:len(gaps)]])
    model = LinearModel(name, names, (*commands, *external), (*names[:axes], *gaps), motion[np.ix_(states, states)],
                        np.hstack([drive, push])[states], np.hstack([seen, np.zeros((len(seen), len(states) - axes))]),
                        np.zeros((len(seen), len(commands) + axes)), {
                            **state_units, **external, **dict.fromkeys(gaps, "m"), **dict.fromkeys(commands, "A")},
                        None, at)
    if hold is not None:
        model = sampled(model, rotation, phases, hold)
    return model if forces else model.select(commands, model.outputs)


def acceleration_slopes(rig: Rig, block: Any, at: Equilibrium) -> tuple[Matrix, Matrix, Matrix]:
    """Derivatives of the accelerations of the axes with respect to positions, velocities and currents.

    Shapes (axes, axes), (axes, axes), (axes, 2 motors). The forces of the motors and the ripple are
    accelerations at the nominal masses.
    """
    factors, masses = mass_factors(rig, block)[:, None], present_masses(rig, block)
    by_position, by_current = MotorForces.of(rig, block).slopes(list(at.positions.values()), at.dq)
    for k, (name, position) in enumerate(at.positions.items()):
        ripple = getattr(block, name).ripple
        if ripple.amplitude != 0.0 and ripple.period > 0.0:
            wave = 2.0 * pi / ripple.period
            by_position[k, k] += ripple.amplitude * wave * np.cos(wave * position + RIPPLE_PHASE)
    by_position *= factors
    for tilt in rig.rotations:
        k, guide = rig.axis_names.index(tilt.name), getattr(block, f"{tilt.name}_guide")
        if abs(at.positions[tilt.name]) > guide.play:
            by_position[k, k] -= guide.stiffness / masses[k]
    by_velocity = np.diag([-getattr(block, axis).friction.viscous for axis in rig.axis_names] / masses)
    return by_position, by_velocity, factors * by_current


def rotation_of(places: MotorPlaces, at: Equilibrium) -> Matrix:
    """Derivatives of i_d, i_q with respect to the positions while the phase currents stay, A/m, (2 motors, axes).

    di_d/dx = π/τ i_q, di_q/dx = −π/τ i_d, with x the displacement of the motor.
    """
    rotation = np.zeros((2 * len(at.motors), len(at.positions)))
    rotation[0::2] = at.motor.wave_number * np.array(at.i_q)[:, None] * places.along
    rotation[1::2] = -at.motor.wave_number * np.array(at.i_d)[:, None] * places.along
    return rotation


def park_matrix(at: Equilibrium) -> Matrix:
    """Matrix of (2.1) from the phase currents of all motors to i_d, i_q at the positions, (2 motors, 3 motors)."""
    inverse = inverse_park_matrix(at)
    # The three columns of phases are 120° apart: inverseᵀ inverse = 3/2 I.
    return np.asarray(2.0 / 3.0 * inverse.T)


def inverse_park_matrix(at: Equilibrium) -> Matrix:
    """Matrix of (C.1) from i_d, i_q to the phase currents of all motors at the positions, (3 motors, 2 motors)."""
    angles = [at.motor.electrical_angle(along) for along in at.along]
    blocks = [np.array([phase_currents(1.0, 0.0, angle), phase_currents(0.0, 1.0, angle)]).T for angle in angles]
    return np.asarray(block_diag(*blocks))


def sampled(model: LinearModel, rotation: Matrix, phases: bool, hold: float) -> LinearModel:
    """Hold the phase currents between samples; commands in d and q are turned into them by the displacement sampled."""
    held = model.discretise(hold)
    if phases:
        return held
    commutation = np.zeros((len(held.inputs), len(held.outputs)))
    commutation[:len(rotation), :rotation.shape[1]] = -rotation
    return replace(held, A=held.A + held.B @ commutation @ held.C, commutation=commutation)
