"""Linear parts of the controllers' laws on one axis: observer, internal model or integral, feedback."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from controller_fmu.internal_model import OscillatorStep
from maglev.arrays import Array

INPUTS = ("reference", "reference_rate", "measured")
REFERENCE, RATE, MEASURED = range(3)


@dataclass(frozen=True, eq=False)
class AxisLaw:
    """One sample of one axis: x[k+1] = A x[k] + B u[k], w[k] = C x[k] + D u[k], with u = (r, ṙ, y).

    w is what the law asks for: an acceleration of an output regulator, a current of a PID.
    """

    states: dict[str, str]   # names of the n states in the block of the axis, with their units
    A: Array                 # shape (n, n)
    B: Array                 # shape (n, 3)
    C: Array                 # shape (1, n)
    D: Array                 # shape (1, 3)


def observer(filters: Any, sample_time: float) -> tuple[Array, Array]:
    """A and B of the states l and v̂ of the velocity observer (Fig. 4.7), shapes (2, 2) and (2, 3).

    l⁺ = l + a1 (y − l), v̂⁺ = v̂ + a2 (a1 (y − l)/Ts − v̂).
    """
    a1, a2 = filters.share1, filters.share2
    return (np.array([[1.0 - a1, 0.0], [-a1 * a2 / sample_time, 1.0 - a2]]),
            np.array([[0.0, 0.0, a1], [0.0, 0.0, a1 * a2 / sample_time]]))


def output_regulator(axis: Any, controller: Any) -> AxisLaw:
    """Output regulator (4.15), (4.16): w = k1 e + k2 (v̂⁺ − ṙ) + (k3 + 1) ξ1 + k4 ξ2 + k5 ξ3.

    Without its friction compensation, which jumps at rest.
    """
    step = OscillatorStep()
    step.prepare(controller.omega0, controller.sample_time)
    a, b = np.zeros((5, 5)), np.zeros((5, 3))
    a[:2, :2], b[:2] = observer(controller.observer, controller.sample_time)
    a[2:, 2:] = [[1.0, step.sine, step.versine], [0.0, step.cosine, step.sine], [0.0, step.minus_sine, step.cosine]]
    b[2:, MEASURED] = [step.ramp, step.versine, step.sine]
    b[2:, REFERENCE] = -b[2:, MEASURED]
    # The law takes the observer's velocity after it has taken in the measurement.
    c = np.array([[0.0, 0.0, axis.k3 + 1.0, axis.k4, axis.k5]]) + axis.k2 * a[1]
    d = np.array([[-axis.k1, -axis.k2, axis.k1]]) + axis.k2 * b[1]
    return AxisLaw({"observer.position": "m", "observer.velocity": "m/s", "model.xi1": "m.s3", "model.xi2": "m.s2",
                    "model.xi3": "m.s"}, a, b, c, d)


def pid(axis: Any, controller: Any) -> AxisLaw:
    """PID (Figs. 4.6, 5.6): w = kp e + ki I + kd ė, then I⁺ = I + Ts e, with e and ė against the filtered reference.

    Pre-filter: q⁺ = q + Ts (ω² (r − p) − 2 ω q), p⁺ = p + Ts q⁺; with a corner ω of 0 it has no states.
    """
    dt, corner = controller.sample_time, axis.prefilter
    filtered = corner > 0.0
    n = 5 if filtered else 3
    a, b = np.zeros((n, n)), np.zeros((n, 3))
    a[:2, :2], b[:2] = observer(controller.observer, dt)
    position, rate = (np.zeros((1, n)), np.eye(3)[REFERENCE]), (np.zeros((1, n)), np.eye(3)[RATE])
    if filtered:
        p, q = 2, 3
        a[q, p], a[q, q], b[q, REFERENCE] = -dt * corner**2, 1.0 - 2.0 * dt * corner, dt * corner**2
        a[p], b[p] = np.eye(n)[p] + dt * a[q], dt * b[q]
        position, rate = (a[p], b[p]), (a[q], b[q])
    # e = y − p⁺ and ė = v̂⁺ − q⁺, each as its coefficients of the states and of the inputs.
    error = (-position[0].reshape(n), np.eye(3)[MEASURED] - position[1])
    error_rate = (a[1] - rate[0].reshape(n), b[1] - rate[1])
    integral = np.eye(n)[n - 1]
    a[n - 1], b[n - 1] = integral + dt * error[0], dt * error[1]
    names = {"observer.position": "m", "observer.velocity": "m/s",
             **({"filter.position": "m", "filter.rate": "m/s"} if filtered else {}), "integral": "m.s"}
    return AxisLaw(names, a, b, (axis.kp * error[0] + axis.ki * integral + axis.kd * error_rate[0])[None],
                   (axis.kp * error[1] + axis.kd * error_rate[1])[None])
