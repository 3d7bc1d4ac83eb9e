"""H-infinity loop shaping (McFarlane and Glover) for the 3-DOF stage, on the feedback-linearised motors.

    maglev run 3dof-setpoints-improved --controller examples/h_infinity.py
    maglev compare 3dof-setpoints-improved --controller Regulator3DOF --controller examples/h_infinity.py

With the motors feedback-linearised at the measured gap, each axis is a double integrator. A weight k (s + a)/s shapes
its loop, with crossover near √k and integral action up to a. Two Riccati equations give the controller whose loop stays
stable for the largest uncertainty of the normalised coprime factors of the shaped plant. The controller is an observer
with state feedback, so the reference can bypass the observer. For anti-windup, weight and observer get the limited
command.

D. McFarlane, K. Glover, A loop shaping design procedure using H-infinity synthesis, IEEE Trans. Autom. Control, 1992.
"""

import numpy as np
from scipy.linalg import solve_continuous_are
from scipy.signal import cont2discrete
from stage_3dof import INPUTS, OUTPUTS, SAMPLE_TIME, command
from stage_3dof import Axis as Ports

from controller_fmu.motor_command import MotorCommand
from controller_fmu.reference_prefilter import ReferencePrefilter

SUBOPTIMAL = 1.1   # γ over the least one: at the least one the controller is singular


class LoopShaping:
    """Controller of the plant 1/s² with the weight k (s + a)/s.

    States of the shaped plant: position, velocity, and the acceleration by the weight's integrator.

    Attributes
    ----------
    gamma : float
        1/γ is the stability margin: of the normalised coprime factors that much may be wrong, in the H∞ norm.
    F, H : ndarray
        Gains of the states, shape (1, 3), and of the observer, (3, 1).
    """

    def __init__(self, crossover: float, a: float):
        self.k, self.a = crossover**2, a
        self.A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
        self.B = np.array([[0.0], [self.k], [self.k * a]])
        self.C = np.array([[1.0, 0.0, 0.0]])
        X = solve_continuous_are(self.A, self.B, self.C.T @ self.C, np.eye(1))
        Z = solve_continuous_are(self.A.T, self.C.T, self.B @ self.B.T, np.eye(1))
        self.gamma = SUBOPTIMAL * np.sqrt(1.0 + np.linalg.eigvals(X @ Z).real.max())
        self.F = -self.B.T @ X
        self.H = self.gamma**2 * np.linalg.solve(((1.0 - self.gamma**2) * np.eye(3) + X @ Z).T, Z @ self.C.T)


class Axis(Ports):
    """One axis: ports and controller, x̂' = A x̂ + B u + H (C x̂ − y), u = F (x̂ − x_reference)."""

    def __init__(self, position: float, crossover: float, a: float, pace: float):
        super().__init__(position)
        self.pace = pace                           # rad/s, of the smoothed reference; 0 = not smoothed
        self.smooth = ReferencePrefilter()
        self.law = law = LoopShaping(crossover, a)
        self.state = np.zeros(3)                   # x̂
        self.integral = 0.0                        # m/s², state of the weight
        # u and y are constant over a sample.
        held = (law.A + law.H @ law.C, np.hstack([law.B, -law.H]), law.C, np.zeros((1, 2)))
        self.transition, self.inputs, *_ = cont2discrete(held, SAMPLE_TIME)

    def start(self) -> None:
        """Begin at rest at the measurement."""
        self.state[0] = self.measured
        self.smooth.seed(self.measured)

    def demand(self) -> float:
        """Acceleration (m/s²)."""
        self.smooth.update(self.reference, 0.0, self.pace, SAMPLE_TIME)
        target = np.array([self.smooth.position, self.smooth.rate, 0.0])
        return self.law.k * float(self.law.F[0] @ (self.state - target)) + self.integral

    def update(self, given: float) -> None:
        """Take in the acceleration (m/s²) that the limited currents make; u is the input that would have made it."""
        u = (given - self.integral) / self.law.k
        self.state = self.transition @ self.state + self.inputs @ np.array([u, self.measured])
        self.integral += SAMPLE_TIME * self.law.a * self.law.k * u


class HInfinity:
    """H-infinity loop shaping on the feedback-linearised motors of the 3-DOF stage."""

    inputs = INPUTS
    outputs = OUTPUTS

    def __init__(self) -> None:
        self.sample_time = SAMPLE_TIME
        # Steps of the gap need smoothing: 4 A hold it at 30 mm, but do not stop a mover that falls there.
        self.y, self.x, self.z = Axis(25e-3, 50.0, 15.0, 25.0), Axis(0.0, 35.0, 12.0, 0.0), Axis(0.0, 35.0, 12.0, 0.0)
        self.alpha, self.beta = MotorCommand(), MotorCommand()
        self.started = False

    def step(self, t: float) -> None:
        """Step one sample."""
        axes = (self.y, self.x, self.z)
        if not self.started:
            for axis in axes:
                axis.start()
            self.started = True
        y, x, z = (axis.demand() for axis in axes)
        given = command(self.alpha, self.beta, (y, x, z), self.y.measured, self.x.measured, self.z.measured)
        for axis, acceleration in zip(axes, given, strict=True):
            axis.update(acceleration)
