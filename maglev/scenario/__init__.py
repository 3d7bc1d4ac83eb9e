"""Scenario files: TOML, signals, claims, and the FMUs that they need."""
