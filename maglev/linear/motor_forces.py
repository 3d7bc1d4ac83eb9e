"""Forces of the motors with their slopes."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cosh, pi, sin, sinh
from typing import Any

import numpy as np

from maglev.linear.model import Matrix
from plant_fmu.attraction import attraction_factor
from pmlsm.gap_functions import carter_coefficient, gap_functions, slot_permeance
from pmlsm.gap_slopes import carter_slope, gap_slopes, slot_permeance_slope
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.rig import Rig


@dataclass(frozen=True)
class MotorForces:
    """Accelerations by the motors, gravity apart, at the nominal masses (4.3), (5.3).

    vertical:    coils f3 Σ i_d − iron f4 Σ (i_q² + i_d²) − attraction f2 (1 − k sin²(π d/t1))
    horizontal:  − thrust f1 i_q, one for each motor

    with sums over the motors and d the first horizontal displacement.
    """

    attraction: float                 # m/(s² T²)
    coils: float                      # m/(s² A T)
    iron: float                       # m/(s² A²)
    thrusts: tuple[float, ...]        # m/(s² A)
    drives: tuple[int, ...]           # number, among the axes, of that which each motor drives
    motor: MotorGeometry
    modulation: float = 0.0           # k

    @classmethod
    def of(cls, rig: Rig, block: Any) -> "MotorForces":
        """Forces with the constants that a plant or controller of a rig has."""
        def values(axis: str) -> list[float]:
            return [getattr(block, name) for name in rig.constants_of(axis)]

        attraction, coils, iron = values(rig.vertical.name)
        thrusts = tuple(rig.sharing * thrust for motor in rig.motors for thrust in values(motor.drives))
        return cls(rig.carrying * attraction, rig.sharing * coils, rig.sharing * iron, thrusts, rig.driven,
                   block.geometry, getattr(block, "attraction_modulation", 0.0))

    def slopes(self, positions: Sequence[float], i_d: Sequence[float], i_q: Sequence[float]) -> tuple[Matrix, Matrix]:
        """Derivatives of the accelerations with respect to positions and currents.

        Parameters
        ----------
        positions : sequence of float
            Of the vertical axis, then of the horizontal ones, m.
        i_d, i_q : sequence of float
            Of each motor, A.

        Returns
        -------
        by_position : ndarray, shape (axes, axes)
            1/s².
        by_current : ndarray, shape (axes, 2 motors)
            m/(s² A), the columns i_d and i_q of each motor in turn.
        """
        gap, displacement = positions[0], positions[1]
        f1, f2, f3, f4 = gap_functions(self.motor, gap)
        slope2, slope3, slope4 = gap_slopes(self.motor, gap)
        slope1 = thrust_slope(self.motor, gap)
        modulated = attraction_factor(self.modulation, displacement, self.motor.slot_pitch)
        squares = sum(d * d + q * q for d, q in zip(i_d, i_q, strict=True))
        by_position = np.zeros((len(positions), len(positions)))
        by_current = np.zeros((len(positions), 2 * len(i_d)))
        by_position[0, 0] = (self.coils * slope3 * sum(i_d) - self.iron * slope4 * squares
                             - self.attraction * slope2 * modulated)
        # d/dx of −k sin²(π x/t1)
        by_position[0, 1] = self.attraction * f2 * self.modulation * pi / self.motor.slot_pitch * sin(
            2.0 * pi * displacement / self.motor.slot_pitch)
        for motor, (axis, thrust) in enumerate(zip(self.drives, self.thrusts, strict=True)):
            by_current[0, 2 * motor] = self.coils * f3 - 2.0 * self.iron * f4 * i_d[motor]
            by_current[0, 2 * motor + 1] = -2.0 * self.iron * f4 * i_q[motor]
            by_position[axis, 0] -= thrust * slope1 * i_q[motor]
            by_current[axis, 2 * motor + 1] = -thrust * f1
        return by_position, by_current


def thrust_slope(motor: MotorGeometry, gap: float) -> float:
    """Slope df1/dg (1/m) of the thrust function f1 = λ / (Kc sinh a) at an air gap (m) in the range of the field."""
    f1, _, _, _ = gap_functions(motor, gap)
    a = motor.wave_number * (motor.magnet_height + gap)
    return f1 * (slot_permeance_slope(motor, gap) / slot_permeance(motor, gap)
                 - carter_slope(motor, gap) / carter_coefficient(motor, gap) - motor.wave_number * cosh(a) / sinh(a))
