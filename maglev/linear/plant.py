"""Linear model of a stage with its amplifiers."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from maglev.arrays import Array
from maglev.linear.equilibrium import mass_factors, present_masses
from maglev.linear.model import Equilibrium, LinearModel
from maglev.linear.motors.forces import MotorForces
from maglev.linear.motors.places import MotorPlaces
from plant_fmu.flexible_mode import FlexibleMode
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
    motion, drives = motion[np.ix_(states, states)], np.hstack([drive, push])[states]
    modes = {k: getattr(block, axis).mode for k, axis in enumerate(rig.axis_names)
             if getattr(block, axis).mode.frequency > 0.0}
    motion, drives = with_modes(motion, drives, {axes + k: mode for k, mode in modes.items()})

    state_units = {**{f"{axis.name}.position": axis.unit("m") for axis in rig.axes},
                   **{f"{axis.name}.velocity": axis.unit("m/s") for axis in rig.axes},
                   **{rig.dq_names[k]: "A" for k in kept},
                   **{f"{rig.axis_names[k]}.mode.{name}": rig.axes[k].unit(unit) for k in modes
                      for name, unit in (("deflection", "m"), ("rate", "m/s"))}}
    commands = tuple(f"{current}_cmd" for current in (rig.phase_names if phases else rig.dq_names))
    external = {axis.external: axis.unit("N") for axis in rig.axes}
    names = tuple(state_units)
    # Where the platform tilts, its encoders are at the motors.
    gaps = tuple(f"{motor}.gap" for motor in rig.motor_names) if rig.rotations else ()
    seen = np.vstack([np.eye(axes), places.gaps[:len(gaps)]])
    seen = np.hstack([seen, np.zeros((len(seen), len(names) - axes))])
    encoders = by_encoders(rig, places, modes, names)
    seen = np.vstack([seen, *encoders.values()])
    units = {**state_units, **external, **dict.fromkeys(gaps, "m"), **dict.fromkeys(encoders, "m"),
             **dict.fromkeys(commands, "A")}
    model = LinearModel(name, names, (*commands, *external), (*names[:axes], *gaps, *encoders), motion, drives, seen,
                        np.zeros((len(seen), len(commands) + axes)), units, None, at)
    if hold is not None:
        model = sampled(model, rotation @ measuring(rig, places, model.outputs), phases, hold)
    return model if forces else model.select(commands, model.outputs)


def with_modes(motion: Array, drives: Array, modes: Mapping[int, FlexibleMode]) -> tuple[Array, Array]:
    """Add deflection and rate of flexible modes as states, by the rows of the accelerations that they change.

    p'' = a/(1 − μ) + μ e, r'' = −a/(1 − μ) − e with e = ω² r + 2 ζ ω r'; a is the row of a rigid mover.
    """
    n = len(motion)
    motion = np.pad(motion, (0, 2 * len(modes)))
    drives = np.pad(drives, ((0, 2 * len(modes)), (0, 0)))
    for k, (row, mode) in enumerate(modes.items()):
        r, rate, omega = n + 2 * k, n + 2 * k + 1, 2.0 * pi * mode.frequency
        pull = np.zeros(len(motion))
        pull[r], pull[rate] = omega**2, 2.0 * mode.damping * omega
        for matrix in (motion, drives):
            matrix[row] /= 1.0 - mode.mass_share
            matrix[rate] = -matrix[row]
        motion[rate] -= pull
        motion[row] += mode.mass_share * pull
        motion[r, rate] = 1.0
    return motion, drives


def by_encoders(rig: Rig, places: MotorPlaces, modes: Mapping[int, FlexibleMode],
                states: Sequence[str]) -> dict[str, Array]:
    """What encoders measure by the states, by name, where it is not the position or the gap: they see a mode."""
    shares = np.zeros((len(rig.axes), len(states)))
    for k, mode in modes.items():
        shares[k, states.index(f"{rig.axis_names[k]}.mode.deflection")] = mode.encoder_share
    found = {f"{axis.name}.encoder": (rig.axes.index(axis), shares[rig.axes.index(axis)]) for axis in rig.measured}
    rows = {name: np.eye(len(rig.axes), len(states))[k] + share for name, (k, share) in found.items() if share.any()}
    if rig.rotations and (places.gaps @ shares).any():
        seen = places.gaps @ (np.eye(len(rig.axes), len(states)) + shares)
        rows |= {f"{motor}.gap_encoder": row for motor, row in zip(rig.motor_names, seen, strict=True)}
    return rows


def measuring(rig: Rig, places: MotorPlaces, outputs: Sequence[str]) -> Array:
    """Positions that a controller commutates with by the outputs, (axes, outputs): the true ones, or by encoders."""
    found = np.eye(len(rig.axes), len(outputs))
    if f"{rig.motor_names[0]}.gap_encoder" in outputs:
        first = outputs.index(f"{rig.motor_names[0]}.gap_encoder")
        found[:] = 0.0
        found[:, first:first + len(rig.motors)] = np.linalg.pinv(places.gaps)
    for k, axis in enumerate(rig.axis_names):
        if f"{axis}.encoder" in outputs or axis in [each.name for each in rig.measured]:
            found[k] = 0.0
            found[k, outputs.index(f"{axis}.encoder") if f"{axis}.encoder" in outputs else k] = 1.0
    return found


def acceleration_slopes(rig: Rig, block: Any, at: Equilibrium) -> tuple[Array, Array, Array]:
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


def rotation_of(places: MotorPlaces, at: Equilibrium) -> Array:
    """Derivatives of i_d, i_q with respect to the positions while the phase currents stay, A/m, (2 motors, axes).

    di_d/dx = π/τ i_q, di_q/dx = −π/τ i_d, with x the displacement of the motor.
    """
    rotation = np.zeros((2 * len(at.motors), len(at.positions)))
    rotation[0::2] = at.motor.wave_number * np.array(at.i_q)[:, None] * places.along
    rotation[1::2] = -at.motor.wave_number * np.array(at.i_d)[:, None] * places.along
    return rotation


def park_matrix(at: Equilibrium) -> Array:
    """Matrix of (2.1) from the phase currents of all motors to i_d, i_q at the positions, (2 motors, 3 motors)."""
    inverse = inverse_park_matrix(at)
    # The three columns of phases are 120° apart: inverseᵀ inverse = 3/2 I.
    return np.asarray(2.0 / 3.0 * inverse.T)


def inverse_park_matrix(at: Equilibrium) -> Array:
    """Matrix of (C.1) from i_d, i_q to the phase currents of all motors at the positions, (3 motors, 2 motors)."""
    angles = [at.motor.electrical_angle(along) for along in at.along]
    blocks = [np.array([phase_currents(1.0, 0.0, angle), phase_currents(0.0, 1.0, angle)]).T for angle in angles]
    return np.asarray(block_diag(*blocks))


def sampled(model: LinearModel, rotation: Array, phases: bool, hold: float) -> LinearModel:
    """Hold the phase currents between samples; commands in d and q are turned into them by the displacement sampled.

    `rotation` is that of i_d, i_q by the outputs, A/m, shape (2 motors, outputs).
    """
    held = model.discretise(hold)
    if phases:
        return held
    commutation = np.zeros((len(held.inputs), len(held.outputs)))
    commutation[:len(rotation)] = -rotation
    return replace(held, A=held.A + held.B @ commutation @ held.C, commutation=commutation)
