"""Maps of outcomes on the page: they come with the package, of the stages that a report has runs of."""

from collections.abc import Callable, Collection, Mapping
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from maglev.descriptions.packaged import RIGS
from maglev.pages import operating_range, tolerances
from maglev.pages.findings import value_table
from maglev.pages.grids import RigGrids, read_grids
from maglev.pages.law_map import LawMap, maps_data
from maglev.runs.procedure_outcome import ValueTable

PAGE = "docs/faults.md"
MARKED = 6   # number of the look of what is marked in a map: `LOOKS` of map.js


class Kind(NamedTuple):
    """A kind of maps: what its section is called, and how its outcomes look."""

    anchor: str
    heading: str
    name: str                    # anchor of a rig's maps, before the rig
    subject: str                 # after the rig's title
    table: str                   # what a rig's table has
    tool: str                    # what runs them again
    file: Path
    about: Callable[[RigGrids], str]
    maps_of: Callable[[RigGrids], list[list[LawMap]]]         # of all laws, by the sides that they have
    rows: Callable[[RigGrids], list[tuple[str, ...]]]         # of the table of a rig, the heading first
    outcomes: tuple[str, ...]
    looks: tuple[int, ...]       # of the outcomes, numbers of `LOOKS`; what means the same has the same in all kinds
    dots: str = ""               # what a mark means; empty if there is none


RANGE = Kind("operating-range", "How far each controller can go", "range", "operating range", "shares of the maps",
             operating_range.TOOL, operating_range.FILE, operating_range.about, operating_range.maps_of,
             operating_range.table, operating_range.OUTCOMES, (0, 1, 7, 2, 3, 4), operating_range.SETTLED_NOMINAL)
TOLERANCES = Kind("tolerances", "What each controller tolerates", "tolerance", "tolerances",
                  "up to where each law holds, all else being ideal", tolerances.TOOL, tolerances.FILE,
                  tolerances.about, tolerances.maps_of, tolerances.table, tolerances.OUTCOMES, (0, 2, 4, 3))


def of_rigs(kind: Kind, rigs: Collection[str]) -> dict[str, RigGrids]:
    return {rig: of_rig for rig, of_rig in read_grids(kind.file).items() if rig in rigs}


def maps_section(kind: Kind, shown: Mapping[str, RigGrids]) -> str:
    """Section of the page with the maps of rigs; empty if there are none."""
    if not shown:
        return ""
    made_by = escape(" and ".join(dict.fromkeys(
        f"Maglev FMUs {origin.version}" + (f" ({origin.commit})" if origin.commit else "")
        for origin in (of_rig.origin for of_rig in shown.values()))))
    articles = "\n".join(article(kind, rig, of_rig) for rig, of_rig in shown.items())
    return f"""

<section id="{kind.anchor}">
<h2>{kind.heading}</h2>
<p>{kind.about(next(iter(shown.values())))}</p>
<p>The maps are not of this report's runs: they come with the package, from studies that were run with
native FMUs of {made_by}. <code>{kind.tool}</code>, in the repository, runs them again; {PAGE} there says more.</p>
{articles}
</section>"""


def article(kind: Kind, rig: str, of_rig: RigGrids) -> str:
    title = RIGS[rig].title if rig in RIGS else rig
    places = "\n".join(f'<div data-maps="{name}"></div>' for name in map_data(kind, rig, of_rig))
    head, *body = kind.rows(of_rig)
    table = value_table(ValueTable(f"{title}: {kind.table}", head, tuple(body)))
    return (f'<article id="{kind.name}-{rig}" data-rig="{rig}"><h3>{escape(title)}: {kind.subject}</h3>\n{places}\n'
            f"{table}</article>")


def map_data(kind: Kind, rig: str, of_rig: RigGrids) -> dict[str, dict[str, Any]]:
    """What the script draws of a rig, by place; what is marked is an outcome more."""
    return {f"{kind.name}-{rig}-{number}": {**maps_data(maps, [*kind.outcomes, kind.dots]),
                                            "looks": [*kind.looks, MARKED]}
            for number, maps in enumerate(kind.maps_of(of_rig))}
