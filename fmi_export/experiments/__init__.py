"""Experiments that an FMU carries: inputs, parameters and the results that are expected (FMI-LS-REF)."""
