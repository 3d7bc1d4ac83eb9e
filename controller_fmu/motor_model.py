"""The controllers' model of the motors: the constants of the velocity rows, and the motors' layout."""

from controller_fmu.motor_layout import MotorLayout
from pmlsm.stage_description import StageDescription


class MotorModel:
    """Constants of a stage as its controllers take them; see `pmlsm.velocity_rows`."""

    def __init__(self, stage: StageDescription):
        self.thrust = [stage.model.thrust[axis.name] for axis in stage.horizontal]   # m/(s² A), parameters: by axis
        self.attraction = stage.model.attraction   # m/(s² T²), parameter: between magnets and iron
        self.coils = stage.model.coils             # m/(s² A T), parameter: between magnets and coils
        self.iron = stage.model.iron               # m/(s² A²), parameter: between coils and iron
        self.layout = MotorLayout(stage)
        self.carrying = stage.carrying             # motors that carry the mover
        # Motors that drive each horizontal axis, with those that share their current.
        self.driving = [stage.sharing * len(stage.motors_of(axis.name)) for axis in stage.horizontal]

    def carried(self, kind: int) -> tuple[float, float, float]:
        """Constants of attraction, coils and iron as though all motors were of a kind, and had one direct current."""
        ratio = self.layout.kinds[kind].ratio
        carrying = self.carrying
        return (carrying * ratio.attraction * self.attraction, carrying * ratio.coils * self.coils,
                carrying * ratio.iron * self.iron)
