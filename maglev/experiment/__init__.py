"""A run made ready: FMU files, start values, reference signals; runs in order, in processes; results."""
