"""What every refusal of an identification has in common."""


class IdentificationError(ValueError):
    """Data, settings or a model file that cannot be used; one line with file, key or column, value and expectation."""
