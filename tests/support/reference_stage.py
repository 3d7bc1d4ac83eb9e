"""The equations of motion of both stages, written again from the page, for an accurate solver.

Nothing here is shared with the blocks: constants are typed again, the dq transform is the printed matrix, and the lag
of
the amplifiers is a differential equation like the others. Numbers of one axis are no arrays: numpy takes ten times as
long for them, and the solver asks thousands of times.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import reduce
from math import atan, cos, log, pi, sin, sinh, sqrt, tanh

import numpy as np
from scipy.integrate import solve_ivp

B0, T1, HM, TAU, MU_REC, G = 12.7e-3, 19.05e-3, 5e-3, 57.15e-3, 1.05, 9.81
FIELD = [0.08063180815083942, -0.10193303675188958, 0.059845610577103754, -0.02135418663882956, 0.005047294856769541,
         -0.0007904078321495497, 7.086337942227495e-05, 4.431632232147665e-08, -1.014432002730224e-06,
         1.4195702585893311e-07, -6.403219303184752e-09, -7.528843720102103e-10, 1.3611197230058667e-10]
LAG = 0.3e-3
STOP_K, STOP_C = 4e5, 1500.0


def shape_functions(gap: float) -> tuple[float, float, float, float]:
    """f1 to f4 at a gap (m)."""
    g = min(max(float(gap), 8e-3), 40e-3)
    lam = 1 - B0**2 / (4 * T1 * (g + B0 / 2 + HM / MU_REC))
    u = B0 / (2 * g)
    kc = T1 / (T1 - g * 4 / pi * (u * atan(u) - log(sqrt(1 + u**2))))
    b = reduce(lambda value, coefficient: value * (g - 24e-3) / 16e-3 + coefficient, reversed(FIELD))
    a = pi / TAU * (HM + g)
    coth = 1 / tanh(a)
    return lam / (kc * sinh(a)), lam * b**2, lam * b * coth / kc, lam * coth**2 / kc**2


def park_matrix(displacement: float) -> np.ndarray:
    """Matrix of (2.1) with the offset of (4.4), shape (2, 3)."""
    angles = [pi / TAU * (displacement - TAU / 2) + shift for shift in (0, -2 * pi / 3, 2 * pi / 3)]
    return 2 / 3 * np.array([[cos(angle) for angle in angles], [-sin(angle) for angle in angles]])


def limited(values: np.ndarray, lower: float | np.ndarray, upper: float | np.ndarray) -> np.ndarray:
    """What `np.clip` gives, in a fifth of its time where there is a handful of values."""
    found: np.ndarray = np.minimum(np.maximum(values, lower), upper)
    return found


@dataclass
class Crossing:
    """Where a function of the state is 0, the solver ends."""

    value: Callable[[np.ndarray], float]
    terminal = True

    def __call__(self, _: float, state: np.ndarray) -> float:
        return self.value(state)


@dataclass
class ReferenceAxis:
    """Parameters of one axis."""

    mass: float
    bias: float
    coulomb: float
    presliding: float
    viscous: float
    lower: float
    upper: float
    ripple: float = 0.0
    period: float = T1
    force: float = 0.0

    def acceleration(self, x: float, v: float, w: float) -> float:
        """Acceleration (m/s²) by everything but the motors."""
        force = self.force - self.coulomb * w - self.viscous * v
        if x > self.upper:
            force -= max(0.0, STOP_K * (x - self.upper) + STOP_C * v)
        if x < self.lower:
            force += max(0.0, STOP_K * (self.lower - x) - STOP_C * v)
        return self.bias + self.ripple * sin(2 * pi * x / self.period + 0.5) + force / self.mass

    def events(self, first: int) -> list["Crossing"]:
        """What changes its sign where friction or a stop's push jumps, of an axis whose states begin at `first`."""
        def push(state: np.ndarray, into: float) -> float:
            return float(STOP_K * into + STOP_C * state[first + 1])

        return [Crossing(lambda s: s[first + 1]), Crossing(lambda s: s[first] - self.lower),
                Crossing(lambda s: s[first] - self.upper),
                # where the stop's push ends before the mover has left it
                Crossing(lambda s: push(s, s[first] - self.upper)), Crossing(lambda s: push(s, s[first] - self.lower))]

    def deflection_rate(self, v: float, w: float) -> float:
        """Rate of the Dahl deflection (1/s)."""
        return (v - w * abs(v)) / self.presliding if self.coulomb else 0.0


@dataclass
class ReferenceStage:
    """A stage: its vertical row, its horizontal rows, its amplifiers.

    State: for each axis position, velocity, deflection; then the three phase currents of each motor.
    """

    constants: tuple[float, ...]
    modulation: float
    axes: list[ReferenceAxis]
    peak: float
    masses: tuple[float, ...]       # of the axes, at which the constants hold
    winding: tuple[float, float]    # ohm, H
    bus: float = np.inf             # V
    motors: int = field(init=False)

    def __post_init__(self) -> None:
        self.motors = len(self.axes) - 1

    def rates(self, state: np.ndarray, commands: np.ndarray) -> np.ndarray:
        """Time derivative of the state under phase commands, shape (motors, 3)."""
        n = len(self.axes)
        x, v, w = state[:3 * n].reshape(n, 3).T.tolist()
        currents = state[3 * n:].reshape(self.motors, 3)
        f1, f2, f3, f4 = shape_functions(x[0])
        f2 *= 1 - self.modulation * sin(pi * x[1] / T1)**2
        parks = [park_matrix(place) for place in x[1:]]
        dq = [(park @ phases).tolist() for park, phases in zip(parks, currents, strict=True)]
        i_d, squares = sum(d for d, _ in dq), sum(d**2 + q**2 for d, q in dq)
        c = self.constants
        if self.motors == 1:
            motors = [G - c[3] * f4 * squares + c[2] * f3 * i_d - c[1] * f2, -c[0] * f1 * dq[0][1]]
        else:
            motors = [G - 2 * c[4] * f4 * squares + 2 * c[3] * f3 * i_d - 4 * c[2] * f2,
                      -2 * c[0] * f1 * dq[0][1], -2 * c[1] * f1 * dq[1][1]]
        of_axes = [rate for i, axis in enumerate(self.axes) for rate in (
            v[i], motors[i] + axis.acceleration(x[i], v[i], w[i]), axis.deflection_rate(v[i], w[i]))]
        wanted = (limited(commands, -self.peak, self.peak) - currents) / LAG
        resistance, inductance = self.winding
        drop = resistance * currents + self.induced(v, parks, dq, f1, f3, f4)
        of_phases = limited(wanted, (-self.bus - drop) / inductance, (self.bus - drop) / inductance)
        return np.concatenate([of_axes, of_phases.ravel()])

    def induced(self, v: list[float], parks: list[np.ndarray], dq: list[list[float]], f1: float, f3: float,
                f4: float) -> np.ndarray:
        """Voltages of the phases, shape (motors, 3): by each current, two thirds of its force times the speed."""
        m, c, sharing = self.masses, self.constants, 1 if self.motors == 1 else 2
        return sharing * np.array([
            park.T @ [m[0] * (c[-2] * f3 - c[-1] * f4 * i_d) * v[0],
                      -m[0] * c[-1] * f4 * i_q * v[0] - m[k + 1] * c[k] * f1 * v[k + 1]]
            for k, (park, (i_d, i_q)) in enumerate(zip(parks, dq, strict=True))])

    def solve(self, start: Sequence[float], commands: Callable[[int, np.ndarray], np.ndarray], dt: float, steps: int,
              rtol: float = 1e-11) -> np.ndarray:
        """States at every communication point, shape (steps + 1, states).

        `commands(k, positions)` gives the phase commands that are held over step k. Friction is not smooth where a
        velocity changes sign, nor is a stop where it is met: the solver stops there and starts again.
        """
        n = len(self.axes)
        state = np.zeros(3 * n + 3 * self.motors)
        state[0:3 * n:3] = start
        first = limited(commands(0, np.array(start)), -self.peak, self.peak)
        state[3 * n:] = first.ravel()   # the lag starts at the first clamped command
        states = [state]

        events = [event for i, axis in enumerate(self.axes) for event in axis.events(3 * i)]
        for k in range(steps):
            held = commands(k, states[-1][0:3 * n:3])
            t, end, state = k * dt, (k + 1) * dt, states[-1]
            while t < end:
                solution = solve_ivp(lambda _, s: self.rates(s, held), (t, end), state, method="DOP853",   # noqa: B023
                                     rtol=rtol, atol=1e-14, events=events)
                state, t = solution.y[:, -1], solution.t[-1]
                if solution.status == 1:
                    # Step off the event, so that it is not found again.
                    after = min(1e-9, end - t)
                    state, t = state + after * self.rates(state, held), t + after
            states.append(state)
        return np.array(states)


def reference_2dof() -> ReferenceStage:
    """The 2-DOF stage: axes v, h."""
    return ReferenceStage((14.20, 791.00, 30.90, 0.12), 0.027,
                          [ReferenceAxis(4.350, 0.2, 2.0, 0.3e-3, 2.0, 8e-3, 28e-3),
                           ReferenceAxis(1.594, 0.1, 0.25, 0.3e-3, 1.0, -70e-3, 70e-3)], 9.0, (4.350, 1.594),
                          (7.0, 70e-3))


def reference_3dof() -> ReferenceStage:
    """The 3-DOF stage: axes y, x, z."""
    return ReferenceStage((0.6135, 0.8224, 334.52, 8.71, 0.0045), 0.0135,
                          [ReferenceAxis(6.9, 0.1, 1.0, 0.5e-3, 2.0, 18.5e-3, 32e-3, 0.15, 5e-3),
                           ReferenceAxis(10.6, 0.05, 1.2, 0.5e-3, 2.0, -62e-3, 62e-3),
                           ReferenceAxis(8.6, 0.05, 1.1, 0.5e-3, 2.0, -62e-3, 62e-3)], 5.0, (6.9, 10.6, 8.6),
                          (3.5, 35e-3))
