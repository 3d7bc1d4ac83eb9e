"""Linear models of the control laws."""
