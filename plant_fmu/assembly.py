"""Makes the parts of a stage from its description."""

from plant_fmu.axis import Axis
from plant_fmu.motor_supply import MotorSupply
from pmlsm.rig import RigAxis, RigMotor, Stop

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


def supply_of(rig: RigMotor) -> MotorSupply:
    """Return the supply of a motor as it is described."""
    supply = MotorSupply(rig.amplifier.peak, rig.amplifier.continuous, rig.winding.resistance, rig.winding.inductance)
    supply.amplifier.lag = rig.amplifier.lag
    return supply
