"""Symmetric positive definite matrix of three rows: Σ of a row with three constants, JᵀJ of motors on a platform."""

SMALLEST_PIVOT = 1.0e-13   # of the diagonal element; below, rounding has left nothing of it
LEAST_PIVOT = 1.0e-250      # below, its inverse could overflow


class Symmetric3:
    """Matrix by its six elements, and its factors L D Lᵀ."""

    def __init__(self) -> None:
        self.s11 = 1.0   # state
        self.s22 = 1.0   # state
        self.s33 = 1.0   # state
        self.s21 = 0.0   # state
        self.s31 = 0.0   # state
        self.s32 = 0.0   # state
        self.l21 = 0.0   # L, with ones on its diagonal
        self.l31 = 0.0
        self.l32 = 0.0
        self.g1 = 1.0    # D⁻¹; 0 leaves a row out that depends on those before it
        self.g2 = 1.0
        self.g3 = 1.0

    def set_diagonal(self, d1: float, d2: float, d3: float) -> None:
        """Make it a diagonal matrix."""
        self.s11 = d1
        self.s22 = d2
        self.s33 = d3
        self.s21 = 0.0
        self.s31 = 0.0
        self.s32 = 0.0

    def decay(self, share: float, d1: float, d2: float, d3: float) -> None:
        """Go a share of the way to a diagonal matrix."""
        kept = 1.0 - share
        self.s11 = kept * self.s11 + share * d1
        self.s22 = kept * self.s22 + share * d2
        self.s33 = kept * self.s33 + share * d3
        self.s21 *= kept
        self.s31 *= kept
        self.s32 *= kept

    def add_square(self, weight: float, a1: float, a2: float, a3: float) -> None:
        """Add weight · aᵀa of a row a."""
        self.s11 += weight * a1 * a1
        self.s22 += weight * a2 * a2
        self.s33 += weight * a3 * a3
        self.s21 += weight * a2 * a1
        self.s31 += weight * a3 * a1
        self.s32 += weight * a3 * a2

    def factorise(self) -> None:
        """Compute the factors."""
        self.g1 = inverse_pivot(self.s11, self.s11)
        self.l21 = self.s21 * self.g1
        self.l31 = self.s31 * self.g1
        self.g2 = inverse_pivot(self.s22 - self.l21 * self.s21, self.s22)
        rest = self.s32 - self.l31 * self.s21
        self.l32 = rest * self.g2
        self.g3 = inverse_pivot(self.s33 - self.l31 * self.s31 - self.l32 * rest, self.s33)

    def solve(self, a1: float, a2: float, a3: float) -> tuple[float, float, float]:
        """Solution u of S u = aᵀ, by the factors."""
        z2 = a2 - self.l21 * a1
        z3 = a3 - self.l31 * a1 - self.l32 * z2
        u3 = z3 * self.g3
        u2 = z2 * self.g2 - self.l32 * u3
        return a1 * self.g1 - self.l21 * u2 - self.l31 * u3, u2, u3

    def inverse_diagonal(self) -> tuple[float, float, float]:
        """Diagonal of S⁻¹, by the factors."""
        k31 = self.l21 * self.l32 - self.l31   # lower corner of L⁻¹
        return (self.g1 + self.l21 * self.l21 * self.g2 + k31 * k31 * self.g3,
                self.g2 + self.l32 * self.l32 * self.g3,
                self.g3)


def inverse_pivot(pivot: float, diagonal: float) -> float:
    """1 / pivot; 0 where the pivot is nothing but rounding of the diagonal element."""
    if pivot <= SMALLEST_PIVOT * diagonal or pivot <= LEAST_PIVOT:
        return 0.0
    return 1.0 / pivot
