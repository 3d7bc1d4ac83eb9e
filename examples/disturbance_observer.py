"""Disturbance observer against guide friction, on top of the thesis's regulator of the 3-DOF stage.

    maglev run 3dof-setpoints-improved --controller examples/disturbance_observer.py
    maglev compare 3dof-setpoints-improved --controller Regulator3DOF --controller examples/disturbance_observer.py

The regulator is the thesis's, with its gains: its class is inherited. New are three observers. Each follows a measured
position with the acceleration that the limited currents make, and takes what is left over for a disturbance: friction,
bias, ripple, wrong constants. The demand is reduced by it, so that to the regulator the stage is the double integrator
that its gains were computed for.
"""

import numpy as np
from controller_fmu.regulator_3dof import Regulator3DOF
from scipy.signal import cont2discrete, place_poles
from stage_3dof import INPUTS, OUTPUTS, SAMPLE_TIME, accelerations, quadrature_currents

BANDWIDTH = 60.0   # rad/s: a faster observer follows friction more closely, and the steps of the encoder as well


class DisturbanceObserver:
    """Position, velocity and disturbance of an axis p'' = acceleration + d, d' = 0, from measured positions."""

    def __init__(self, bandwidth: float):
        A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
        B, C = np.array([[0.0], [1.0], [0.0]]), np.array([[1.0, 0.0, 0.0]])
        self.A, B, *_ = cont2discrete((A, B, C, np.zeros((1, 1))), SAMPLE_TIME)
        self.B = B[:, 0]
        # `place_poles` places no pole three times: they lie side by side.
        poles = np.exp(-bandwidth * np.array([0.9, 1.0, 1.1]) * SAMPLE_TIME)
        self.gain = place_poles(self.A.T, C.T, poles).gain_matrix[0]
        self.state = np.zeros(3)   # m, m/s, m/s²

    def start(self, measured: float) -> None:
        """Begin at rest at a measured position (m)."""
        self.state = np.array([measured, 0.0, 0.0])

    def update(self, measured: float, acceleration: float) -> None:
        """Take in a measured position (m), and the acceleration (m/s²) that is commanded until the next one."""
        surprise = measured - self.state[0]
        self.state = self.A @ self.state + self.B * acceleration + self.gain * surprise

    @property
    def disturbance(self) -> float:
        """Acceleration (m/s²) that the commands do not explain."""
        return float(self.state[2])


class ObservedRegulator(Regulator3DOF):
    """The thesis's regulator of the 3-DOF stage, relieved of the disturbances by an observer on each axis."""

    inputs = {**INPUTS, "y.reference_rate": "m/s", "x.reference_rate": "m/s", "z.reference_rate": "m/s"}
    outputs = {**OUTPUTS, "saturated": "", "feasible": "", "tripped": ""}
    parameters = {f"{axis}.k{k}": unit for axis in ("y", "x", "z")
                  for k, unit in enumerate(("1/s2", "1/s", "1/s5", "1/s4", "1/s3"), 1)}

    def start(self) -> None:
        """Compute what follows from the parameters."""
        super().start()
        self.observers = [DisturbanceObserver(BANDWIDTH) for _ in "yxz"]

    def step(self, t: float) -> None:
        """One sample: that of the regulator, which asks for `currents`, then the observers."""
        axes = (self.y, self.x, self.z)
        if not self.started:
            for observer, axis in zip(self.observers, axes, strict=True):
                observer.start(axis.measured)
        self.sample()
        given = accelerations(self.y.measured, self.alpha.i_d_cmd, self.alpha.i_q_cmd, self.beta.i_q_cmd)
        for observer, axis, acceleration in zip(self.observers, axes, given, strict=True):
            observer.update(axis.measured, acceleration)

    def currents(self, demand_y: float, demand_x: float, demand_z: float) -> tuple[float, float, float]:
        """Currents (A) for the demanded accelerations (m/s²), less what the disturbances do already.

        The quadrature currents go out as they are demanded, for the thesis's antiwindup has to see what the limit takes
        away. The direct current makes up for what is left of them: (5.7) would drop the mover at a step of 40 mm.
        """
        y, x, z = (demand - observer.disturbance for demand, observer
                   in zip((demand_y, demand_x, demand_z), self.observers, strict=True))
        gap = self.y.measured
        _, i_qa, i_qb = super().currents(y, x, z)
        _, limited_x, limited_z = accelerations(gap, 0.0, *quadrature_currents(gap, x, z))
        i_d, _, _ = super().currents(y, limited_x, limited_z)
        return i_d, i_qa, i_qb
