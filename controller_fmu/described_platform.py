"""The platform of a stage and its forces, from the description of the stage."""

from controller_fmu.force_allocation import ForceAllocation
from controller_fmu.motor_place import MotorPlace
from controller_fmu.tilting_platform import TiltingPlatform
from pmlsm.stage_description import Rig


def platform_of(rig: Rig) -> TiltingPlatform:
    """Return the platform of a stage that tilts."""
    places = [MotorPlace(motor.x, motor.z, rig.vertical.start) for motor in rig.motors]
    return TiltingPlatform(rig.height, places, len(rig.horizontal))


def allocation_of(rig: Rig) -> ForceAllocation:
    """Return the allocation of a stage; masses of what guides hold may be any."""
    x, *z = (axis.mass for axis in rig.horizontal)
    roll, *pitch = (axis.mass for axis in rig.rotations)
    return ForceAllocation(rig.vertical.mass, x, z[0] if z else 1.0, roll, pitch[0] if pitch else 1.0)
