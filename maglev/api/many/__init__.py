"""Functions that fly a scenario many times."""
