"""Disturbance observer against guide friction, on top of the thesis's regulator of the 3-DOF stage.

    maglev run 3dof-setpoints-improved --controller examples/disturbance_observer.py
    maglev compare 3dof-setpoints-improved --controller Regulator3DOF --controller examples/disturbance_observer.py

The class inherits the thesis's regulator with its gains, and adds three observers. Each predicts a measured position
from the acceleration of the limited currents. It attributes the difference to a disturbance, by friction, bias,
ripple or wrong constants. The demand is reduced by this disturbance, so that the regulator controls the double
integrator for which its gains were computed.
"""

from typing import Any

import numpy as np
from scipy.signal import cont2discrete, place_poles
from stage_3dof import INPUTS, OUTPUTS, SAMPLE_TIME, accelerations, quadrature_currents

from controller_fmu.fixed_gains import FixedGains
from controller_fmu.level_platform import LevelPlatform
from controller_fmu.motor_command import MotorCommand
from controller_fmu.motor_model import MotorModel
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.regulator import Regulator
from controller_fmu.shared_current import SharedCurrent
from maglev.descriptions.packaged import PACKAGED_STAGES

BANDWIDTH = 60.0   # rad/s: a faster observer follows friction more closely, and the steps of the encoder as well


class DisturbanceObserver:
    """Position, velocity and disturbance of an axis p'' = acceleration + d, d' = 0, from measured positions."""

    def __init__(self, bandwidth: float):
        A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
        B, C = np.array([[0.0], [1.0], [0.0]]), np.array([[1.0, 0.0, 0.0]])
        self.A, B, *_ = cont2discrete((A, B, C, np.zeros((1, 1))), SAMPLE_TIME)
        self.B = B[:, 0]
        # `place_poles` cannot place a triple pole: the three are close together.
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


class ObservedAxis(OutputRegulator):
    """Output regulator of an axis that subtracts the estimated disturbance from its demand."""

    disturbance = 0.0                   # m/s²
    instead: float | None = None        # m/s², demand that replaces the regulator's

    def demand(self) -> float:
        """Demanded acceleration (m/s²)."""
        return super().demand() - self.disturbance if self.instead is None else self.instead


class ObservedCurrents(SharedCurrent):
    """Currents of the regulator, the direct one for thrusts within the limit.

    The quadrature currents are commanded without a limit, because the thesis's antiwindup has to see the part beyond
    it. The direct current compensates the limited ones: (5.7) would drop the mover at a step of 40 mm.
    """

    def command(self, axes: list[Any], motors: list[MotorCommand], model: MotorModel, platform: LevelPlatform,
                limit: float) -> bool:
        """Command the motors what the axes demand, within a limit (A, 0 = none); whether the demand can be made."""
        super().command(axes, motors, model, platform, 0.0)
        i_q, (gap, x, z) = list(self.i_q), axes
        x_demand, z_demand = x.demand(), z.demand()
        _, x.instead, z.instead = accelerations(gap.measured, 0.0,
                                                *quadrature_currents(gap.measured, x_demand, z_demand))
        feasible = super().command(axes, motors, model, platform, 0.0)
        x.instead = z.instead = None
        geometry = model.layout.kinds[0].geometry
        for motor, current, axis in zip(motors, i_q, (x, z), strict=True):
            motor.command(motor.i_d_cmd, current, limit, geometry.electrical_angle(axis.measured))
        return feasible


class ObservedRegulator(Regulator):
    """The thesis's regulator of the 3-DOF stage, relieved of the disturbances by an observer on each axis."""

    inputs = {**INPUTS, "y.reference_rate": "m/s", "x.reference_rate": "m/s", "z.reference_rate": "m/s"}
    outputs = {**OUTPUTS, "saturated": "", "feasible": "", "tripped": ""}
    parameters = {f"{axis}.k{k}": unit for axis in ("y", "x", "z")
                  for k, unit in enumerate(("1/s2", "1/s", "1/s5", "1/s4", "1/s3"), 1)}

    def __init__(self) -> None:
        stage = PACKAGED_STAGES["3dof"]
        super().__init__(stage)
        self.axes = [ObservedAxis(*axis.design.gains, axis.design.antiwindup_gain, axis.start) for axis in stage.axes]
        self.currents = ObservedCurrents(stage, self.law, FixedGains())
        # By the names of the ports.
        self.y, self.x, self.z = self.axes
        self.alpha, self.beta = self.motors

    def start(self) -> None:
        """Compute what follows from the parameters."""
        super().start()
        self.observers = [DisturbanceObserver(BANDWIDTH) for _ in "yxz"]

    def step(self, t: float) -> None:
        """Step one sample: the regulator, whose demands exclude the estimated disturbances, then the observers."""
        axes = (self.y, self.x, self.z)
        if not self.started:
            for observer, axis in zip(self.observers, axes, strict=True):
                observer.start(axis.measured)
        for observer, axis in zip(self.observers, axes, strict=True):
            axis.disturbance = observer.disturbance
        self.sample()
        given = accelerations(self.y.measured, self.alpha.i_d_cmd, self.alpha.i_q_cmd, self.beta.i_q_cmd)
        for observer, axis, acceleration in zip(self.observers, axes, given, strict=True):
            observer.update(axis.measured, acceleration)
