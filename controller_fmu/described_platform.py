"""The platform of a stage and its forces, from the description of the stage."""

from controller_fmu.force_allocation import ForceAllocation
from controller_fmu.motor_place import MotorPlace
from controller_fmu.tilting_platform import TiltingPlatform
from pmlsm.stage_description import StageDescription


def platform_of(stage: StageDescription) -> TiltingPlatform:
    """Return the platform of a stage that tilts."""
    places = [MotorPlace(motor.x, motor.z, stage.vertical.start) for motor in stage.motors]
    return TiltingPlatform(stage.height, places, len(stage.horizontal))


def allocation_of(stage: StageDescription) -> ForceAllocation:
    """Return the allocation of a stage; directions that guides hold get an arbitrary mass."""
    x, *z = (axis.mass for axis in stage.horizontal)
    roll, *pitch = (axis.mass for axis in stage.rotations)
    return ForceAllocation(stage.vertical.mass, x, z[0] if z else 1.0, roll, pitch[0] if pitch else 1.0)
