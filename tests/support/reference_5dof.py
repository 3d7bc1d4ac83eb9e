"""The equations of motion of the 5-DOF stage with numpy, for an accurate solver; nothing is shared with the blocks.

Coordinates y, x, z, roll, pitch. A motor's air gap is linear in them, and so is its displacement: the rows of GAPS and
of DISPLACEMENTS, whose transposes take the motors' forces to forces and torques on the coordinates.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sin

import numpy as np
from reference_stage import LAG, T1, Crossing, G, ReferenceAxis, limited, park_matrix, shape_functions
from scipy.integrate import solve_ivp

ARM, HEIGHT = 0.2, -0.03
GAPS = np.array([[1, 0, 0, -ARM, 0], [1, 0, 0, ARM, 0], [1, 0, 0, 0, ARM], [1, 0, 0, 0, -ARM]])
DISPLACEMENTS = np.array([[0, 1, 0, 0, -HEIGHT]] * 2 + [[0, 0, 1, HEIGHT, 0]] * 2)
LOWER, UPPER, STOP_K, STOP_C = 18.5e-3, 32e-3, 1e5, 375.0
NOMINAL = np.array([6.9, 10.6, 8.6, 0.2, 0.2])
THRUST, ATTRACTION, COILS, IRON = (0.6135, 0.8224), 334.52, 8.71, 0.0045
PEAK = 5.0


@dataclass
class Reference5DOF:
    """The stage with a payload (kg, m, m) and guides against the tilts (N m/rad, rad)."""

    modulation: float = 0.0135
    payload: tuple[float, float, float] = (0.0, 0.0, 0.0)
    guide: tuple[float, float] = (0.0, 0.0)
    push: tuple[float, ...] = (0.0,) * 5

    def __post_init__(self) -> None:
        free = {"lower": -1.0, "upper": 1.0}
        rows = [(0.1, 1.0, 0.5e-3, 2.0, 0.15, 5e-3), *((0.05, coulomb, 0.5e-3, 2.0, 0.0, T1) for coulomb in (1.2, 1.1)),
                *[(0.0, 0.02, 1e-3, 0.02, 0.0, T1)] * 2]
        p, a, b = self.payload
        self.masses = NOMINAL + p * np.array([1.0, 1.0, 1.0, b**2, a**2])
        self.axes = [ReferenceAxis(m, bias, coulomb, presliding, viscous, **free, ripple=ripple * n / m, period=period,
                                   force=push)
                     for m, n, push, (bias, coulomb, presliding, viscous, ripple, period)
                     in zip(self.masses, NOMINAL, self.push, rows, strict=True)]

    def forces(self, q: np.ndarray, rate: np.ndarray, currents: np.ndarray) -> np.ndarray:
        """Forces and torques on the coordinates by motors, their stops, payload and guides, shape (5,)."""
        p, a, b = self.payload
        k, play = self.guide
        normal, thrust = self.motors(q, currents)
        for i, (gap, speed) in enumerate(zip(GAPS @ q, GAPS @ rate, strict=True)):
            if gap > UPPER:
                normal[i] -= max(0.0, STOP_K * (gap - UPPER) + STOP_C * speed)
            if gap < LOWER:
                normal[i] += max(0.0, STOP_K * (LOWER - gap) - STOP_C * speed)
        found: np.ndarray = GAPS.T @ normal + DISPLACEMENTS.T @ thrust
        held = -k * np.sign(q[3:]) * np.maximum(np.abs(q[3:]) - play, 0.0)
        found += np.array([self.masses[0] * G, 0.0, 0.0, held[0] - p * G * b, held[1] + p * G * a])
        return found

    def motors(self, q: np.ndarray, currents: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Normal forces and thrusts (N) of the motors under phase currents, shape (4, 3)."""
        normal, thrust = np.empty(4), np.empty(4)
        for i, (gap, d) in enumerate(zip(GAPS @ q, DISPLACEMENTS @ q, strict=True)):
            f1, f2, f3, f4 = shape_functions(gap)
            i_d, i_q = park_matrix(d) @ currents[i]
            pull = ATTRACTION * f2 * (1 - self.modulation * sin(pi * d / T1)**2)
            normal[i] = NOMINAL[0] * (COILS * f3 * i_d - IRON * f4 * (i_d**2 + i_q**2) - pull)
            thrust[i] = -NOMINAL[1 + i // 2] * THRUST[i // 2] * f1 * i_q
        return normal, thrust

    def rates(self, state: np.ndarray, commands: np.ndarray) -> np.ndarray:
        """Rates of positions, velocities, deflections (5 each) and phase currents (4, 3)."""
        q, v, w = state[:15].reshape(3, 5)
        currents = state[15:].reshape(4, 3)
        by_motors = self.forces(q, v, currents) / self.masses
        others = [axis.acceleration(*each) for axis, *each in zip(self.axes, q, v, w, strict=True)]
        deflection = [axis.deflection_rate(*each) for axis, *each in zip(self.axes, v, w, strict=True)]
        return np.concatenate([v, by_motors + others, deflection,
                               ((limited(commands, -PEAK, PEAK) - currents) / LAG).ravel()])

    def solve(self, start: np.ndarray, commands: Callable[[int], np.ndarray], dt: float, steps: int) -> np.ndarray:
        """Positions at every communication point, shape (steps + 1, 5).

        The solver starts again where a velocity changes its sign, a motor meets a stop, or a stop lets go.
        """
        state = np.concatenate([start, np.zeros(10), np.clip(commands(0), -PEAK, PEAK).ravel()])
        found = [start]

        def crossings(s: np.ndarray) -> np.ndarray:
            gaps, speeds = GAPS @ s[:5], GAPS @ s[5:10]
            guides = np.concatenate([s[3:5] - self.guide[1], s[3:5] + self.guide[1]]) if self.guide[0] else np.empty(0)
            return np.concatenate([s[5:10], gaps - LOWER, gaps - UPPER, STOP_K * (gaps - UPPER) + STOP_C * speeds,
                                   STOP_K * (LOWER - gaps) - STOP_C * speeds, guides])

        def crossing(i: int) -> Crossing:
            return Crossing(lambda s: crossings(s)[i])

        events = [crossing(i) for i in range(len(crossings(state)))]
        for k in range(steps):
            held, t, end = commands(k), k * dt, (k + 1) * dt
            while t < end:
                solution = solve_ivp(lambda _, s: self.rates(s, held), (t, end), state, method="DOP853",   # noqa: B023
                                     rtol=1e-11, atol=1e-14, events=events)
                state, t = solution.y[:, -1], solution.t[-1]
                if solution.status == 1:
                    after = min(1e-9, end - t)   # off the event, so that it is not found again
                    state, t = state + after * self.rates(state, held), t + after
            found.append(state[:5])
        return np.array(found)
