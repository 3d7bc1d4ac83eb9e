"""Files that belong together: one of them, as JSON, has the digests of the others."""

import json
from collections.abc import Iterable
from pathlib import Path

from maglev.files.cache import digest_at
from maglev.files.regular_file import regular

KEY = "files"   # of the JSON: digests by file name


def digests_of(paths: Iterable[Path]) -> dict[str, str]:
    return {path.name: digest_at(path) for path in paths}


def stranger(path: Path) -> str:
    """Why a file is not the one that the JSON next to it is of, as the end of a sentence.

    Empty if it is, or if there is none that has its digest.
    """
    record = path.with_suffix(".json")
    try:
        expected = json.loads(regular(record).read_text(encoding="utf-8"))[KEY][path.name]
    except (OSError, ValueError, KeyError, TypeError):
        return ""
    return "" if digest_at(path) == expected else (
        f"does not belong to {record.name} next to it: one of the two was edited, or comes from another run. Keep both "
        "files of one run, or this file alone")
