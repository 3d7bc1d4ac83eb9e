"""Motors that are alike: their geometry, and their constants by those of the stage."""

from pmlsm.motor_geometry import MotorGeometry
from pmlsm.motor_ratio import MotorRatio
from pmlsm.stage_description import StageDescription


class MotorKind:
    """Geometry of the motors of a kind, and factors to the constants of the velocity rows."""

    def __init__(self, geometry: MotorGeometry, ratio: MotorRatio):
        self.geometry = geometry
        self.ratio = ratio


def motor_kinds(stage: StageDescription) -> list[MotorKind]:
    """Return the kinds of motors of a stage: first that of its constants, then one for each motor of another kind."""
    return [MotorKind(stage.motor(), MotorRatio(1.0, 1.0, 1.0, 1.0, 1.0)),
            *(MotorKind(stage.motor(motor), MotorRatio(*motor.ratios, motor.kind.limit))
              for motor in stage.motors if motor.kind is not None)]
