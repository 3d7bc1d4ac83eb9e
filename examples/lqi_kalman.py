"""LQI with a Kalman filter for the 3-DOF stage: optimal gains on linear models, scheduled over the air gap.

    maglev run 3dof-setpoints-improved --controller examples/lqi_kalman.py
    maglev compare 3dof-setpoints-improved --controller Regulator3DOF --controller examples/lqi_kalman.py

The stage is linearised at gaps of 21…29 mm, about the currents that carry it, with the constants of the thesis's
regulator. At each gap two Riccati equations give the gains of states and integrals (LQI) and of the Kalman filter,
which also estimates unknown accelerations. Between the gaps the gains are interpolated. References are smoothed, so
that the linear feedback sees small deviations only. The currents that carry and accelerate the mover are fed forward.
"""

import numpy as np
from scipy.linalg import block_diag, solve_discrete_are
from stage_3dof import INPUTS, KNOWN, LIMIT, MOTOR, OUTPUTS, SAMPLE_TIME, Axis

import maglev
from controller_fmu.motor_command import MotorCommand

GAPS = np.arange(21e-3, 29.5e-3, 2e-3)     # m, at which gains are designed
PACE = np.array([22.0, 9.0, 10.5])         # rad/s, of the smoothed references of y, x, z: x and z need most of 4 A

# One direct current in both pairs, a quadrature current in each: (i_d, i_qα, i_qβ) -> (i_dα, i_qα, i_dβ, i_qβ).
CURRENTS = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])

# Weights: one over the square of a value; all these values cost the same.
POSITION, VELOCITY = 1.0 / 0.2e-3**2, 1.0 / 15e-3**2    # m, m/s
INTEGRAL = 1.0 / 10e-6**2                               # m s
COMMAND = 1.0 / np.array([0.5, 1.0, 1.0])**2            # A, of i_d, i_qα, i_qβ

# Standard deviations of the encoder's rounding, and of the drift of unmodelled accelerations, mostly friction.
ENCODER = 10e-6 / np.sqrt(12.0)                         # m
DRIFT = 8.0                                             # m/s² in a second

# The regulator's model of the stage: the thesis's constants, without bias, ripple and modulation.
MODEL = {"C1": KNOWN.thrust["x"], "C2": KNOWN.thrust["z"], "C3": KNOWN.attraction, "C4": KNOWN.coils,
         "C5": KNOWN.iron, "attraction_modulation": 0.0,
         "y.ripple.amplitude": 0.0, "y.bias": 0.0, "x.bias": 0.0, "z.bias": 0.0}


class Design:
    """Model and gains at one gap."""

    def __init__(self, gap: float):
        plant = maglev.linearise("Plant3DOF", {"y": float(gap)}, parameters=MODEL)
        self.currents = np.array([plant.equilibrium.i_d[0], *plant.equilibrium.i_q])   # at rest, A
        self.per_acceleration = np.linalg.inv(plant.A[3:6, 6:10] @ CURRENTS)           # A s²/m
        held = plant.discretise(SAMPLE_TIME)
        n, pulse = len(held.A), np.zeros((10, 3))
        pulse[:3], pulse[3:6] = SAMPLE_TIME**2 / 2 * np.eye(3), SAMPLE_TIME * np.eye(3)
        # Kalman filter, with the unknown accelerations as states of their own.
        self.A = np.block([[held.A, pulse], [np.zeros((3, n)), np.eye(3)]])
        self.B = np.vstack([held.B @ CURRENTS, np.zeros((3, 3))])
        self.C = np.hstack([held.C, np.zeros((3, 3))])
        noise = block_diag(np.zeros((6, 6)), 1e-6 * np.eye(4), DRIFT**2 * SAMPLE_TIME * np.eye(3))
        P = solve_discrete_are(self.A.T, self.C.T, noise, ENCODER**2 * np.eye(3))
        self.filter = P @ self.C.T @ np.linalg.inv(self.C @ P @ self.C.T + ENCODER**2 * np.eye(3))
        # LQI: the states, and the integrals of the errors.
        A = np.block([[held.A, np.zeros((n, 3))], [SAMPLE_TIME * held.C, np.eye(3)]])
        B = np.vstack([held.B @ CURRENTS, np.zeros((3, 3))])
        weights = np.diag([POSITION] * 3 + [VELOCITY] * 3 + [0.0] * 4 + [INTEGRAL] * 3)
        P = solve_discrete_are(A, B, weights, np.diag(COMMAND))
        self.feedback = np.linalg.solve(np.diag(COMMAND) + B.T @ P @ B, B.T @ P @ A)


class LQI:
    """LQI with a Kalman filter on linear models of the 3-DOF stage, scheduled over the air gap."""

    inputs = INPUTS
    outputs = OUTPUTS

    def __init__(self) -> None:
        self.sample_time = SAMPLE_TIME
        self.y, self.x, self.z = Axis(25e-3), Axis(0.0), Axis(0.0)
        self.alpha, self.beta = MotorCommand(), MotorCommand()

    def start(self) -> None:
        """Design, once."""
        designs = [Design(gap) for gap in GAPS]
        self.table = {name: np.array([getattr(design, name) for design in designs]) for name in vars(designs[0])}
        self.C = designs[0].C
        self.state = None

    def scheduled(self, gap: float) -> dict[str, np.ndarray]:
        """Model and gains at a gap (m), interpolated."""
        place = np.clip((gap - GAPS[0]) / (GAPS[1] - GAPS[0]), 0.0, len(GAPS) - 1.001)
        k = int(place)
        share = place - k
        return {name: values[k] + share * (values[k + 1] - values[k]) for name, values in self.table.items()}

    def step(self, t: float) -> None:
        """Step one sample: filter, feedback, limit, and prediction."""
        measured = np.array([self.y.measured, self.x.measured, self.z.measured])
        reference = np.array([self.y.reference, self.x.reference, self.z.reference])
        if self.state is None:
            now = self.scheduled(measured[0])
            self.smooth, self.rate, self.integral = measured, np.zeros(3), np.zeros(3)
            self.state = np.concatenate([measured, np.zeros(3), CURRENTS @ now["currents"], np.zeros(3)])
        acceleration = PACE**2 * (reference - self.smooth) - 2.0 * PACE * self.rate
        now = self.scheduled(self.smooth[0])
        state = self.state + now["filter"] @ (measured - self.state[:3])
        ahead = now["currents"] + now["per_acceleration"] @ acceleration
        wanted = np.concatenate([self.smooth, self.rate, CURRENTS @ ahead])
        command = ahead - now["feedback"] @ np.concatenate([state[:10] - wanted, self.integral])
        given = np.clip(command, -LIMIT, LIMIT)
        self.alpha.command(given[0], given[1], LIMIT, MOTOR.electrical_angle(self.x.measured))
        self.beta.command(given[0], given[2], LIMIT, MOTOR.electrical_angle(self.z.measured))
        # Antiwindup: the filter gets the limited command, and the integral waits while it is limited.
        free = given == command
        self.integral = self.integral + free * SAMPLE_TIME * (measured - self.smooth)
        rest = np.concatenate([[self.smooth[0]], np.zeros(5), CURRENTS @ now["currents"], np.zeros(3)])
        self.state = rest + now["A"] @ (state - rest) + now["B"] @ (given - now["currents"])
        self.rate = self.rate + SAMPLE_TIME * acceleration
        self.smooth = self.smooth + SAMPLE_TIME * self.rate
