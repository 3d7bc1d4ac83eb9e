"""What can go wrong while an FMU is built that whoever builds it can put right."""


class ExportError(Exception):
    """A tool that is missing, sources that a compiler refuses, or parts that do not fit; the message says which."""
