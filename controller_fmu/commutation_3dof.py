"""Commutation of the 3-DOF stage's two pairs of motors alone (C.1), for currents that somebody else decides."""

from controller_fmu.commutated_motor import CommutatedMotor, MeasuredDisplacement
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import STEP_MISFIT, STEPPED
from pmlsm.data_sheet import SAMPLE_TIME_3DOF


class Commutation3DOF:
    """Samples displacements and current references, commands phase currents that hold until the next sample.

    The pair alpha drives x and the pair beta z; each commutates with the displacement that it drives.
    """

    def __init__(self) -> None:
        self.sample_time = SAMPLE_TIME_3DOF   # s, parameter
        self.current_limit = 0.0              # A, parameter, 0 = none
        self.x = MeasuredDisplacement()
        self.z = MeasuredDisplacement()
        self.alpha = CommutatedMotor()
        self.beta = CommutatedMotor()
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
        alpha = self.alpha
        beta = self.beta
        alpha.commutate(self.current_limit, self.x.measured)
        beta.commutate(self.current_limit, self.z.measured)
        self.saturated = alpha.saturated or beta.saturated
