"""Frequency responses of loops that fly: what is added to a measurement, and what comes back."""
