"""Online estimator of the constants of any stage (sections 3.1.3, 4.3, 5.3)."""

from typing import Any

from controller_fmu.common_row import CommonRow
from controller_fmu.constant_estimate import ConvergenceRule
from controller_fmu.described_platform import platform_of
from controller_fmu.estimated_axis import NormalAxis, ThrustAxis
from controller_fmu.level_platform import LevelPlatform
from controller_fmu.motor_current import MotorCurrent
from controller_fmu.motor_layout import MotorLayout
from controller_fmu.motor_rows import MotorRows
from controller_fmu.sample_clock import SampleClock
from controller_fmu.sampled import Sampled
from controller_fmu.status import BAD_GEOMETRY, BAD_PLACES, STEPPED
from controller_fmu.velocity_model import EstimatorLaw
from controller_fmu.velocity_observer import ObserverFilter
from pmlsm.stage_description import StageDescription
from pmlsm.velocity_rows import GRAVITY


class Estimator(Sampled):
    """Samples positions and delivered currents, estimates the constants by the reduced NPFSI estimator (3.8)."""

    def __init__(self, stage: StageDescription):
        guess = stage.estimator.guess
        weight = stage.estimator.weight
        self.epsilon = 0.01                  # s, parameter
        self.gamma = 1.1                     # parameter
        self.forgetting = 0.0                # 1/s, parameter, 0 = off
        self.matched_filter = False          # parameter
        self.held = False                    # parameter
        self.sample_time = stage.sample_time   # s, parameter
        self.layout = MotorLayout(stage)
        # Guesses of the constants of each row, and their weights, the diagonal of Q0.
        self.vertical = NormalAxis(stage.vertical.start, guess.attraction, guess.coils, guess.iron, weight.attraction,
                                   weight.coils, weight.iron)
        self.horizontal = [ThrustAxis(guess.thrust[axis.name], weight.thrust[axis.name]) for axis in stage.horizontal]
        self.motors = [MotorCurrent() for _ in stage.motors]
        # Of any type: the rows below know their type.
        self.platform: Any = platform_of(stage) if stage.rotations else LevelPlatform()
        self.rows = MotorRows(stage) if stage.rotations or stage.unlike else CommonRow(stage)
        self.observer = ObserverFilter()
        self.convergence = ConvergenceRule()
        self.law = EstimatorLaw()
        self.clock = SampleClock()
        self.started = False                 # state: a measurement has come in

    def start(self) -> int:
        """Begin with the guesses and their weights."""
        if not self.layout.prepare():
            return BAD_GEOMETRY
        if not self.platform.prepare():
            return BAD_PLACES
        self.observer.prepare(self.sample_time)
        for axis in self.horizontal:
            axis.begin()
        self.vertical.begin()
        return STEPPED

    def sample(self) -> None:
        """Take in a sample, with the motors of the estimator's own parameters."""
        self.take(self.layout)

    def take(self, layout: MotorLayout) -> None:
        """Take in a sample: the rows of A(y, u), then one step of the estimator on each."""
        vertical = self.vertical
        rows = self.rows
        if not self.platform.measure(vertical.measured):
            return   # an importer that has not exchanged values yet: this is no measurement
        vertical.measured = self.platform.centre(vertical.measured)
        rows.collect(layout, self.motors, self.platform, vertical.measured)
        if not self.started:
            self.started = True
            vertical.seed(rows.attraction, rows.coils, rows.iron)
            for axis, thrust in zip(self.horizontal, rows.thrust, strict=True):
                axis.seed(thrust)
        law = self.law
        law.prepare(self.sample_time, self.epsilon, self.gamma, self.forgetting)
        if self.held:
            law.hold()
        vertical.sample(rows.attraction, rows.coils, rows.iron, GRAVITY, self.matched_filter, self.observer, law,
                        self.convergence)
        for axis, thrust in zip(self.horizontal, rows.thrust, strict=True):
            axis.sample(thrust, self.matched_filter, self.observer, law, self.convergence)
