"""Commutation of the motors of the 2-DOF stage alone (C.1), for currents that somebody else decides."""

from controller_fmu.commutated_motor import CommutatedMotor, MeasuredDisplacement
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, STEP_MISFIT, STEPPED
from pmlsm.motor_geometry import MotorGeometry


class Commutation2DOF:
    """Samples displacements and current references, commands phase currents that hold until the next sample.

    Each motor commutates with the displacement that it drives.
    """

    def __init__(self) -> None:
        self.sample_time = 0.0005        # s, parameter
        self.current_limit = 0.0         # A, parameter, 0 = none
        self.geometry = MotorGeometry()
        self.h = MeasuredDisplacement()
        self.motor = CommutatedMotor()
        self.clock = SampleClock()
        self.saturated = False  # output

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        if not self.geometry.prepare():
            return BAD_GEOMETRY
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
        geometry = self.geometry
        motor_limited = self.motor.commutate(self.current_limit, geometry.electrical_angle(self.h.measured))
        self.saturated = motor_limited
