"""Maps of outcomes on the page: they come with the package, of the stages that a report has runs of."""

from collections.abc import Callable, Collection, Mapping
from html import escape
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from maglev.maps import operating_range, tolerances
from maglev.pages.shell import packed
from maglev.procedures.outcome import ValueTable
from maglev.report.findings import value_table
from pmlsm.rigs import RIGS

MARKED = 6   # number of the look of what is marked in a map: `LOOKS` of map.js

OfRig = operating_range.RigMaps | tolerances.RigMaps


class Kind(NamedTuple):
    """A kind of maps: what its section is called, and how its outcomes look."""

    anchor: str
    heading: str
    name: str                    # anchor of a rig's maps, before the rig
    subject: str                 # after the rig's title
    table: str                   # what a rig's table has
    page: str                    # that says more, in the repository
    tool: str                    # what runs them again
    read: Callable[[], Mapping[str, OfRig]]
    outcomes: tuple[str, ...]
    looks: tuple[int, ...]       # of the outcomes, numbers of `LOOKS`; what means the same has the same in all kinds
    dots: str = ""               # what a mark means; empty if there is none


RANGE = Kind("operating-range", "How far each controller can go", "range", "operating range", "shares of the maps",
             "docs/faults.md", operating_range.TOOL, operating_range.read_maps, operating_range.OUTCOMES,
             (0, 1, 7, 2, 3, 4), operating_range.SETTLED_NOMINAL)
TOLERANCES = Kind("tolerances", "What each controller tolerates", "tolerance", "tolerances",
                  "up to where each law holds, all else being ideal", "docs/faults.md", tolerances.TOOL,
                  tolerances.read_tolerances, tolerances.OUTCOMES, (0, 2, 4, 3))


def of_rigs(kind: Kind, rigs: Collection[str]) -> dict[str, OfRig]:
    return {rig: maps for rig, maps in kind.read().items() if rig in rigs}


def section(kind: Kind, shown: Mapping[str, OfRig]) -> str:
    """Section of the page with the maps of rigs; empty if there are none."""
    if not shown:
        return ""
    made_by = escape(" and ".join(dict.fromkeys(
        f"Maglev FMUs {origin.version}" + (f" ({origin.commit})" if origin.commit else "")
        for origin in (maps.origin for maps in shown.values()))))
    articles = "\n".join(article(kind, rig, maps) for rig, maps in shown.items())
    return f"""

<section id="{kind.anchor}">
<h2>{kind.heading}</h2>
<p>{next(iter(shown.values())).about}</p>
<p>The maps are not of this report's runs: they come with the package, from studies that were run with
native FMUs of {made_by}. <code>{kind.tool}</code>, in the repository, runs them again; {kind.page} there says more.</p>
{articles}
</section>"""


def article(kind: Kind, rig: str, maps: OfRig) -> str:
    title = RIGS[rig].title if rig in RIGS else rig
    places = "\n".join(f'<div data-maps="{name}"></div>' for name in maps_data(kind, rig, maps))
    head, *body = maps.table()
    table = value_table(ValueTable(f"{title}: {kind.table}", head, tuple(body)))
    return (f'<article id="{kind.name}-{rig}" data-rig="{rig}"><h3>{escape(title)}: {kind.subject}</h3>\n{places}\n'
            f"{table}</article>")


def maps_data(kind: Kind, rig: str, maps: OfRig) -> dict[str, dict[str, Any]]:
    """What the script draws of a rig, by place: a map for each law, a layer of it for each row with the same sides.

    What is marked in a row is an outcome more.
    """
    data = {}
    for number, (sides, of_sides) in enumerate(groupby(maps.rows(), key=lambda row: (row.down, row.along))):
        rows = [*of_sides]
        laws = {law: [np.where(row.dots.get(law, False), len(kind.outcomes), row.cells[law]) for row in rows]
                for law in rows[0].cells}
        data[f"{kind.name}-{rig}-{number}"] = {
            "factors": [{"name": name, "unit": unit, "values": values} for name, unit, values in (
                *((*side.title.rsplit(", ", 1), side.labels) for side in sides),
                ("with", "", [row.heading for row in rows]))],
            "outcomes": [*kind.outcomes, kind.dots], "looks": [*kind.looks, MARKED],
            "laws": [{"name": law, "packed": packed(np.stack(cells).astype(np.uint8).tobytes())}
                     for law, cells in laws.items()]}
    return data
