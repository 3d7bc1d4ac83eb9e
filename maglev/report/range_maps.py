"""How far each controller can go, as HTML: maps that come with the package, of the stages that a report has runs of."""

from collections.abc import Iterable, Mapping
from html import escape

import numpy as np
from numpy.typing import NDArray

from maglev.maps.operating_range import (
    NEAR,
    OUTCOMES,
    SETTLED_NOMINAL,
    TOOL,
    Map,
    RigMaps,
    read_maps,
    seen,
    shares,
    shares_table,
)
from maglev.procedures.outcome import ValueTable
from maglev.report.cell_maps import cell_map, legend, of_rigs, origin_paragraph, stripes
from maglev.report.findings import value_table
from pmlsm.rigs import RIGS

LINK = '<li><a href="#operating-range">How far each controller can go</a></li>'
CELL = 10   # units of the pictures


def range_section(rigs: Iterable[str], packaged: Mapping[str, RigMaps] | None = None) -> str:
    """Section of the page with the maps of rigs; empty if there are none.

    Parameters
    ----------
    rigs : iterable of str
        Names of those that the report's runs are about.
    packaged : mapping of str to RigMaps, optional
        Maps by the name of the rig; those of the package if not given.
    """
    shown = of_rigs(rigs, read_maps() if packaged is None else packaged)
    if not shown:
        return ""
    occurring = seen(found for maps in shown.values() for found in maps.laws.values())
    return ('\n\n<section id="operating-range">\n<h2>How far each controller can go</h2>\n' + introduction(shown)
            + legend([*((f'<path class="o{outcome}" d="M0 0h3M0 1h3"/>', OUTCOMES[outcome]) for outcome in occurring),
                      ('<path class="o0" d="M0 0h3M0 1h3"/><path class="dot" d="M1 0h0"/>', SETTLED_NOMINAL)])
            + "\n".join(rig_maps(rig, maps) for rig, maps in shown.items()) + "\n</section>")


def introduction(shown: Mapping[str, RigMaps]) -> str:
    """What the maps are of, what they rest on, and how to make them anew."""
    origins = ((maps.origin.version, maps.origin.commit) for maps in shown.values())
    factors = next(iter(next(iter(shown.values())).laws.values())).constants
    return f"""<p>Moves from rest at one air gap to another, alone and with a step of something else: which of them
each controller can do. A move settles if every axis ends within {1e3 * NEAR:g} mm of its reference, a tilt within as
many mrad, and no stop was touched.
Each was flown with all force constants of the plant times {listed(factors)}, of which the controller does not know.
The maps show the constants as they are; a dot is on what settles with these only.</p>
""" + origin_paragraph(origins, TOOL, "docs/operating_range.md")


def listed(values: NDArray[np.float64]) -> str:
    """Numbers in words, such as "0.95, 1 and 1.05"."""
    *others, last = (f"{value:g}" for value in values)
    return f"{', '.join(others)} and {last}" if others else last


def rig_maps(rig: str, maps: RigMaps) -> str:
    """Maps of a rig, those of a step beside the gap in a row, and the table of their shares."""
    title = RIGS[rig].title if rig in RIGS else rig
    first = next(iter(maps.laws.values()))
    rows = "\n".join(f'<h4>{escape(step_text(first, step))}</h4><div class="range">' + "\n".join(
        f"<figure><figcaption>{escape(law)}</figcaption>{map_picture(law, found, k)}</figure>"
        for law, found in maps.laws.items()) + "</div>" for k, step in enumerate(first.steps))
    head, *body = shares_table(maps.laws)
    table = value_table(ValueTable(f"{title}: shares of the maps", head, tuple(body)))
    return (f'<article id="range-{rig}" data-rig="{rig}"><h3>{escape(title)}: operating range</h3>\n{rows}\n{table}'
            "</article>")


def step_text(found: Map, step: float) -> str:
    """A step beside the gap (m or rad) in words."""
    return f"{found.what} {found.size(step)}".capitalize() if step else f"No {found.what}"


def map_picture(law: str, found: Map, step: int) -> str:
    """Map of one step beside the gap as SVG, its shares as the text for who does not see it."""
    _, nominal, _ = shares(found)[step]
    said = ", ".join(f"{OUTCOMES[outcome]} {100 * nominal[outcome]:.0f} %" for outcome in seen([found])
                     if nominal[outcome])
    return cell_map(f"{law}. {step_text(found, found.steps[step])}: {said}", map_paths(found, step), CELL,
                    ("target gap, mm", [f"{1e3 * gap:g}" for gap in found.target]),
                    ("initial gap, mm", [f"{1e3 * gap:g}" for gap in found.initial]))


def map_paths(found: Map, step: int) -> str:
    """A path for each outcome, in units of cells, the smallest initial gap lowest; and the dots."""
    nominal, fragile = found.nominal[::-1, :, step], found.fragile[::-1, :, step]
    paths = {outcome: stripes(nominal == outcome) for outcome in seen([found])}
    dots = "".join(f"M{column}.5 {row}h0" for row, column in np.argwhere(fragile).tolist())
    return ("".join(f'<path class="o{outcome}" d="{path}"/>' for outcome, path in paths.items() if path)
            + (f'<path class="dot" d="{dots}"/>' if dots else ""))
