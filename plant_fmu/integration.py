"""Division of a communication step into integration steps."""

LONGEST_COMMUNICATION_STEP = 1.0e3   # s; a longer one is a mistake that would take hours
ROUNDING = 1.0e-9   # of an integration step, so that a quotient that is whole up to rounding stays whole


def integration_steps(dt: float, longest: float) -> int:
    """Smallest number of equal integration steps, none longer than `longest` (s), that make up a step dt (s)."""
    return int(dt / longest - ROUNDING) + 1
