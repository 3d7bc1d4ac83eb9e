"""Whether a file is still the one that it was."""

from pathlib import Path


def stamp(path: Path) -> tuple[int, int, int]:
    """Time (ns), size and number of a file: as long as they stay, so does what is in it. OSError if it is not there."""
    now = path.stat()
    return now.st_mtime_ns, now.st_size, now.st_ino
