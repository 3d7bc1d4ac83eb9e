"""Maps of outcomes on the page: they come with the package, of the stages that a report has runs of."""

from collections.abc import Callable, Collection, Mapping
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.pages import operating_range, tolerances
from maglev.pages.findings import value_table
from maglev.pages.grids import StageGrids, read_grids
from maglev.pages.law_map import LawMap, maps_data
from maglev.runs.procedure_outcome import ValueTable

PAGE = "docs/results_faults.md"
MARKED = 6   # number of the look of marked samples in a map: `LOOKS` of map.js


class Kind(NamedTuple):
    """A kind of maps: the title of its section, and the looks of its outcomes."""

    anchor: str
    heading: str
    name: str                    # anchor of a stage's maps, before the stage
    subject: str                 # after the stage's title
    table: str                   # what a stage's table has
    tool: str                    # what runs them again
    file: Path
    about: Callable[[StageGrids], str]
    maps_of: Callable[[StageGrids], list[list[LawMap]]]         # of all laws, by the sides that they have
    rows: Callable[[StageGrids], list[tuple[str, ...]]]         # of the table of a stage, the heading first
    outcomes: tuple[str, ...]
    looks: tuple[int, ...]       # of the outcomes, numbers of `LOOKS`; equal outcomes have equal looks in all kinds
    dots: str = ""               # what a mark means; empty if there is none


RANGE = Kind("operating-range", "How far each controller can go", "range", "operating range", "shares of the maps",
             operating_range.TOOL, operating_range.FILE, operating_range.about, operating_range.maps_of,
             operating_range.table, operating_range.OUTCOMES, (0, 1, 7, 2, 3, 4), operating_range.SETTLED_NOMINAL)
TOLERANCES = Kind("tolerances", "What each controller tolerates", "tolerance", "tolerances",
                  "up to where each law holds, all else being ideal", tolerances.TOOL, tolerances.FILE,
                  tolerances.about, tolerances.maps_of, tolerances.table, tolerances.OUTCOMES, (0, 2, 4, 3))


def of_stages(kind: Kind, stages: Collection[str]) -> dict[str, StageGrids]:
    return {stage: of_stage for stage, of_stage in read_grids(kind.file).items() if stage in stages}


def maps_section(kind: Kind, shown: Mapping[str, StageGrids]) -> str:
    """Section of the page with the maps of stages; empty if there are none. Paper has what is about the runs alone."""
    if not shown:
        return ""
    made_by = escape(" and ".join(dict.fromkeys(
        f"Maglev FMUs {origin.version}" + (f" ({origin.commit})" if origin.commit else "")
        for origin in (of_stage.origin for of_stage in shown.values()))))
    articles = "\n".join(article(kind, stage, of_stage) for stage, of_stage in shown.items())
    return f"""

<section id="{kind.anchor}" class="screen">
<h2>{kind.heading}</h2>
<p>{kind.about(next(iter(shown.values())))}</p>
<p>The maps are not of this report's runs: they come with the package, from studies that were run with
native FMUs of {made_by}. <code>{kind.tool}</code>, in the repository, runs them again; {PAGE} there says more.</p>
{articles}
</section>"""


def article(kind: Kind, stage: str, of_stage: StageGrids) -> str:
    title = PACKAGED_STAGES[stage].title if stage in PACKAGED_STAGES else stage
    places = "\n".join(f'<div data-maps="{name}"></div>' for name in map_data(kind, stage, of_stage))
    head, *body = kind.rows(of_stage)
    table = value_table(ValueTable(f"{title}: {kind.table}", head, tuple(body)))
    return (f'<article id="{kind.name}-{stage}" data-stage="{stage}"><h3>{escape(title)}: {kind.subject}</h3>\n'
            f'{places}\n'
            f"{table}</article>")


def map_data(kind: Kind, stage: str, of_stage: StageGrids) -> dict[str, dict[str, Any]]:
    """Return the data to draw a stage, by place; a marked cell is a further outcome."""
    return {f"{kind.name}-{stage}-{number}": {**maps_data(maps, [*kind.outcomes, kind.dots]),
                                            "looks": [*kind.looks, MARKED]}
            for number, maps in enumerate(kind.maps_of(of_stage))}
