"""Safety mechanism that shuts a controller down when it loses the mover (section 4.3, Fig. 4.25)."""


def exceeds(error: float, trip_error: float) -> bool:
    """Return True if a tracking error is larger than the error that trips (m, 0 = never)."""
    return trip_error > 0.0 and (error > trip_error or error < -trip_error)
