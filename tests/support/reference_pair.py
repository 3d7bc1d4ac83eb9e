"""Two motors side by side that carry, drive and tilt a platform, by virtual work, for an accurate solver."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, sin

import numpy as np
from reference_stage import G
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class ReferenceMotor:
    """A motor at z (m) of the platform, with its forces (N) by gap and displacement (m), i_d and i_q (A)."""

    z: float
    pole_pitch: float
    forces: Callable[[float, float, float, float], tuple[float, float]]   # downwards, and along h

    def park(self, displacement: float) -> np.ndarray:
        """Matrix of (2.1) with the offset of (4.4), shape (2, 3)."""
        angles = (np.pi / self.pole_pitch * (displacement - self.pole_pitch / 2)
                  + np.array([0, -2 * np.pi / 3, 2 * np.pi / 3]))
        return np.asarray(2 / 3 * np.array([np.cos(angles), -np.sin(angles)]))


def sheet_forces(geometry: dict[str, float], field: tuple[float, float], sheet: dict[str, float],
                 modulation: float) -> Callable[[float, float, float, float], tuple[float, float]]:
    """Forces of a motor by its drawing and its data sheet: shape functions (2.2), (2.4) times what is printed at a gap.

    The field is so large (T) at the magnets and decays over a distance (m).
    What the sheet leaves out follows by virtual work, and by fields that add before they are squared.
    """
    b0, t1, tau, hm = (geometry[key] for key in ("slot_width", "slot_pitch", "pole_pitch", "magnet_height"))

    def shapes(g: float) -> tuple[float, float, float, float]:
        lam = 1 - b0**2 / (4 * t1 * (g + b0 / 2 + hm / 1.05))
        u = b0 / (2 * g)
        kc = t1 / (t1 - g * 4 / np.pi * (u * np.arctan(u) - np.log(np.sqrt(1 + u**2))))
        a, b = np.pi / tau * (hm + g), field[0] * np.exp(-g / field[1])
        return lam / (kc * np.sinh(a)), lam * b**2, lam * b / np.tanh(a) / kc, lam / np.tanh(a)**2 / kc**2

    at, f = sheet["at"], shapes(sheet["at"])
    thrust = sheet["force_constant"] / f[0]
    attraction = sheet["attraction"] / shapes(sheet["attraction_gap"])[1]
    coils = sheet.get("direct_constant", sheet["force_constant"] / np.tanh(np.pi / tau * (hm + at))) / f[2]
    iron = sheet["iron_attraction"] / f[3] if "iron_attraction" in sheet else coils**2 / (4 * attraction)

    def forces(gap: float, along: float, i_d: float, i_q: float) -> tuple[float, float]:
        f1, f2, f3, f4 = shapes(gap)
        slots = 1 - modulation * np.sin(np.pi * along / t1)**2
        return coils * f3 * i_d - iron * f4 * (i_d**2 + i_q**2) - attraction * f2 * slots, -thrust * f1 * i_q

    return forces


def lagrangian_motion(inertias: Sequence[float], height: float, payload: tuple[float, float],
                      motors: Sequence[ReferenceMotor], start: np.ndarray, currents: np.ndarray, times: np.ndarray
                      ) -> np.ndarray:
    """Positions v, h, roll under constant phase currents, (motors, 3), by virtual work; shape (times, 3).

    The platform, of two masses and an inertia, is a body that turns about h: a motor's face is a point of it, and a
    force's share of a coordinate is the way that the point goes along the force when the coordinate changes, by
    differences. A payload (kg) lies at a place (m) across h.
    """
    load, offset = payload
    present = np.array(inertias) + load * np.array([1.0, 1.0, offset**2])

    def point(q: np.ndarray, z: float, low: float) -> np.ndarray:
        """Where a point of the platform is: downwards, along h."""
        v, h, roll = q
        return np.array([v - z * sin(roll) + low * (cos(roll) - 1.0), h])

    def share(q: np.ndarray, z: float, low: float) -> np.ndarray:
        """Ways of the point by the coordinates, without tilt: its small angles are those of the model."""
        level = np.array([q[0], q[1], 0.0])
        return np.column_stack([(point(level + d, z, low) - point(level - d, z, low)) / 2e-6 for d in 1e-6 * np.eye(3)])

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        q = state[:3]
        force = np.array([inertias[0] * G, 0.0, 0.0]) + load * G * share(q, offset, 0.0)[0]
        for motor, phases in zip(motors, currents, strict=True):
            ways = share(q, motor.z, height)
            gap, along = q[0] + ways[0, 2] * q[2], q[1]
            force = force + ways.T @ motor.forces(gap, along, *(motor.park(along) @ phases))
        return np.concatenate([state[3:], force / present])

    found = solve_ivp(rates, (0.0, times[-1]), np.concatenate([start, np.zeros(3)]), method="DOP853", t_eval=times,
                      rtol=1e-11, atol=1e-14)
    return np.asarray(found.y[:3].T)
