"""The two stages as the linear models see them: axes, motors, and the forces of the motors with their slopes."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cosh, pi, sin, sinh
from typing import Any

import numpy as np

from maglev.linear.model import Matrix
from plant_fmu.attraction import attraction_factor
from pmlsm.data_sheet import MAGNET_HEIGHT, MOTORS_3DOF, MOTORS_IN_PAIR, POLE_PITCH, SLOT_PITCH
from pmlsm.gap_functions import carter_coefficient, gap_functions, slot_permeance
from pmlsm.gap_slopes import carter_slope, gap_slopes, slot_permeance_slope
from pmlsm.rigs import RIGS as DESCRIPTIONS


@dataclass(frozen=True)
class Rig:
    """A stage: its vertical axis, and for each motor, or pair of motors, the horizontal axis that it drives."""

    vertical: str
    horizontals: tuple[str, ...]
    motors: tuple[str, ...]

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes, the vertical one first."""
        return (self.vertical, *self.horizontals)

    @property
    def dq_names(self) -> tuple[str, ...]:
        """Direct and quadrature current of each motor in turn."""
        return tuple(f"{motor}.i_{component}" for motor in self.motors for component in ("d", "q"))

    @property
    def phase_names(self) -> tuple[str, ...]:
        """Three phase currents of each motor in turn."""
        return tuple(f"{motor}.i_{phase}" for motor in self.motors for phase in ("a", "b", "c"))


RIGS = {name.upper(): Rig(rig.vertical.name, rig.axis_names[1:], rig.motor_names)
        for name, rig in DESCRIPTIONS.items()}


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
    modulation: float = 0.0           # k

    @classmethod
    def of(cls, block: Any) -> "MotorForces":
        """Forces with the constants of a plant or controller; a 3-DOF one has C5."""
        modulation = getattr(block, "attraction_modulation", 0.0)
        if hasattr(block, "C5"):
            return cls(MOTORS_3DOF * block.C3, MOTORS_IN_PAIR * block.C4, MOTORS_IN_PAIR * block.C5,
                       (MOTORS_IN_PAIR * block.C1, MOTORS_IN_PAIR * block.C2), modulation)
        return cls(block.C2, block.C3, block.C4, (block.C1,), modulation)

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
        f1, f2, f3, f4 = gap_functions(gap)
        slope2, slope3, slope4 = gap_slopes(gap)
        slope1 = thrust_slope(gap)
        squares = sum(d * d + q * q for d, q in zip(i_d, i_q, strict=True))
        by_position = np.zeros((len(positions), len(positions)))
        by_current = np.zeros((len(positions), 2 * len(i_d)))
        by_position[0, 0] = (self.coils * slope3 * sum(i_d) - self.iron * slope4 * squares
                             - self.attraction * slope2 * attraction_factor(self.modulation, displacement))
        # d/dx of −k sin²(π x/t1)
        by_position[0, 1] = self.attraction * f2 * self.modulation * pi / SLOT_PITCH * sin(
            2.0 * pi * displacement / SLOT_PITCH)
        for motor, thrust in enumerate(self.thrusts):
            by_current[0, 2 * motor] = self.coils * f3 - 2.0 * self.iron * f4 * i_d[motor]
            by_current[0, 2 * motor + 1] = -2.0 * self.iron * f4 * i_q[motor]
            by_position[1 + motor, 0] = -thrust * slope1 * i_q[motor]
            by_current[1 + motor, 2 * motor + 1] = -thrust * f1
        return by_position, by_current


def thrust_slope(gap: float) -> float:
    """Slope df1/dg (1/m) of the thrust function f1 = λ / (Kc sinh a) at an air gap of 8…40 mm (m)."""
    f1, _, _, _ = gap_functions(gap)
    a = pi / POLE_PITCH * (MAGNET_HEIGHT + gap)
    return f1 * (slot_permeance_slope(gap) / slot_permeance(gap) - carter_slope(gap) / carter_coefficient(gap)
                 - pi / POLE_PITCH * cosh(a) / sinh(a))
