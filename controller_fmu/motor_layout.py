"""The motors of a stage as controllers and estimators know them: their kinds, and the axis that each drives."""

from pmlsm.motor_geometry import MotorGeometry
from pmlsm.motor_ratio import MotorRatio
from pmlsm.rig import Rig


class MotorKind:
    """Motors that are alike: their geometry, and their constants by those of the model."""

    def __init__(self, geometry: MotorGeometry, ratio: MotorRatio):
        self.geometry = geometry
        self.ratio = ratio


class MotorLayout:
    """Which kind each motor is of, and which horizontal axis it drives; kind 0 is the one that the constants are of."""

    def __init__(self, rig: Rig):
        self.kinds = [MotorKind(rig.motor(), MotorRatio(1.0, 1.0, 1.0, 1.0, 1.0))]
        self.kinds += [MotorKind(rig.motor(motor), MotorRatio(*motor.ratios, motor.kind.limit))
                       for motor in rig.motors if motor.kind is not None]
        unlike = [motor.name for motor in rig.unlike]
        horizontal = [axis.name for axis in rig.horizontal]
        self.kind = [1 + unlike.index(motor.name) if motor.name in unlike else 0 for motor in rig.motors]
        self.drives = [horizontal.index(motor.drives) for motor in rig.motors]
        # Motors by the axes that they drive, the first axis first.
        self.by_axis = [k for axis in range(len(horizontal)) for k, drives in enumerate(self.drives) if drives == axis]
        # Motors that stand for all where all have the same direct current, and for those of an axis.
        self.sharing = rig.sharing   # motors that share each current

    def prepare(self) -> bool:
        """Compute what follows from the geometries; False where one is of no motor."""
        fine = True
        for kind in self.kinds:
            if not kind.geometry.prepare():
                fine = False
        return fine
