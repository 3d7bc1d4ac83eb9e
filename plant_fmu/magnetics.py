"""Data of the motors' forces: constants of the velocity rows, geometry, magnets, electrical angles."""

from plant_fmu.motor_group import MotorGroup
from pmlsm.motor_kind import motor_kinds
from pmlsm.stage_description import StageDescription


def motor_groups(stage: StageDescription) -> list[tuple[int, int]]:
    """Return the number of the kind of each motor, and that of the axis that it drives."""
    unlike, horizontal = [motor.name for motor in stage.unlike], [axis.name for axis in stage.horizontal]
    return [(1 + unlike.index(motor.name) if motor.name in unlike else 0, 1 + horizontal.index(motor.drives))
            for motor in stage.motors]


class Magnetics:
    """Constants of all motors, their kinds, and their groups of one kind and one axis; see `pmlsm.velocity_rows`.

    The constants are accelerations at the nominal masses of the axes.
    """

    def __init__(self, stage: StageDescription):
        of = stage.plant
        # m/(s² A), parameters: along each of the axes
        self.thrust = [of.thrust[axis.name] for axis in stage.horizontal]
        self.attraction = of.attraction       # m/(s² T²), parameter: attraction between magnets and iron
        self.coils = of.coils                 # m/(s² A T), parameter: normal force between magnets and coils
        self.iron = of.iron                   # m/(s² A²), parameter: normal force between coils and iron
        self.modulation = stage.modulation      # parameter: of the attraction along the slots
        self.magnet_rise = 0.0                # K, parameter: how warm the magnets are, above the constants' temperature
        self.sharing = stage.sharing            # motors that share each current
        self.carrying = stage.carrying          # motors that carry the mover
        self.kinds = motor_kinds(stage)
        self.groups = [MotorGroup(kind, axis) for kind, axis in dict.fromkeys(motor_groups(stage))]

    def prepare(self) -> bool:
        """Compute what follows from the geometries; False where one is of no motor."""
        for kind in self.kinds:
            if not kind.geometry.prepare():
                return False
        for group in self.groups:
            group.angle.forget()
        return True
