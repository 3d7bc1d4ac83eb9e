"""Co-simulation in a process of its own, for FMUs that may crash, exit or hang."""
