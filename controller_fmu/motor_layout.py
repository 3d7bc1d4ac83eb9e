"""The motors of a stage as controllers and estimators know them: their kinds, and the axis that each drives."""

from pmlsm.motor_kind import motor_kinds
from pmlsm.stage_description import StageDescription


class MotorLayout:
    """The kind of each motor, 0 for the kind of the constants, and the horizontal axis that it drives."""

    def __init__(self, stage: StageDescription):
        self.kinds = motor_kinds(stage)
        unlike = [motor.name for motor in stage.unlike]
        horizontal = [axis.name for axis in stage.horizontal]
        self.kind = [1 + unlike.index(motor.name) if motor.name in unlike else 0 for motor in stage.motors]
        self.drives = [horizontal.index(motor.drives) for motor in stage.motors]
        # Motors by the axes that they drive, the first axis first.
        self.by_axis = [k for axis in range(len(horizontal)) for k, drives in enumerate(self.drives) if drives == axis]
        self.sharing = stage.sharing   # motors that share each current

    def prepare(self) -> bool:
        """Compute what follows from the geometries; False where one is of no motor."""
        fine = True
        for kind in self.kinds:
            if not kind.geometry.prepare():
                fine = False
        return fine
