"""Commutation of the 2-DOF stage's motor alone (C.1), for currents that somebody else decides."""

from controller_fmu.commutated_motor import CommutatedMotor, MeasuredDisplacement
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import STEP_MISFIT, STEPPED
from pmlsm.data_sheet import SAMPLE_TIME_2DOF


class Commutation2DOF:
    """Samples displacement and current references, commands phase currents that hold until the next sample."""

    def __init__(self) -> None:
        self.sample_time = SAMPLE_TIME_2DOF   # s, parameter
        self.current_limit = 0.0              # A, parameter, 0 = none
        self.h = MeasuredDisplacement()
        self.motor = CommutatedMotor()
        self.clock = SampleClock()
        self.saturated = False  # output

    def start(self) -> int:
        """Nothing follows from the fixed parameters."""
        return STEPPED

    def step(self, t: float, dt: float) -> int:
        """Sample if the sampling grid has a point at t; the commands hold over t to t + dt (s)."""
        if not self.clock.fits(dt, self.sample_time):
            return STEP_MISFIT
        if self.clock.due(dt, self.sample_time):
            self.sample()
        return STEPPED

    def sample(self) -> None:
        """Commutate once."""
        motor = self.motor
        motor.commutate(self.current_limit, self.h.measured)
        self.saturated = motor.saturated
