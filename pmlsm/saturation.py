"""The saturation of amplifiers and command limits."""


def saturate(value: float, bound: float) -> float:
    """Limit a value to ±bound (same unit, bound not negative)."""
    if value > bound:
        return bound
    if value < -bound:
        return -bound
    return value
