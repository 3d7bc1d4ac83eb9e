"""Signals of a scenario: what feeds inputs over time."""
