"""Model-predictive control of the 3-DOF stage with OSQP, on the feedback-linearised motors.

    python -m pip install 'maglev-fmus[examples]'      # where maglev-fmus is installed
    maglev run 3dof-setpoints-improved --controller examples/mpc_osqp.py
    maglev compare 3dof-setpoints-improved --controller Regulator3DOF --controller examples/mpc_osqp.py
    python examples/mpc_osqp.py      # prints the cost of a sample

With the motors feedback-linearised, each axis is a double integrator with a disturbance, which an observer estimates.
In every sample a quadratic programme computes the accelerations of the next 0.25 s, and the first one is commanded. It
minimises squares of errors, velocities, and accelerations in addition to those that hold the stage. Accelerations stay
within 90 % of the acceleration by 4 A at the present gap. This replaces anti-windup, because the programme knows the
limits, and the observer gets the limited command.
"""

import time

import numpy as np
import osqp
from disturbance_observer import DisturbanceObserver
from scipy.linalg import block_diag, solve_discrete_are
from scipy.sparse import csc_matrix, identity
from stage_3dof import INPUTS, LIMIT, OUTPUTS, SAMPLE_TIME, Axis, accelerations, command

from controller_fmu.motor_command import MotorCommand

STEPS, STEP = 25, 10e-3              # of the prediction, s: coarser than the samples
SHARE = 0.9                          # of the limits; the rest is for errors of the prediction
ESTIMATE = 80.0                      # rad/s, of the observers
ERROR, VELOCITY = 1e-3, 40e-3        # m, m/s: they cost as much as the accelerations of the axes, m/s²
ACCELERATION = {"y": 2.0, "x": 1.5, "z": 1.5}


def prediction(acceleration: float) -> tuple[np.ndarray, np.ndarray]:
    """P and F of the cost ½ uᵀ P u + uᵀ F [error, velocity] of one axis over its accelerations u, (m/s²)²."""
    A = np.array([[1.0, STEP], [0.0, 1.0]])
    B = np.array([[STEP**2 / 2.0], [STEP]])
    Q, R = acceleration**2 * np.diag([1.0 / ERROR**2, 1.0 / VELOCITY**2]), np.eye(1)
    after = solve_discrete_are(A, B, Q, R)   # cost after the horizon, without limits
    powers = [np.linalg.matrix_power(A, k) for k in range(STEPS + 1)]
    free = np.vstack(powers[1:])
    forced = np.block([[powers[row - column] @ B if row >= column else np.zeros((2, 1)) for column in range(STEPS)]
                       for row in range(STEPS)])
    weights = block_diag(*[Q] * (STEPS - 1), after)
    return forced.T @ weights @ forced + np.eye(STEPS), forced.T @ weights @ free


class MPC:
    """Model-predictive control on the feedback-linearised motors of the 3-DOF stage."""

    inputs = INPUTS
    outputs = OUTPUTS

    def __init__(self) -> None:
        self.sample_time = SAMPLE_TIME
        self.y, self.x, self.z = Axis(25e-3), Axis(0.0), Axis(0.0)
        self.alpha, self.beta = MotorCommand(), MotorCommand()

    def start(self) -> None:
        """Set up the programme: the three axes in one, their accelerations one after the other."""
        predictions = [prediction(ACCELERATION[axis]) for axis in ("y", "x", "z")]
        self.slopes = [F for _, F in predictions]
        self.observers = [DisturbanceObserver(ESTIMATE) for _ in predictions]
        self.solver = osqp.OSQP()
        n = 3 * STEPS
        self.solver.setup(csc_matrix(np.triu(block_diag(*[P for P, _ in predictions]))), np.zeros(n),
                          identity(n, format="csc"), -np.ones(n), np.ones(n), verbose=False, eps_abs=1e-3, eps_rel=1e-3,
                          check_termination=5, adaptive_rho=False)
        self.started = False

    def step(self, t: float) -> None:
        """Step one sample."""
        axes = (self.y, self.x, self.z)
        if not self.started:
            for observer, axis in zip(self.observers, axes, strict=True):
                observer.start(axis.measured)
            self.started = True
        gap = self.y.measured
        states = np.array([observer.state for observer in self.observers])
        states[:, 0] -= [axis.reference for axis in axes]
        disturbances = states[:, 2]
        most, least = (np.array(accelerations(gap, sign * LIMIT, -sign * LIMIT, -sign * LIMIT)) for sign in (1.0, -1.0))
        # u moves the axis: the command plus the disturbance.
        self.solver.update(q=np.concatenate([F @ state[:2] for F, state in zip(self.slopes, states, strict=True)]),
                           l=np.repeat(SHARE * least + disturbances, STEPS),
                           u=np.repeat(SHARE * most + disturbances, STEPS))
        y, x, z = self.solver.solve(raise_error=False).x[::STEPS] - disturbances   # an unfinished solution is good, too
        given = command(self.alpha, self.beta, (y, x, z), gap, self.x.measured, self.z.measured)
        for observer, axis, acceleration in zip(self.observers, axes, given, strict=True):
            observer.update(axis.measured, acceleration)


if __name__ == "__main__":
    import maglev

    costs: list[float] = []

    class Timed(MPC):
        """The same controller with a clock, which counts the time of this thread."""

        def step(self, t: float) -> None:
            """Step one sample."""
            began = time.thread_time()
            super().step(t)
            costs.append(time.thread_time() - began)

    maglev.run("3dof-setpoints-improved", controller=Timed)
    median, most = np.percentile(costs, [50, 99]) * 1e3
    print(f"a sample costs {median:.3f} ms, one in a hundred more than {most:.3f} ms; it has {SAMPLE_TIME * 1e3:g} ms")
