"""Commutation of the motors of the 5-DOF stage alone (C.1), for currents that somebody else decides."""

from controller_fmu.commutated_motor import CommutatedMotor, MeasuredDisplacement
from controller_fmu.motor_place import MotorPlace
from controller_fmu.platform_5dof import measure_tilts, prepare_platform
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, BAD_PLACES, STEP_MISFIT, STEPPED
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
from pmlsm.motor_geometry import MotorGeometry


class Commutation5DOF:
    """Samples displacements, gaps and current references, commands phase currents that hold until the next sample.

    Each motor commutates with the displacement at its magnets, which the tilts move; they follow from the gaps.
    """

    def __init__(self) -> None:
        self.sample_time = 0.0002        # s, parameter
        self.current_limit = 0.0         # A, parameter, 0 = none
        self.geometry = MotorGeometry()
        self.x = MeasuredDisplacement()
        self.z = MeasuredDisplacement()
        self.alpha1 = CommutatedMotor()
        self.alpha2 = CommutatedMotor()
        self.beta1 = CommutatedMotor()
        self.beta2 = CommutatedMotor()
        self.platform = TiltingPlatform(-0.03)
        self.tilts = TiltMeasurement()
        self.alpha1_place = MotorPlace(0.0, 0.2, 0.025)
        self.alpha2_place = MotorPlace(0.0, -0.2, 0.025)
        self.beta1_place = MotorPlace(0.2, 0.0, 0.025)
        self.beta2_place = MotorPlace(-0.2, 0.0, 0.025)
        self.clock = SampleClock()
        self.saturated = False  # output

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        if not self.geometry.prepare():
            return BAD_GEOMETRY
        if not prepare_platform(self.platform, self.alpha1_place, self.alpha2_place, self.beta1_place,
                                self.beta2_place):
            return BAD_PLACES
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
        platform = self.platform
        tilts = self.tilts
        measure_tilts(tilts, self.alpha1_place, self.alpha2_place, self.beta1_place, self.beta2_place)
        along_x = platform.along_x(self.x.measured, tilts.pitch)
        along_z = platform.along_z(self.z.measured, tilts.roll)
        alpha1_limited = self.alpha1.commutate(self.current_limit, geometry.electrical_angle(along_x))
        alpha2_limited = self.alpha2.commutate(self.current_limit, geometry.electrical_angle(along_x))
        beta1_limited = self.beta1.commutate(self.current_limit, geometry.electrical_angle(along_z))
        beta2_limited = self.beta2.commutate(self.current_limit, geometry.electrical_angle(along_z))
        self.saturated = alpha1_limited or alpha2_limited or beta1_limited or beta2_limited
