"""Whole numbers, exactly: to round, add and subtract a number so large that no fraction fits next to it."""

NEAREST_WHOLE = 6755399441055744.0         # 1.5 · 2^52, for numbers to 2^51 either way
NO_FRACTION = 4503599627370496.0      # 2^52: from here on all numbers are whole


def rounded_down(x: float) -> float:
    """Return the largest whole number that is not above x; return x itself if it is NaN or infinite."""
    if not -NO_FRACTION < x < NO_FRACTION:
        return x
    whole = (x + NO_FRACTION) - NO_FRACTION if x >= 0.0 else (x - NO_FRACTION) + NO_FRACTION
    return whole - 1.0 if whole > x else whole


def fraction(x: float) -> float:
    """Return x minus the nearest whole number, −1/2 to 1/2; exact, and 0 where all numbers are whole."""
    if not -NO_FRACTION < x < NO_FRACTION:
        return 0.0 * x
    return x - ((x + NO_FRACTION) - NO_FRACTION if x >= 0.0 else (x - NO_FRACTION) + NO_FRACTION)
