"""Forces of the motors with their slopes."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cosh, pi, sin, sinh
from typing import Any

import numpy as np

from maglev.arrays import Array
from maglev.linear.motors.places import MotorPlaces
from plant_fmu.attraction import attraction_factor
from plant_fmu.magnets import magnet_strength
from pmlsm.gap_functions import carter_coefficient, gap_functions, slot_permeance
from pmlsm.gap_slopes import carter_slope, gap_slopes, slot_permeance_slope
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.rig import Rig


@dataclass(frozen=True)
class MotorForces:
    """Accelerations by the motors, gravity apart, at the nominal masses (4.3), (5.3).

    Of each motor, at its own gap and with its own currents:

    vertical:    coils f3 i_d − iron f4 (i_q² + i_d²) − attraction f2 (1 − k sin²(π d/t1))
    horizontal:  − thrust f1 i_q

    What they do to the axes say the motors' places.
    """

    attraction: float                 # m/(s² T²), constants of one motor, or of those that share its current
    coils: float                      # m/(s² A T)
    iron: float                       # m/(s² A²)
    thrusts: tuple[float, ...]        # m/(s² A), of each motor
    motor: MotorGeometry
    places: MotorPlaces
    modulation: float = 0.0           # k

    @classmethod
    def of(cls, rig: Rig, block: Any) -> "MotorForces":
        """Forces with the constants that a plant or controller of a rig has."""
        def values(axis: str) -> list[float]:
            return [rig.sharing * getattr(block, name) for name in rig.constants_of(axis)]

        attraction, coils, iron = values(rig.vertical.name)
        strength = magnet_strength(getattr(block, "magnet_rise", 0.0))   # a controller's model has none
        return cls(attraction * strength**2, coils * strength, iron,
                   tuple(thrust * strength for motor in rig.motors for thrust in values(motor.drives)),
                   block.geometry, MotorPlaces.of(rig, block), getattr(block, "attraction_modulation", 0.0))

    def accelerations(self, positions: Sequence[float], currents: Array) -> Array:
        """Accelerations of the axes (m/s²), shape (axes,), with i_d and i_q of each motor in turn (A)."""
        return np.asarray(self.places.effects @ self.of_motors(positions, currents)[0])

    def slopes(self, positions: Sequence[float], currents: Array) -> tuple[Array, Array]:
        """Derivatives of the accelerations with respect to positions and currents.

        Parameters
        ----------
        positions : sequence of float
            Of each axis, the vertical one first, m.
        currents : ndarray, shape (2 motors,)
            i_d and i_q of each motor in turn, A.

        Returns
        -------
        by_position : ndarray, shape (axes, axes)
            1/s².
        by_current : ndarray, shape (axes, 2 motors)
            m/(s² A).
        """
        _, by_gap, by_slot, by_current = self.of_motors(positions, currents)
        gaps, slots = (np.repeat(rows, 2, axis=0) for rows in (self.places.gaps, self.places.slots))
        effects = self.places.effects
        return effects @ (by_gap[:, None] * gaps + by_slot[:, None] * slots), effects @ by_current

    def of_motors(self, positions: Sequence[float], currents: Array) -> tuple[Array, Array, Array, Array]:
        """Vertical and horizontal acceleration by each motor in turn, f, with its derivatives.

        Returns
        -------
        f, by_gap, by_slot : ndarray, shape (2 motors,)
            m/s², and 1/s² by the motor's own gap and by its displacement along the slots.
        by_current : ndarray, shape (2 motors, 2 motors)
            m/(s² A).
        """
        n = len(self.thrusts)
        f, by_gap, by_slot, by_current = np.zeros(2 * n), np.zeros(2 * n), np.zeros(2 * n), np.zeros((2 * n, 2 * n))
        places, pitch = self.places, self.motor.slot_pitch
        for k, (gap, along, thrust) in enumerate(zip((places.gaps @ positions).tolist(),
                                                     (places.slots @ positions).tolist(), self.thrusts, strict=True)):
            v, h = 2 * k, 2 * k + 1
            i_d, i_q = float(currents[v]), float(currents[h])
            f1, f2, f3, f4 = gap_functions(self.motor, gap)
            slope2, slope3, slope4 = gap_slopes(self.motor, gap)
            modulated, squares = attraction_factor(self.modulation, along, pitch), i_d * i_d + i_q * i_q
            f[v] = self.coils * f3 * i_d - self.iron * f4 * squares - self.attraction * f2 * modulated
            f[h] = -thrust * f1 * i_q
            by_gap[v] = self.coils * slope3 * i_d - self.iron * slope4 * squares - self.attraction * slope2 * modulated
            by_gap[h] = -thrust * thrust_slope(self.motor, gap) * i_q
            # d/dx of −k sin²(π x/t1)
            by_slot[v] = self.attraction * f2 * self.modulation * pi / pitch * sin(2.0 * pi * along / pitch)
            by_current[v, v] = self.coils * f3 - 2.0 * self.iron * f4 * i_d
            by_current[v, h] = -2.0 * self.iron * f4 * i_q
            by_current[h, h] = -thrust * f1
        return f, by_gap, by_slot, by_current


def thrust_slope(motor: MotorGeometry, gap: float) -> float:
    """Slope df1/dg (1/m) of the thrust function f1 = λ / (Kc sinh a) at an air gap (m) in the range of the field."""
    f1, _, _, _ = gap_functions(motor, gap)
    a = motor.wave_number * (motor.magnet_height + gap)
    return f1 * (slot_permeance_slope(motor, gap) / slot_permeance(motor, gap)
                 - carter_slope(motor, gap) / carter_coefficient(motor, gap) - motor.wave_number * cosh(a) / sinh(a))
