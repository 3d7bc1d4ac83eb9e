"""Co-simulation of FMUs: one FMU, its port map, the wiring of several, their steps."""
