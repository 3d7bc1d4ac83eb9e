"""What every refusal of a scenario has in common."""

from collections.abc import Iterable
from difflib import get_close_matches


class ScenarioError(ValueError):
    """A scenario that cannot be used; one line with file, key, value and what was expected."""


def nearest(name: str, valid: Iterable[str]) -> str:
    """Return the valid name most like `name`, quoted, or the words 'none exists'."""
    # Cutoff 0 names the best match however poor: it at least shows what a valid name looks like.
    matches = get_close_matches(name, list(valid), n=1, cutoff=0.0)
    return repr(matches[0]) if matches else "none exists"


def in_one_line(error: Exception) -> str:
    """Message of an error in one line."""
    return " ".join(str(error).split())
