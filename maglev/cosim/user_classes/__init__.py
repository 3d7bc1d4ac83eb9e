"""Classes that users write, with the face of an FMU."""
