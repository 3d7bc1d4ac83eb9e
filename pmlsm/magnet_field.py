"""Field of the permanent magnets over the air gap."""


class MagnetField:
    """Polynomial of the twelfth degree in s = (g − centre)/scale, for air gaps from `lower` to `upper`.

    The thesis uses such a polynomial and does not print it. Assumed here: one fitted to the equilibrium currents and
    cogging forces that the thesis shows (Figs. 4.10, 4.11, 4.14, 5.11, 5.12, 5.15).
    """

    def __init__(self) -> None:
        self.lower = 8.0e-3     # m, parameter: the polynomial holds from here
        self.upper = 40.0e-3    # m, parameter: to here
        self.centre = 24.0e-3   # m, parameter: s = 0
        self.scale = 16.0e-3    # m, parameter: s = 1 is so far from the centre
        self.B0 = 0.08063180815083942      # T, parameter: coefficient of s⁰
        self.B1 = -0.10193303675188958     # T, parameter: of s¹, and so on
        self.B2 = 0.059845610577103754
        self.B3 = -0.02135418663882956
        self.B4 = 0.005047294856769541
        self.B5 = -0.0007904078321495497
        self.B6 = 7.086337942227495e-05
        self.B7 = 4.431632232147665e-08
        self.B8 = -1.014432002730224e-06
        self.B9 = 1.4195702585893311e-07
        self.B10 = -6.403219303184752e-09
        self.B11 = -7.528843720102103e-10
        self.B12 = 1.3611197230058667e-10

    def clamp(self, gap: float) -> float:
        """Limit an air gap (m) to where the field is known and nothing divides by zero."""
        if gap < self.lower:
            return self.lower
        if gap > self.upper:
            return self.upper
        return gap

    def value(self, gap: float) -> float:
        """Field B_pmy1 (T) at an air gap (m) within the range of the polynomial."""
        s = (gap - self.centre) / self.scale
        return self.B0 + s * (self.B1 + s * (self.B2 + s * (self.B3 + s * (self.B4 + s * (self.B5 + s * (
            self.B6 + s * (self.B7 + s * (self.B8 + s * (self.B9 + s * (self.B10 + s * (
                self.B11 + s * self.B12)))))))))))

    def slope(self, gap: float) -> float:
        """Derivative dB/dg (T/m) at an air gap (m) within the range of the polynomial."""
        s = (gap - self.centre) / self.scale
        d = 12.0 * self.B12 * s + 11.0 * self.B11
        d = d * s + 10.0 * self.B10
        d = d * s + 9.0 * self.B9
        d = d * s + 8.0 * self.B8
        d = d * s + 7.0 * self.B7
        d = d * s + 6.0 * self.B6
        d = d * s + 5.0 * self.B5
        d = d * s + 4.0 * self.B4
        d = d * s + 3.0 * self.B3
        d = d * s + 2.0 * self.B2
        d = d * s + self.B1
        return d / self.scale
