"""Figures that the source of a claim cites."""

import re

# "Fig. 4.18", "Figs. 5.34-5.36", "Figures 4.18, 4.19 and 4.21"; a number elsewhere is an equation or a section.
FIGURE_LIST = re.compile(r"Fig(?:ure|ures|s)?\.?\s*(\d+\.\d+(?:\s*(?:,|-|–|and|to)\s*\d+\.\d+)*)")
FIGURE_NUMBER = re.compile(r"\d+\.\d+")
FIGURE_RANGE = re.compile(r"(\d+)\.(\d+)\s*(?:-|–|to)\s*(\d+)\.(\d+)")


def cited_figures(source: str) -> set[str]:
    """Numbers of the figures that a source cites, those within a range too."""
    numbers: set[str] = set()
    for text in FIGURE_LIST.findall(source):
        numbers.update(FIGURE_NUMBER.findall(text))
        for chapter, first, _, last in FIGURE_RANGE.findall(text):
            numbers.update(f"{chapter}.{k}" for k in range(int(first), int(last) + 1))
    return numbers
