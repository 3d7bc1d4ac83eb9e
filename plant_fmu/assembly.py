"""Makes the parts of a stage from its description."""

from plant_fmu.axis import Axis
from plant_fmu.magnetics import motor_groups
from plant_fmu.motor_supply import MotorSupply
from pmlsm.stage_description import StageAxis, StageDescription, Stop

NO_STOP = Stop(-10.0, 10.0, 0.0, 0.0)   # of an axis whose stops are at the motors


def axis_of(stage: StageAxis) -> Axis:
    """Return an axis as it is described."""
    stop, friction = stage.stop or NO_STOP, stage.friction
    axis = Axis(stage.mass, stage.bias, friction.coulomb, friction.presliding, friction.viscous, stop.lower, stop.upper,
                stage.start)
    axis.stop.stiffness, axis.stop.damping = stop.stiffness, stop.damping
    axis.friction.variation, axis.friction.correlation = friction.variation, friction.correlation
    axis.ripple.amplitude, axis.ripple.period = stage.ripple.amplitude, stage.ripple.period
    axis.roughness.rms, axis.roughness.correlation = stage.roughness.rms, stage.roughness.correlation
    mode = axis.mode
    mode.frequency, mode.damping = stage.mode.frequency, stage.mode.damping
    mode.mass_share, mode.encoder_share = stage.mode.mass_share, stage.mode.encoder_share
    return axis


def supplies_of(stage: StageDescription) -> list[MotorSupply]:
    """Return the supplies of all motors as they are described."""
    groups = motor_groups(stage)
    distinct = list(dict.fromkeys(groups))
    supplies = []
    for motor, group in zip(stage.motors, groups, strict=True):
        amplifier, winding = motor.amplifier, motor.winding
        supplies.append(MotorSupply(amplifier.peak, amplifier.continuous, winding.resistance, winding.inductance,
                                    group[1], distinct.index(group)))
        supplies[-1].amplifier.lag = amplifier.lag
    return supplies
