"""What refusals say beside their own sentence: the nearest valid name, the nearest file."""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path


def nearest(name: str, valid: Iterable[str]) -> str:
    """Return the valid name most like `name`, quoted, or the words 'none exists'."""
    # Cutoff 0 names the best match however poor: it at least shows what a valid name looks like.
    matches = get_close_matches(name, list(valid), n=1, cutoff=0.0)
    return repr(matches[0]) if matches else "none exists"


def nearest_file(path: Path) -> str:
    """Say which file beside a missing one has the most similar name."""
    if path.exists() or not path.parent.is_dir():
        return ""
    files = sorted(entry.name for entry in path.parent.iterdir() if entry.is_file())
    return f", nearest is {nearest(path.name, files)}"


def in_one_line(error: Exception) -> str:
    """Message of an error in one line."""
    return " ".join(str(error).split())
