"""Files with placeholders for texts that follow from an FMU."""

import re
from collections.abc import Mapping
from pathlib import Path


def filled(template: Path, values: Mapping[str, str]) -> str:
    """Text of a file, with values where it has their names between @."""
    return re.sub(r"@([A-Z_]+)@", lambda match: values[match[1]], template.read_text(encoding="utf-8"))
