"""Feedback linearisation (4.12), (5.7): the direct current that makes the vertical acceleration a demanded one."""

from math import sqrt

from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.velocity_rows import GRAVITY


def smaller_root(a: float, b: float, c: float) -> tuple[float, bool]:
    """Smaller root u of a u² − b u + c = 0 (a > 0) as in (4.12) and (5.7), and whether there is a real one.

    Where there is none, the vertex: the current that comes nearest to the demand.
    """
    discriminant = b * b - 4.0 * a * c
    if discriminant < 0.0:
        return b / (2.0 * a), False
    return (b - sqrt(discriminant)) / (2.0 * a), True


def demanded_current(demand: float, by_quadrature: float, attraction: float, coils: float, iron: float, f2: float,
                     f3: float, f4: float) -> tuple[float, bool]:
    """Root i_d of G − iron f4 i_d² + coils f3 i_d − attraction f2 − by_quadrature = demand.

    Parameters
    ----------
    demand : float
        Vertical acceleration, m/s².
    by_quadrature : float
        Reduction by the quadrature currents, iron f4 Σ i_q², m/s².
    attraction, coils, iron : float
        C2, C3, C4 of the 2-DOF model, m/(s² T²), m/(s² A T), m/(s² A²); with one direct current in both pairs 4 C3, 4
        C4, 4 C5 of the 3-DOF model.
    f2, f3, f4 : float
        Shape functions at the air gap.

    Returns
    -------
    current : float
        A; the same in all motors.
    feasible : bool
        Whether it makes the demanded acceleration.
    """
    return smaller_root(iron * f4, coils * f3, demand - GRAVITY + by_quadrature + attraction * f2)


def equilibrium_current(motor: MotorGeometry, attraction: float, coils: float, iron: float, gap: float
                        ) -> tuple[float, bool]:
    """Direct current (A) that holds the mover at a gap (m), and whether there is one; constants as above."""
    f1, f2, f3, f4 = gap_functions(motor, gap)
    return demanded_current(0.0, 0.0, attraction, coils, iron, f2, f3, f4)
