"""Extras of this package: what is not installed with it, and what installs that."""

from importlib.util import find_spec


def installing(extra: str) -> str:
    """What installs an extra where this package is installed, which pip then looks for on no index."""
    return f"python -m pip install 'maglev-fmus[{extra}]'"


def lacking(module: str, extra: str, user: str) -> str:
    """That a module of an extra, which somebody needs, is not installed, and what installs it; empty if it is."""
    package = module.partition(".")[0]
    if find_spec(package) is not None:
        return ""
    return f"{user} needs {package}, expected it to be installed: {installing(extra)}, with the Python that runs maglev"
