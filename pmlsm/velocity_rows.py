"""Velocity rows of (4.3) and (5.3): effect of the motors on the mover, in plants, controllers and estimators.

    vertical     g'' = G − C_iron f4 Σ(i_q² + i_d²) + C_coils f3 Σ i_d − C_attraction f2
    horizontal   x'' = −C_thrust f1 i_q

The sums run over the currents: one motor's on the 2-DOF stage, those of the pairs alpha and beta on the 3-DOF stage. A
pair is two motors with one current, so that there a constant of a current counts twice and the attraction four times.
(5.3) prints the x and z rows without their factor 2; (5.1) and (5.2) have it (corrected).
"""

GRAVITY = 9.81   # G, m/s²


def thrust_term(thrust: float, f1: float, i_q: float) -> float:
    """Acceleration (m/s²) of a horizontal axis by its quadrature current (A); `thrust` in m/(s² A)."""
    return -thrust * f1 * i_q


def normal_terms(attraction: float, coils: float, iron: float, f2: float, f3: float, f4: float, direct: float,
                 squares: float) -> tuple[float, float, float]:
    """Terms of the vertical row by the motors.

    Parameters
    ----------
    attraction, coils, iron : float
        Constants of magnets and iron, magnets and coils, coils and iron: m/(s² T²), m/(s² A T), m/(s² A²).
    f2, f3, f4 : float
        Shape functions at the air gap.
    direct, squares : float
        Σ i_d, A, and Σ(i_q² + i_d²), A².

    Returns
    -------
    by_attraction, by_coils, by_iron : float
        m/s²; with constants of 1 the columns of A(y, u) in section 3.1.
    """
    return -attraction * f2, coils * f3 * direct, -iron * f4 * squares


def normal_acceleration(attraction: float, coils: float, iron: float, f2: float, f3: float, f4: float, direct: float,
                        squares: float) -> float:
    """Acceleration (m/s²) of the air gap by the motors and gravity; arguments as of `normal_terms`.

    The terms are added in the order of (5.3), which decides the last bits.
    """
    return GRAVITY - iron * f4 * squares + coils * f3 * direct - attraction * f2
