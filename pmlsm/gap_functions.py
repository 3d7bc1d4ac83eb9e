"""Effect of the air gap on the motor's forces: permeance, Carter's coefficient, shape functions."""

from math import nan

from pmlsm.arctangent import arctangent_integral
from pmlsm.exponential import exponential_minus_one
from pmlsm.motor_geometry import MotorGeometry


def slot_permeance(motor: MotorGeometry, gap: float) -> float:
    """Relative permeance λ of the stator slots at an air gap (m), equation (2.3)."""
    return 1.0 - motor.slot_loss / (gap + motor.slot_height)


def carter_coefficient(motor: MotorGeometry, gap: float) -> float:
    """Carter's coefficient Kc = t1/(t1 − g γ1) at an air gap (m), page 12; γ1 = 4/π ∫ arctan from 0 to b0/(2g)."""
    return 1.0 / (1.0 - motor.carter_share * gap * arctangent_integral(0.5 * motor.slot_width / gap))


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
    # From e^a − 1 alone: sinh a = (e^2a − 1)/(2 e^a), coth a = (e^2a + 1)/(e^2a − 1).
    grown = exponential_minus_one(motor.wave_number * (motor.magnet_height + g))
    twice = grown * (grown + 2.0)   # e^2a − 1
    share = 1.0 / (carter * twice)
    coth_over_carter = (twice + 2.0) * share
    return (2.0 * permeance * (1.0 + grown) * share,
            permeance * b * b,
            permeance * b * coth_over_carter,
            permeance * coth_over_carter * coth_over_carter)


class GapEffect:
    """Shape functions f1 … f4 at the air gap of a motor."""

    def __init__(self) -> None:
        self.f1 = 0.0
        self.f2 = 0.0
        self.f3 = 0.0
        self.f4 = 0.0
        self.gap = nan   # m, to which they belong

    def follow(self, motor: MotorGeometry, gap: float) -> None:
        """Go to an air gap (m), where it may be already: a step begins where the one before has ended."""
        if gap != self.gap:
            self.f1, self.f2, self.f3, self.f4 = gap_functions(motor, gap)
            self.gap = gap

    def forget(self) -> None:
        """Start again, with a geometry that may have changed."""
        self.gap = nan
