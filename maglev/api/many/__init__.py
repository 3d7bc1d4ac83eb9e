"""Functions that run a scenario many times."""
