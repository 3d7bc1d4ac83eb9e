"""Commutation of the motors of any stage alone (C.1), for currents that somebody else decides."""

from controller_fmu.commutated_motor import CommutatedMotor, MeasuredDisplacement
from controller_fmu.described_platform import platform_of
from controller_fmu.level_platform import LevelPlatform
from controller_fmu.motor_layout import MotorLayout
from controller_fmu.sample_clock import SampleClock
from controller_fmu.sampled import Sampled
from controller_fmu.status import BAD_GEOMETRY, BAD_PLACES, STEPPED
from pmlsm.stage_description import StageDescription


class Commutation(Sampled):
    """Samples displacements and current references, commands phase currents that hold until the next sample.

    Each motor commutates with the displacement that it drives. On a platform that tilts it is that at its magnets,
    which the tilts move; they follow from the gaps at the motors.
    """

    def __init__(self, stage: StageDescription):
        self.sample_time = stage.sample_time   # s, parameter
        self.current_limit = 0.0             # A, parameter, 0 = none
        self.layout = MotorLayout(stage)
        self.axes = [MeasuredDisplacement() for _ in stage.horizontal]
        self.motors = [CommutatedMotor() for _ in stage.motors]
        self.platform = platform_of(stage) if stage.rotations else LevelPlatform()
        self.clock = SampleClock()
        self.saturated = False   # output

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        if not self.layout.prepare():
            return BAD_GEOMETRY
        if not self.platform.prepare():
            return BAD_PLACES
        return STEPPED

    def sample(self) -> None:
        """Commutate once."""
        layout = self.layout
        self.platform.measure(0.0)
        self.saturated = False
        for motor, k, kind in zip(self.motors, layout.drives, layout.kind, strict=True):
            along = self.platform.along(k, self.axes[k].measured)
            if motor.commutate(self.current_limit, layout.kinds[kind].geometry.electrical_angle(along)):
                self.saturated = True
