"""Maps of cells as SVG, with one path for each outcome: a line along each run of cells in a row.

The style says how thick it is, which tells outcomes apart without colour.
"""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from itertools import groupby
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

LEFT, BOTTOM, EDGE = 40, 36, 8   # units around a map
LABEL = 12                       # units that a label needs along an axis
LEGEND = 10                      # units of a cell of the legend

Maps = TypeVar("Maps")
Side = tuple[str, Sequence[str]]   # title of an axis, and the label of each row or column


def of_rigs(rigs: Iterable[str], packaged: Mapping[str, Maps]) -> dict[str, Maps]:
    """Those of the maps that come with the package which are of the rigs."""
    wanted = set(rigs)
    return {rig: maps for rig, maps in packaged.items() if rig in wanted}


def origin_paragraph(origins: Iterable[tuple[str, str | None]], tool: str, page: str) -> str:
    """What maps rest on, by the version and commit that flew those of each rig, and how to make them anew."""
    flown = " and ".join(dict.fromkeys(f"Maglev FMUs {version}" + (f" ({commit})" if commit else "")
                                       for version, commit in origins))
    return f"""<p>The maps are not of this report's runs: they come with the package, from studies that were flown with
native FMUs of {escape(flown)}. <code>{tool}</code>, in the repository, flies them again; {page} there says more.</p>
"""


def legend(names: Iterable[tuple[str, str]]) -> str:
    """What stripes mean: paths of three cells in two rows, and words."""
    return '<ul class="range-legend">' + "".join(
        f'<li><svg viewBox="0 0 {3 * LEGEND} {2 * LEGEND}" aria-hidden="true">{cells(paths, LEGEND)}</svg> '
        f"{escape(name)}</li>" for paths, name in names) + "</ul>\n"


def cells(paths: str, cell: float, left: float = 0) -> str:
    """Paths in cells, of which the first has its middle at the left edge of y = 0."""
    return f'<g transform="translate({left} {cell / 2:g})scale({cell})">{paths}</g>'


def cell_map(title: str, paths: str, cell: int, along: Side, down: Side) -> str:
    """A map: its paths in units of cells, the labels of its sides, that of the lowest row first.

    Where a cell is too small for its label, the first, the middle and the last one have theirs.
    """
    (along_title, columns), (down_title, rows) = along, down
    width, height = LEFT + cell * len(columns) + EDGE, cell * len(rows) + BOTTOM
    ticks = [f'<text x="{LEFT + cell * (k + 0.5):g}" y="{cell * len(rows) + 14}">{escape(columns[k])}</text>'
             for k in ticked(len(columns), cell)]
    ticks += [f'<text class="end" x="{LEFT - 4}" y="{cell * (len(rows) - k - 0.5) + 4:g}">{escape(rows[k])}</text>'
              for k in ticked(len(rows), cell)]
    return (f'<svg viewBox="0 0 {width} {height}" role="img"><title>{escape(title)}</title>'
            f"{cells(paths, cell, LEFT)}{''.join(ticks)}"
            f'<text x="{LEFT + cell * len(columns) / 2:g}" y="{height - 6}">{escape(along_title)}</text>'
            f'<text transform="translate(12 {cell * len(rows) / 2:g})rotate(-90)">{escape(down_title)}</text></svg>')


def ticked(count: int, cell: float) -> list[int]:
    """Places on an axis that are labelled."""
    return [*range(count)] if cell > LABEL else sorted({0, count // 2, count - 1})


def stripes(where: NDArray[np.bool_]) -> str:
    """Path along every run of cells in rows, such as "M3 0h2" for the fourth and the fifth cell of the first row."""
    parts = []
    for row, values in enumerate(where.tolist()):
        column = 0
        for inside, run in groupby(values):
            length = len(list(run))
            if inside:
                parts.append(f"M{column} {row}h{length}")
            column += length
    return "".join(parts)
