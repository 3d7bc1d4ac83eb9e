"""Columns and lines of text."""

import re
from textwrap import fill

WIDTH = 80   # letters of a line


def aligned(cells: list[list[str]]) -> str:
    """Columns of text, the first one to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "\n".join("  ".join([row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in
                                                          zip(row[1:], widths[1:], strict=True))]).rstrip()
                     for row in cells)


def in_width(head: str, text: str) -> str:
    """A head and its text in lines of 80 letters, the text under itself, numbers with their units."""
    lines = fill(unbroken(text), WIDTH, initial_indent=" " * len(head), subsequent_indent=" " * len(head))
    return head + lines[len(head):].replace("\N{NO-BREAK SPACE}", " ")


def unbroken(text: str) -> str:
    """The text with numbers, their units and the sign before them kept on one line."""
    return re.sub(r"(?<=\d) (?=%|(?:mm|µm|ms|[mµ]rad|kg|[sANV])\b)|(?<=[<>≤≥]) (?=\d)", "\N{NO-BREAK SPACE}", text)
