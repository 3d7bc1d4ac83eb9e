"""A block as C: translation, FMI layer, binaries for several platforms."""
