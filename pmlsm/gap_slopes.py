"""Derivatives of the shape functions with respect to the air gap, for linearisation."""

from math import cosh, log, pi, sinh

from pmlsm.data_sheet import MAGNET_HEIGHT, POLE_PITCH, RECOIL_PERMEABILITY, SLOT_PITCH, SLOT_WIDTH
from pmlsm.gap_functions import carter_coefficient, clamp_gap, gap_functions, slot_permeance
from pmlsm.magnet_field import magnet_field, magnet_field_slope


def slot_permeance_slope(gap: float) -> float:
    """dλ/dg (1/m) at an air gap (m)."""
    reach = gap + SLOT_WIDTH / 2.0 + MAGNET_HEIGHT / RECOIL_PERMEABILITY
    return SLOT_WIDTH * SLOT_WIDTH / (4.0 * SLOT_PITCH * reach * reach)


def carter_slope(gap: float) -> float:
    """dKc/dg (1/m) at an air gap (m).

    With r = b0/(2g): d(g γ1)/dg = −2/π ln(1 + r²), for the terms in atan r cancel.
    """
    ratio = SLOT_WIDTH / (2.0 * gap)
    carter = carter_coefficient(gap)
    return -carter * carter / SLOT_PITCH * (2.0 / pi) * log(1.0 + ratio * ratio)


def gap_slopes(gap: float) -> tuple[float, float, float]:
    """Slopes df2/dg, df3/dg, df4/dg (per m) of the shape functions of the normal forces.

    By logarithmic derivatives: f2 = λ B², f3 = λ B coth a / Kc, f4 = λ coth² a / Kc². The air gap (m) is limited to
    8…40 mm as in `gap_functions`.
    """
    g = clamp_gap(gap)
    a = pi / POLE_PITCH * (MAGNET_HEIGHT + g)
    permeance = slot_permeance_slope(g) / slot_permeance(g)
    field = magnet_field_slope(g) / magnet_field(g)
    coth_over_carter = -pi / POLE_PITCH / (sinh(a) * cosh(a)) - carter_slope(g) / carter_coefficient(g)
    f1, f2, f3, f4 = gap_functions(g)
    return (f2 * (permeance + 2.0 * field),
            f3 * (permeance + field + coth_over_carter),
            f4 * (permeance + 2.0 * coth_over_carter))
