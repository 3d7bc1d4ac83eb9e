"""Extras of this package: packages that are not installed with it, and the commands that install them."""

from importlib.util import find_spec


def installing(extra: str) -> str:
    """Return the command that installs an extra where this package is installed; pip then looks on no index."""
    return f"python -m pip install 'maglev-fmus[{extra}]'"


def lacking(module: str, extra: str, user: str) -> str:
    """Return the message that a needed module of an extra is missing, and the remedy; empty if it is installed."""
    package = module.partition(".")[0]
    if find_spec(package) is not None:
        return ""
    return f"{user} needs {package}; install it with the Python that runs maglev: {installing(extra)}"
