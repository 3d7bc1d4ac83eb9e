"""A mover that guides hold level: it has one air gap, and an encoder of it."""

from controller_fmu.motor_place import MotorPlace
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.pid_axis import PIDAxis


class LevelPlatform:
    """Stand-in for a `TiltingPlatform` on a stage that does not tilt."""

    def __init__(self) -> None:
        self.places: list[MotorPlace] = []   # unused

    def prepare(self) -> bool:
        """Return True: the motors may be anywhere."""
        return True

    def measure(self, gap: float) -> bool:
        """Return whether the encoder of the air gap has shown anything (m)."""
        return gap > 0.0

    def centre(self, gap: float) -> float:
        """Air gap (m) at the centre: that of the encoder."""
        return gap

    def gap(self, motor: int, gap: float) -> float:
        """Air gap (m) at a motor: that of the encoder."""
        return gap

    def observe(self, axes: list[OutputRegulator] | list[PIDAxis]) -> bool:
        """Return whether the encoder of the air gap has shown anything: each axis has one."""
        return axes[0].measured > 0.0

    def along(self, axis: int, displacement: float) -> float:
        """Displacement (m) with which the motors of a horizontal axis commutate: that of the mover."""
        return displacement

    def moved(self, motor: int, y: float, roll: float, pitch: float) -> float:
        """Return the displacement at a motor for a displacement and tilts of the mover: the displacement itself."""
        return y
