"""What the motor's forces owe to the air gap: permeance, Carter's coefficient, shape functions."""

from math import atan, cosh, log, pi, sinh, sqrt

from pmlsm.magnet_field import MagnetField  # noqa: F401 - pyccel finds its methods only where it is imported
from pmlsm.motor_geometry import MotorGeometry


def slot_permeance(motor: MotorGeometry, gap: float) -> float:
    """Relative permeance λ of the stator slots at an air gap (m), equation (2.3)."""
    return 1.0 - motor.slot_width * motor.slot_width / (
        4.0 * motor.slot_pitch * (gap + motor.slot_width / 2.0 + motor.recoil_height))


def carter_coefficient(motor: MotorGeometry, gap: float) -> float:
    """Carter's coefficient Kc at an air gap (m), page 12."""
    ratio = motor.slot_width / (2.0 * gap)
    gamma1 = 4.0 / pi * (ratio * atan(ratio) - log(sqrt(1.0 + ratio * ratio)))
    return motor.slot_pitch / (motor.slot_pitch - gap * gamma1)


def gap_functions(motor: MotorGeometry, gap: float) -> tuple[float, float, float, float]:
    """Shape functions of the forces at an air gap (m), from (2.2) and (2.4); the gap is limited to the field's range.

    Returns
    -------
    f1 : float
        Thrust, λ / (Kc sinh a), with a = π/τ (hm + g).
    f2 : float
        Attraction between magnets and iron, λ B², T².
    f3 : float
        Normal force between magnets and coils, λ B coth a / Kc, T.
    f4 : float
        Normal force between coils and iron, λ coth² a / Kc².
    """
    g = motor.field.clamp(gap)
    permeance = slot_permeance(motor, g)
    carter = carter_coefficient(motor, g)
    b = motor.field.value(g)
    a = motor.wave_number * (motor.magnet_height + g)
    sinh_a = sinh(a)
    coth_over_carter = cosh(a) / sinh_a / carter
    return (permeance / (carter * sinh_a),
            permeance * b * b,
            permeance * b * coth_over_carter,
            permeance * coth_over_carter * coth_over_carter)
