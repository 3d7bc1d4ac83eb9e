"""What the motor's forces owe to the air gap: permeance, Carter's coefficient, magnet field, shape functions."""

from math import atan, cosh, log, pi, sinh, sqrt

from pmlsm.data_sheet import MAGNET_HEIGHT, POLE_PITCH, RECOIL_PERMEABILITY, SLOT_PITCH, SLOT_WIDTH

SMALLEST_GAP = 8.0e-3    # m, the field polynomial holds from here
LARGEST_GAP = 40.0e-3    # m, to here
FIELD_CENTRE = 24.0e-3   # m, s = 0 of the field polynomial
FIELD_SCALE = 16.0e-3    # m, s = ±1 at the ends of its range


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


def magnet_field(gap: float) -> float:
    """Field B_pmy1 of the permanent magnets (T) at an air gap of 8…40 mm (m).

    The thesis uses a polynomial of the twelfth degree and does not print it. Assumed here: one fitted to the
    equilibrium currents and cogging forces that the thesis shows (Figs. 4.10, 4.11, 4.14, 5.11, 5.12, 5.15).
    """
    s = (gap - FIELD_CENTRE) / FIELD_SCALE
    b = 1.3611197230058667e-10
    b = b * s - 7.528843720102103e-10
    b = b * s - 6.403219303184752e-09
    b = b * s + 1.4195702585893311e-07
    b = b * s - 1.014432002730224e-06
    b = b * s + 4.431632232147665e-08
    b = b * s + 7.086337942227495e-05
    b = b * s - 0.0007904078321495497
    b = b * s + 0.005047294856769541
    b = b * s - 0.02135418663882956
    b = b * s + 0.059845610577103754
    b = b * s - 0.10193303675188958
    return b * s + 0.08063180815083942


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
