"""Parts of pages that a program writes: each stands between two marks of its name, and most are tables."""

import re
from collections.abc import Iterable, Sequence
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


def write_part(page: Path, name: str, part: str) -> None:
    """Write a part into a page; see `with_part`."""
    page.write_text(with_part(page, name, part), encoding="utf-8")


def markdown_table(heads: Sequence[object], rows: Iterable[Sequence[object]], numbers: int = 0) -> str:
    """Return a table in Markdown whose last columns, so many, are numbers and stand to the right."""
    head, *others = ("| " + " | ".join(" ".join(str(cell).split()).replace("|", "\\|") for cell in cells) + " |"
                     for cells in (heads, *rows))
    return "\n".join([head, "|---" * (len(heads) - numbers) + "|---:" * numbers + "|", *others]) + "\n"
