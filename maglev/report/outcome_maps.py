"""Maps of outcomes as HTML: they come with the package, of the stages that a report has runs of.

A map is SVG with one path for each outcome, a line along each run of cells in a row. The style says how thick it is,
which tells outcomes apart without colour.
"""

from collections.abc import Callable, Iterable, Mapping
from html import escape
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maglev.maps import operating_range, tolerances
from maglev.maps.rows import Row, Side, seen
from maglev.procedures.outcome import ValueTable
from maglev.report.findings import value_table
from pmlsm.rigs import RIGS

LEFT, BOTTOM, EDGE = 40, 36, 8   # units around a map
LABEL = 12                       # units that a label needs along an axis
LEGEND = 10                      # units of a cell of the legend

OfRig = operating_range.RigMaps | tolerances.RigMaps


class Kind(NamedTuple):
    """A kind of maps: what its section is called, and how its outcomes look."""

    anchor: str
    heading: str
    name: str                    # anchor of a rig's maps, before the rig
    subject: str                 # after the rig's title
    table: str                   # what a rig's table has
    page: str                    # that says more, in the repository
    tool: str                    # what flies them again
    read: Callable[[], Mapping[str, OfRig]]
    outcomes: tuple[str, ...]
    looks: tuple[str, ...]       # classes of the outcomes; what means the same has the same in all kinds
    cell: int                    # units of the pictures
    dots: str = ""               # what a dot means; empty if there is none

    @property
    def link(self) -> str:
        """Entry of the index."""
        return f'<li><a href="#{self.anchor}">{self.heading}</a></li>'


RANGE = Kind("operating-range", "How far each controller can go", "range", "operating range", "shares of the maps",
             "docs/faults.md", operating_range.TOOL, operating_range.read_maps, operating_range.OUTCOMES,
             ("o0", "o1", "o2", "o3", "o4", "o5"), 10, operating_range.SETTLED_NOMINAL)
TOLERANCES = Kind("tolerances", "What each controller tolerates", "tolerance", "tolerances",
                  "up to where each law holds, all else being ideal", "docs/faults.md", tolerances.TOOL,
                  tolerances.read_tolerances, tolerances.OUTCOMES, ("o0", "o2", "o5", "o4"), 20)


def section(kind: Kind, rigs: Iterable[str], packaged: Mapping[str, OfRig] | None = None) -> str:
    """Section of the page with the maps of rigs, by default those of the package; empty if there are none."""
    wanted = {*rigs}
    shown = {rig: maps for rig, maps in (kind.read() if packaged is None else packaged).items() if rig in wanted}
    if not shown:
        return ""
    flown = escape(" and ".join(dict.fromkeys(
        f"Maglev FMUs {origin.version}" + (f" ({origin.commit})" if origin.commit else "")
        for origin in (maps.origin for maps in shown.values()))))
    articles = "\n".join(article(kind, rig, maps) for rig, maps in shown.items())
    return f"""

<section id="{kind.anchor}">
<h2>{kind.heading}</h2>
<p>{next(iter(shown.values())).about}</p>
<p>The maps are not of this report's runs: they come with the package, from studies that were run with
native FMUs of {flown}. <code>{kind.tool}</code>, in the repository, runs them again; {kind.page} there says more.</p>
{legend(kind, [row for maps in shown.values() for row in maps.rows()])}
{articles}
</section>"""


def legend(kind: Kind, rows: Iterable[Row]) -> str:
    """What stripes mean: paths of three cells in two rows, and words."""
    def path(outcome: int) -> str:
        return f'<path class="{kind.looks[outcome]}" d="M0 0h3M0 1h3"/>'

    names = [(path(outcome), kind.outcomes[outcome]) for outcome in seen(
        cells for row in rows for cells in row.cells.values())]
    if kind.dots:
        names.append((path(0) + '<path class="dot" d="M1 0h0"/>', kind.dots))
    return '<ul class="range-legend">' + "".join(
        f'<li><svg viewBox="0 0 {3 * LEGEND} {2 * LEGEND}" aria-hidden="true">{in_cells(paths, LEGEND)}</svg> '
        f"{escape(name)}</li>" for paths, name in names) + "</ul>"


def article(kind: Kind, rig: str, maps: OfRig) -> str:
    """Maps of a rig, those of all laws in a row, and its table."""
    title = RIGS[rig].title if rig in RIGS else rig
    rows = "\n".join(f'<h4>{escape(row.heading)}</h4><div class="range">' + "\n".join(
        f"<figure><figcaption>{escape(law)}</figcaption>{picture(kind, row, law)}</figure>" for law in row.cells)
        + "</div>" for row in maps.rows())
    head, *body = maps.table()
    table = value_table(ValueTable(f"{title}: {kind.table}", head, tuple(body)))
    return (f'<article id="{kind.name}-{rig}" data-rig="{rig}"><h3>{escape(title)}: {kind.subject}</h3>\n{rows}\n'
            f"{table}</article>")


def picture(kind: Kind, row: Row, law: str) -> str:
    """Map of a law as SVG, its lowest row lowest; its shares as the text for who does not see it."""
    cells = row.cells[law][::-1]
    found = seen([cells])
    said = ", ".join(f"{kind.outcomes[outcome]} {100 * np.mean(cells == outcome):.0f} %" for outcome in found)
    paths = "".join(f'<path class="{kind.looks[outcome]}" d="{stripes(cells == outcome)}"/>' for outcome in found)
    if law in row.dots and row.dots[law].any():
        dots = "".join(f"M{column}.5 {y}h0" for y, column in np.argwhere(row.dots[law][::-1]).tolist())
        paths += f'<path class="dot" d="{dots}"/>'
    return cell_map(f"{law}. {row.heading}: {said}", paths, kind.cell, row.along, row.down)


def in_cells(paths: str, cell: float, left: float = 0) -> str:
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
            f"{in_cells(paths, cell, LEFT)}{''.join(ticks)}"
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
