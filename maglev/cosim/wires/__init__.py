"""What goes from which FMU to which other one, and in which order they begin."""
