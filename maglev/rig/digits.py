"""Derived constants, kept to so few digits that every machine has the same."""


def kept(value: float) -> float:
    """A number to twelve digits: libraries differ from one another in the last four, and stages would with them."""
    return float(f"{value:.12g}")
