"""Times that are whole numbers of steps: counted here, in one way, by whatever has a step."""

from maglev.files.errors import QuantityError

MOST_STEPS = 1e8   # communication steps of a run
ON_GRID = 1e-6     # steps that a time may lie next to the grid: k h is rounded, at most 2e-8 h at MOST_STEPS


def whole_steps(time: float, step: float) -> int:
    """Number of steps (s) in a time (s), at least 1 and at most `MOST_STEPS`.

    QuantityError if it is not whole. The message begins with the expected value: the caller puts the owner of the time
    before it.
    """
    steps = time / step
    if not steps < MOST_STEPS + 0.5:   # the quotient rounds as well
        raise QuantityError(f"{steps:.3g} steps of {step} s, expected at most {MOST_STEPS:.0e}")
    if round(steps) < 1 or abs(round(steps) * step - time) > ON_GRID * step:
        raise QuantityError(f"expected a whole number of communication steps of {step} s")
    return round(steps)
