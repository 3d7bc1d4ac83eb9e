"""Gains of a stage from poles, or scaled from those of the rig that all begin with."""

from collections.abc import Sequence
from math import inf, pi, sqrt
from typing import Any

import numpy as np

from controller_fmu.linearisation import Linearisation
from maglev.errors import RigError
from maglev.linear.design import gains_of, regulator_polynomial
from maglev.linear.places import MotorPlaces
from maglev.own_stage.digits import kept
from pmlsm.gap_functions import gap_functions
from pmlsm.rig import Rig
from pmlsm.rigs import EXAMPLE, RIGS

LIKE = RIGS[EXAMPLE]   # whose gains are scaled

MOST_QUICK = 2.0    # horizontal design against that of the 3-DOF stage; beyond, sampling and observer count

OMEGA0 = 1.5 * pi   # rad/s, of the internal models


def gains_of_poles(place: str, given: Any) -> list[float]:
    """Gains k1…k5 that place five poles: real ones as numbers, a pair as [real, imaginary part] (rad/s).

    RigError if there are not five, or one is not on the left.
    """
    poles: list[complex] = []
    for each in given if isinstance(given, list) else []:
        pair = each if isinstance(each, list) else [each, None]
        if len(pair) != 2 or not all(isinstance(part, (int, float)) or part is None for part in pair):
            poles = []
            break
        poles += [pair[0]] if pair[1] is None else [complex(*pair), complex(pair[0], -pair[1])]
    if len(poles) != 5 or any(complex(pole).real >= 0.0 for pole in poles):
        raise RigError(f"{place}: {given!r}, expected five poles with real parts below 0, such as "
                       "[-90, [-4, 6], [-2, 2]]: a number, or real and imaginary part of a pair")
    return [kept(gain) for gain in gains_of(np.poly(np.array(poles)).real.tolist(), OMEGA0)]


def scaled_gains(gains: Sequence[float], factor: float) -> tuple[float, ...]:
    """Gains with all poles times a factor."""
    polynomial = regulator_polynomial(gains, OMEGA0)
    return tuple(kept(gain) for gain in gains_of((polynomial * factor ** np.arange(6)).tolist(), OMEGA0))


def unstable_rate(rig: Rig, axis: str = "") -> float:
    """Rate (1/s) with which the mover leaves its start, where the model's motors hold it, if nothing controls it.

    Along the air gap, or a tilt of it. RigError if no direct current holds it there.
    """
    of, motor, gap = rig.model, rig.motor(), rig.vertical.start
    linear = Linearisation()
    attraction, coils, iron = (rig.carrying * each for each in (of.attraction, of.coils, of.iron))
    if not linear.prepare(motor, attraction, coils, iron, gap):
        attracted = attraction * gap_functions(motor, gap)[1]
        raise RigError(f"no direct current holds the mover of {rig.vertical.mass:g} kg at {1e3 * gap:g} mm: without "
                       f"one the motors attract it by {attracted:.3g} m/s², gravity takes 9.81 m/s², expected another "
                       "gap, mass or attraction")
    places, k = MotorPlaces.of(rig), rig.axis_names.index(axis or rig.vertical.name)
    ratio = float(places.effects[k, 0::2] @ places.gaps[:, k]) / len(rig.motors)   # of what all do to the air gap
    return sqrt(max(linear.stiffness * ratio, 1e-6))


def strongest(rig: Rig, axis: str) -> float:
    """Acceleration (m/s²) of a horizontal axis by its motors at the start gap and the current that they may have."""
    f1, _, _, _ = gap_functions(rig.motor(), rig.vertical.start)
    motors = rig.motors_of(axis)
    return rig.sharing * rig.model.thrust[axis] * f1 * sum(
        min(each.amplifier.continuous or each.amplifier.peak, rig.design.current_limit or inf) for each in motors)


def quickness(rig: Rig, axis: str) -> float:
    """How much faster than on the 3-DOF stage the design of an axis is to be.

    Air gap and tilts by the rate at which the mover leaves its start, a horizontal axis by the root of what its motors
    can accelerate, and at most twice.
    """
    if axis not in [each.name for each in rig.horizontal]:
        return unstable_rate(rig, axis) / unstable_rate(LIKE)
    return min(sqrt(strongest(rig, axis) / strongest(LIKE, LIKE.horizontal[0].name)), MOST_QUICK)
