"""The magnets of the mover, as they get warm."""

COLDER = -1.2e-3   # 1/K, of the field of N35 magnets (sections 4.1.1, 5.1.1), as makers of NdFeB print it


def magnet_strength(rise: float) -> float:
    """Field of the magnets over that at which the constants hold, at a temperature above it (K); linear (assumed)."""
    return 1.0 + COLDER * rise
