"""Error while an FMU is built, which the person who builds it can correct."""


class ExportError(Exception):
    """A tool that is missing, sources that a compiler refuses, or parts that do not fit; the message says which."""
