"""What each controller tolerates, as HTML: maps that come with the package, of the stages that a report has runs of."""

from collections.abc import Iterable, Mapping
from html import escape

import numpy as np

from maglev.maps.tolerances import (
    OUTCOMES,
    QUESTIONS,
    TOOL,
    Outcomes,
    Question,
    RigMaps,
    Worse,
    limits_table,
    read_tolerances,
    seen,
)
from maglev.procedures.outcome import ValueTable
from maglev.report.cell_maps import Side, cell_map, legend, of_rigs, origin_paragraph, stripes
from maglev.report.findings import value_table
from pmlsm.rigs import RIGS

LINK = '<li><a href="#tolerances">What each controller tolerates</a></li>'
CELL = 20                             # units of the pictures
LOOKS = ("o0", "o2", "o5", "o4")      # classes of the outcomes, those of the operating range where they mean the same


def tolerance_section(rigs: Iterable[str], packaged: Mapping[str, RigMaps] | None = None) -> str:
    """Section of the page with the maps of rigs; empty if there are none.

    Parameters
    ----------
    rigs : iterable of str
        Names of those that the report's runs are about.
    packaged : mapping of str to RigMaps, optional
        Maps by the name of the rig; those of the package if not given.
    """
    shown = of_rigs(rigs, read_tolerances() if packaged is None else packaged)
    if not shown:
        return ""
    return f"""

<section id="tolerances">
<h2>What each controller tolerates</h2>
<p>Two things get worse at a time: measurements come late and are noisy; samples are lost and the bus has little
voltage. Every law makes a step of the air gap with them, together with one of the horizontal axes or the tilts. A
flight holds if no stop is touched, nothing trips, and every axis ends near its reference. The lowest row and the first
column of a map are without the one or the other.</p>
{origin_paragraph(((maps.version, maps.commit) for maps in shown.values()), TOOL, "docs/tolerances.md")}\
{legend((f'<path class="{LOOKS[outcome]}" d="M0 0h3M0 1h3"/>', OUTCOMES[outcome]) for outcome in seen(shown.values()))}\
{"".join(rig_maps(rig, maps) for rig, maps in shown.items())}
</section>"""


def rig_maps(rig: str, maps: RigMaps) -> str:
    """Maps of a rig, those of a question and a step in a row, and up to where each law holds."""
    title = RIGS[rig].title if rig in RIGS else rig
    rows = "\n".join(
        f'<h4>{question.down.name.capitalize()} and {question.along.name}, step of {size:g} mm</h4><div class="range">'
        + "\n".join(f"<figure><figcaption>{escape(law)}</figcaption>{picture(law, found, question, k, size)}</figure>"
                    for law, found in maps.maps[question.name].items()) + "</div>"
        for question in QUESTIONS if question.name in maps.maps for k, size in enumerate(maps.sizes))
    head, *body = limits_table(maps)
    table = value_table(ValueTable(f"{title}: up to where each law holds, all else being ideal", head, tuple(body)))
    return (f'<article id="tolerance-{rig}" data-rig="{rig}"><h3>{escape(title)}: tolerances</h3>\n{rows}\n{table}'
            "</article>\n")


def picture(law: str, found: Outcomes, question: Question, step: int, size: float) -> str:
    """Map of a law as SVG, the harmless values lowest and leftmost; its shares as text for who does not see it."""
    outcomes = found[step]
    shares = [(outcome, float(np.mean(outcomes == outcome))) for outcome in range(len(OUTCOMES))]
    said = ", ".join(f"{OUTCOMES[outcome]} {100 * share:.0f} %" for outcome, share in shares if share)
    paths = "".join(f'<path class="{LOOKS[outcome]}" d="{stripes(outcomes[::-1] == outcome)}"/>'
                    for outcome, share in shares if share)
    return cell_map(f"{law}. {question.down.name} and {question.along.name}, step of {size:g} mm: {said}", paths, CELL,
                    side(question.along), side(question.down))


def side(worse: Worse) -> Side:
    """Title and labels of a side of a map."""
    return (f"{worse.name}, {worse.unit.replace('um', 'µm')}",
            ["∞" if worse.text(value) == "no limit" else f"{value:g}" for value in worse.values])
