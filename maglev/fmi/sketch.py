"""Sketches of the documentation as SVG in the page: block diagrams, axes with directions, symbols with indices.

They run from above to below and are no wider than `WIDTH`, so that a phone shows them whole, with letters to read.
Lines and texts are in the colour of the page's text, so that a sketch is as readable on dark as on light; STYLE has the
few other colours.
"""

import re
from collections.abc import Sequence
from html import escape

Point = tuple[float, float]

WIDTH = 350   # px, at most, of a picture

STYLE = """
:root { --axis: #0b6e4f; --force: #a3360a; --iron: #c3cad1; --north: #3b444d; --south: #e3e8ec; --box: #eef3fb; }
@media (prefers-color-scheme: dark) { :root { --axis: #5fd0a5; --force: #ff9c75; --iron: #4c5761; --north: #c9d0d7;
--south: #2a323a; --box: #222b38; } }
@media print { :root { --axis: #0b6e4f; --force: #a3360a; --iron: #c3cad1; --north: #3b444d; --south: #e3e8ec;
--box: #eef3fb; } }
.sketch { display: flex; flex-wrap: wrap; gap: 1em 2em; margin: 1em 0; }
.sketch svg { display: block; max-width: 100%; height: auto; color: inherit; }
.sketch text { font: 13px system-ui, sans-serif; fill: currentColor; text-anchor: middle; }
.sketch .symbol { font: italic 15px "Latin Modern Math", Cambria, serif; } .sketch .index { font-size: 75%; }
.sketch .start { text-anchor: start; } .sketch .end { text-anchor: end; } .sketch .small { font-size: 12px; }
.sketch .line { fill: none; stroke: currentColor; stroke-width: 1.4; } .sketch .dashed { stroke-dasharray: 5 4; }
.sketch .box { fill: var(--box); stroke: currentColor; stroke-width: 1.4; } .sketch .head { fill: currentColor; }
.sketch .axis .line { stroke: var(--axis); stroke-width: 2; }
.sketch .axis text, .sketch .axis .head { fill: var(--axis); }
.sketch .force .line { stroke: var(--force); stroke-width: 2; } .sketch .force text, .sketch .force .head {
fill: var(--force); }
.sketch .iron { fill: var(--iron); } .sketch .north { fill: var(--north); } .sketch .south { fill: var(--south);
stroke: var(--north); } .sketch .paper { fill: var(--page); }
"""


def sketch(title: str, *pictures: str) -> str:
    """A sketch of one or more pictures, side by side where there is room; its title describes it in words."""
    return f'<div class="sketch" role="img" aria-label="{escape(title)}">{"".join(pictures)}</div>'


def picture(height: float, *parts: str, width: float = WIDTH) -> str:
    return (f'<svg width="{width:g}" height="{height:g}" viewBox="0 0 {width:g} {height:g}" aria-hidden="true">'
            f'{"".join(parts)}</svg>')


def words(x: float, y: float, text: str, kind: str = "") -> str:
    """Upright text, its middle (or its start or end) at x, its base line at y."""
    return f'<text class="{kind}" x="{x:g}" y="{y:g}">{escape(text)}</text>'


def symbol(x: float, y: float, text: str, kind: str = "") -> str:
    """Symbols of equations: "i_d, i_{qα}", with the letters after "_" as an index."""
    parts = []
    for k, part in enumerate(re.split(r"_(\{[^}]*\}|.)", text)):
        if k % 2:
            parts.append(f'<tspan class="index" dy="4">{escape(part.strip("{}"))}</tspan>')
        elif part:
            parts.append(f'<tspan{" dy=" + chr(34) + "-4" + chr(34) if k else ""}>{escape(part)}</tspan>')
    return f'<text class="symbol {kind}" x="{x:g}" y="{y:g}">{"".join(parts)}</text>'


def box(x: float, y: float, width: float, height: float, *lines: str) -> str:
    """A block with lines of text; a line in "$…$" is of symbols."""
    texts = []
    for k, line in enumerate(lines):
        base = y + height / 2 + 5 + 18 * (k - (len(lines) - 1) / 2)
        texts.append(symbol(x + width / 2, base, line.strip("$")) if line.startswith("$")
                     else words(x + width / 2, base, line))
    return f'<rect class="box" x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="4"/>' + "".join(texts)


def filled_box(x: float, y: float, width: float, height: float, kind: str) -> str:
    """A filled rectangle: "iron", "north", "south" or "paper"."""
    return f'<rect class="{kind}" x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}"/>'


def line(points: Sequence[Point], kind: str = "") -> str:
    return f'<path class="line {kind}" d="M{"L".join(f"{x:g} {y:g}" for x, y in points)}"/>'


def arrow(points: Sequence[Point]) -> str:
    """A line through points, horizontal or vertical at its end, with a head there."""
    (x0, y0), (x, y) = points[-2:]
    right, down = (x > x0) - (x < x0), (y > y0) - (y < y0)
    tips = [(x, y), (x - 9 * right - 4.5 * down, y - 9 * down + 4.5 * right),
            (x - 9 * right + 4.5 * down, y - 9 * down - 4.5 * right)]
    head = f'<path class="head" d="M{"L".join(f"{a:g} {b:g}" for a, b in tips)}Z"/>'
    return line([*points[:-1], (x - 6 * right, y - 6 * down)]) + head


def labelled_arrow(points: Sequence[Point], label: str, kind: str, at: Point, anchor: str = "start") -> str:
    """An arrow with a symbol; kind "axis" or "force" is their colour."""
    return f'<g class="{kind}">{arrow(points)}{symbol(*at, label, anchor)}</g>'


def junction(x: float, y: float) -> str:
    """The point where a signal from above is taken from one from the right."""
    return f'<circle class="box" cx="{x:g}" cy="{y:g}" r="9"/>{words(x - 12, y - 12, "−")}{words(x + 18, y - 6, "+")}'
