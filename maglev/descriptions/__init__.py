"""Stages as data: their descriptions, and the FMUs that follow from them."""
