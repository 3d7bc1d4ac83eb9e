"""Feedback linearisation: the direct current that makes the vertical acceleration a demanded one."""

from math import sqrt


def smaller_root(a: float, b: float, c: float) -> tuple[float, bool]:
    """Smaller root u of a u² − b u + c = 0 (a > 0) as in (4.12) and (5.7), and whether there is a real one.

    Where there is none, the vertex: the current that comes nearest to the demand.
    """
    discriminant = b * b - 4.0 * a * c
    if discriminant < 0.0:
        return b / (2.0 * a), False
    return (b - sqrt(discriminant)) / (2.0 * a), True
