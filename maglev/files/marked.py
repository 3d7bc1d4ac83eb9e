"""Parts of pages that a program writes: each stands between two marks of its name."""

import re
from pathlib import Path


def with_part(page: Path, name: str, part: str) -> str:
    """Return a page with a new part between `<!-- NAME … -->` and `<!-- end of NAME -->`.

    ValueError if these marks do not stand in it once.
    """
    marks = re.compile(rf"(?P<begin><!-- {name}\b[^\n]*-->\n).*?(?=<!-- end of {name} -->)", re.DOTALL)
    text, places = marks.subn(lambda mark: f"{mark['begin']}\n{part.strip()}\n\n", page.read_text(encoding="utf-8"))
    if places != 1:
        raise ValueError(f"{page}: {places} places between the marks of {name}, expected one")
    return text
