"""What the motor's forces owe to the air gap: permeance, Carter's coefficient, shape functions."""

from math import atan, cosh, log, pi, sinh, sqrt

from pmlsm.data_sheet import MAGNET_HEIGHT, POLE_PITCH, RECOIL_PERMEABILITY, SLOT_PITCH, SLOT_WIDTH
from pmlsm.magnet_field import magnet_field

SMALLEST_GAP = 8.0e-3    # m, the field polynomial holds from here
LARGEST_GAP = 40.0e-3    # m, to here


def clamp_gap(gap: float) -> float:
    """Limit an air gap (m) to 8…40 mm, where the magnet field is known and nothing divides by zero."""
    if gap < SMALLEST_GAP:
        return SMALLEST_GAP
    if gap > LARGEST_GAP:
        return LARGEST_GAP
    return gap


def slot_permeance(gap: float) -> float:
    """Relative permeance λ of the stator slots at an air gap (m), equation (2.3)."""
    return 1.0 - SLOT_WIDTH * SLOT_WIDTH / (
        4.0 * SLOT_PITCH * (gap + SLOT_WIDTH / 2.0 + MAGNET_HEIGHT / RECOIL_PERMEABILITY))


def carter_coefficient(gap: float) -> float:
    """Carter's coefficient Kc at an air gap (m), page 12."""
    ratio = SLOT_WIDTH / (2.0 * gap)
    gamma1 = 4.0 / pi * (ratio * atan(ratio) - log(sqrt(1.0 + ratio * ratio)))
    return SLOT_PITCH / (SLOT_PITCH - gap * gamma1)


def gap_functions(gap: float) -> tuple[float, float, float, float]:
    """Shape functions of the forces at an air gap (m), from (2.2) and (2.4); the gap is limited to 8…40 mm.

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
    g = clamp_gap(gap)
    permeance = slot_permeance(g)
    carter = carter_coefficient(g)
    b = magnet_field(g)
    a = pi / POLE_PITCH * (MAGNET_HEIGHT + g)
    sinh_a = sinh(a)
    coth_over_carter = cosh(a) / sinh_a / carter
    return (permeance / (carter * sinh_a),
            permeance * b * b,
            permeance * b * coth_over_carter,
            permeance * coth_over_carter * coth_over_carter)
