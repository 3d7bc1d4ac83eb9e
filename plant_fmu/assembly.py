"""Makes the parts of a stage from its description."""

from plant_fmu.axis import Axis
from plant_fmu.magnetics import motor_groups
from plant_fmu.motor_supply import MotorSupply
from pmlsm.stage_description import Rig, RigAxis, Stop

NO_STOP = Stop(-10.0, 10.0, 0.0, 0.0)   # of an axis whose stops are at the motors


def axis_of(rig: RigAxis) -> Axis:
    """Return an axis as it is described."""
    stop, friction = rig.stop or NO_STOP, rig.friction
    axis = Axis(rig.mass, rig.bias, friction.coulomb, friction.presliding, friction.viscous, stop.lower, stop.upper,
                rig.start)
    axis.stop.stiffness, axis.stop.damping = stop.stiffness, stop.damping
    axis.ripple.amplitude, axis.ripple.period = rig.ripple.amplitude, rig.ripple.period
    axis.roughness.rms, axis.roughness.correlation = rig.roughness.rms, rig.roughness.correlation
    mode = axis.mode
    mode.frequency, mode.damping = rig.mode.frequency, rig.mode.damping
    mode.mass_share, mode.encoder_share = rig.mode.mass_share, rig.mode.encoder_share
    return axis


def supplies_of(rig: Rig) -> list[MotorSupply]:
    """Return the supplies of all motors as they are described."""
    groups = motor_groups(rig)
    distinct = list(dict.fromkeys(groups))
    supplies = []
    for motor, group in zip(rig.motors, groups, strict=True):
        amplifier, winding = motor.amplifier, motor.winding
        supplies.append(MotorSupply(amplifier.peak, amplifier.continuous, winding.resistance, winding.inductance,
                                    group[1], distinct.index(group)))
        supplies[-1].amplifier.lag = amplifier.lag
    return supplies
