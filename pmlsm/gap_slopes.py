"""Derivatives of the shape functions with respect to the air gap, for linearisation."""

from math import pi

from pmlsm.exponential import exponential_minus_one
from pmlsm.gap_functions import carter_coefficient, gap_functions, slot_permeance
from pmlsm.logarithm import logarithm_one_plus
from pmlsm.motor_geometry import MotorGeometry


def slot_permeance_slope(motor: MotorGeometry, gap: float) -> float:
    """dλ/dg (1/m) at an air gap (m)."""
    reach = gap + motor.slot_height
    return motor.slot_loss / (reach * reach)


def carter_slope(motor: MotorGeometry, gap: float) -> float:
    """dKc/dg (1/m) at an air gap (m).

    With r = b0/(2g): d(g γ1)/dg = −2/π ln(1 + r²), for the terms in atan r cancel.
    """
    ratio = motor.slot_width / (2.0 * gap)
    carter = carter_coefficient(motor, gap)
    return -carter * carter / motor.slot_pitch * (2.0 / pi) * logarithm_one_plus(ratio * ratio)


def gap_slopes(motor: MotorGeometry, gap: float) -> tuple[float, float, float]:
    """Slopes df2/dg, df3/dg, df4/dg (per m) of the shape functions of the normal forces.

    By logarithmic derivatives: f2 = λ B², f3 = λ B coth a / Kc, f4 = λ coth² a / Kc². The air gap (m) is limited to
    the range of the field as in `gap_functions`.
    """
    g = motor.field.clamp(gap)
    twice = exponential_minus_one(2.0 * motor.wave_number * (motor.magnet_height + g))   # e^2a − 1
    permeance = slot_permeance_slope(motor, g) / slot_permeance(motor, g)
    b = motor.field.value(g)
    field = motor.field.slope(g) / b if b != 0.0 else 0.0
    coth_over_carter = (-4.0 * motor.wave_number * (twice + 1.0) / (twice * (twice + 2.0))   # −κ/(sinh a cosh a)
                        - carter_slope(motor, g) / carter_coefficient(motor, g))
    f1, f2, f3, f4 = gap_functions(motor, g)
    return (f2 * (permeance + 2.0 * field),
            f3 * (permeance + field + coth_over_carter),
            f4 * (permeance + 2.0 * coth_over_carter))
