"""Motors of one kind that drive one axis: they share an electrical angle."""

from pmlsm.electrical_angle import ElectricalAngle


class MotorGroup:
    """Numbers of the kind and the axis that motors have in common, and the electrical angle at their displacement."""

    def __init__(self, kind: int, axis: int):
        self.kind = kind
        self.axis = axis
        self.angle = ElectricalAngle()
        self.attraction = 0.0      # N/T², of each motor at this place along the slots; where the platform tilts
