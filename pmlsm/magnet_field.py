"""Field of the permanent magnets over the air gap.

The thesis uses a polynomial of the twelfth degree and does not print it. Assumed here: one fitted to the equilibrium
currents and cogging forces that the thesis shows (Figs. 4.10, 4.11, 4.14, 5.11, 5.12, 5.15).
"""

FIELD_CENTRE = 24.0e-3   # m, s = 0 of the polynomial
FIELD_SCALE = 16.0e-3    # m, s = ±1 at the ends of its range

B0 = 0.08063180815083942   # T, coefficient of s⁰
B1 = -0.10193303675188958
B2 = 0.059845610577103754
B3 = -0.02135418663882956
B4 = 0.005047294856769541
B5 = -0.0007904078321495497
B6 = 7.086337942227495e-05
B7 = 4.431632232147665e-08
B8 = -1.014432002730224e-06
B9 = 1.4195702585893311e-07
B10 = -6.403219303184752e-09
B11 = -7.528843720102103e-10
B12 = 1.3611197230058667e-10


def magnet_field(gap: float) -> float:
    """Field B_pmy1 (T) at an air gap of 8…40 mm (m)."""
    s = (gap - FIELD_CENTRE) / FIELD_SCALE
    b = B12 * s + B11
    b = b * s + B10
    b = b * s + B9
    b = b * s + B8
    b = b * s + B7
    b = b * s + B6
    b = b * s + B5
    b = b * s + B4
    b = b * s + B3
    b = b * s + B2
    b = b * s + B1
    return b * s + B0


def magnet_field_slope(gap: float) -> float:
    """Derivative dB/dg (T/m) at an air gap of 8…40 mm (m)."""
    s = (gap - FIELD_CENTRE) / FIELD_SCALE
    d = 12.0 * B12 * s + 11.0 * B11
    d = d * s + 10.0 * B10
    d = d * s + 9.0 * B9
    d = d * s + 8.0 * B8
    d = d * s + 7.0 * B7
    d = d * s + 6.0 * B6
    d = d * s + 5.0 * B5
    d = d * s + 4.0 * B4
    d = d * s + 3.0 * B3
    d = d * s + 2.0 * B2
    d = d * s + B1
    return d / FIELD_SCALE
