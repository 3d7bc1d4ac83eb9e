"""Pictures of the figures for browsers without JavaScript: the same lines as SVG, coarse, with few labels."""

import math
from collections.abc import Iterator, Sequence
from html import escape
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maglev.panels import PANELS
from maglev.report.plots.charts import ShownChart
from maglev.report.plots.figures import COLOURS, Panel, Shown, axis_of, needed_columns, recorded_columns, shown_by
from maglev.report.plots.series import thin

Array = NDArray[np.float64]

WIDTH, HEIGHT = 600, 120         # px of the frame
LEFT, TOP, BELOW = 64, 22, 34    # px beside it: labels, title with legend, times
NAMES = 14                       # px for the names of events, above the frame of the first panel
MOST_POINTS = 80                 # of a line; twice as many of an error, whose peaks are steep
FINEST = 1.0                     # px, tolerance of a line
DASHES = ("none", "7 4", "1.5 3", "8 3 1.5 3")   # of runs, as in plot.js
PHASES = ("phase-0", "phase-1", "phase-2")


class Line(NamedTuple):
    """A line or marks: name, colour in the style sheet, abscissae and ordinates, shape (n,), and how it is drawn."""

    name: str
    colour: str
    x: Array
    y: Array
    marked: bool = False
    dash: str = "none"
    width: float = 1.5   # px


class PanelPicture(NamedTuple):
    """What a panel shows: titles, lines, the floor of a logarithmic one, and names of windows from when to when (s).

    `down` is whether ordinates grow downwards, `named` whether the lines have their names here.
    """

    title: str
    x_title: str
    lines: Sequence[Line]
    floor: float | None = None
    down: bool = False
    windows: Sequence[tuple[str, float, float]] = ()
    named: bool = True


def static_picture(shown: Shown | ShownChart) -> str:
    """The panels of a figure as SVG below each other."""
    panels: list[PanelPicture]
    if isinstance(shown, ShownChart):
        panels = [PanelPicture(panel.y_title, panel.x_title, [
            Line(curve.label, f"run-{k % COLOURS}", np.asarray(curve.x, dtype=float), np.asarray(curve.y, dtype=float),
                 curve.marked or len(curve.x) < 2) for k, curve in enumerate(panel.curves)])
            for panel in shown.chart.panels]
    else:
        windows = tuple(dict.fromkeys(window for run in shown.recorded for window in run.plan.windows))
        panels = [PanelPicture(PANELS[panel.kind].title(panel.of, unit, gap), "time (s)",
                               list(panel_lines(shown, panel)), PANELS[panel.kind].drawn_floor,
                               PANELS[panel.kind].place and gap, windows, shown.colours is None)
                  for panel in shown.panels for unit, gap in [axis_of(shown, panel)]]
    return "\n".join(panel_picture(panel, k == 0) for k, panel in enumerate(panels))


def panel_lines(shown: Shown, panel: Panel) -> Iterator[Line]:
    """Lines of a panel: of each run, and of a position the reference of the run that was recorded longest."""
    factor = PANELS[panel.kind].scale
    runs = [run for run in shown.recorded if panel.of in shown_by(run, panel.kind)]
    if panel.kind == "position":
        longest = max(runs, key=lambda run: run.time[-1])
        reference = longest.columns.get(longest.plan.axes[panel.of].reference)
        if reference is not None:
            yield Line("reference", "reference", longest.time, factor * reference,
                       dash="none" if shown.colours is None else DASHES[2])
    for number, run in enumerate(runs):
        columns, label = recorded_columns(run), shown.figure.runs[run.plan.name]
        names = needed_columns(run.plan, panel.kind, panel.of)
        for k, name in enumerate(names[:1] if panel.kind == "position" else names):
            if name not in columns:
                continue
            short = name.rpartition(".")[2].replace("_cmd", "")
            colour = (f"run-{shown.colours[run.plan.name]}" if shown.colours is not None
                      else current_colour(panel.kind, k) or f"run-{number % COLOURS}")
            if PANELS[panel.kind].of == "motor":
                label = short if len(runs) == 1 else f"{short} {shown.figure.runs[run.plan.name]}"
            yield Line(label, colour, run.time, factor * columns[name], dash=DASHES[number % len(DASHES)],
                       width=0.7 if k and shown.colours is not None else 1.5)


def current_colour(kind: str, k: int) -> str:
    """Name of the colour of the k-th line of a motor's panel; empty of other kinds."""
    return {"currents": PHASES[k % 3], "commands": ("direct", "quadrature")[k % 2]}.get(kind, "")


def panel_picture(panel: PanelPicture, first: bool = True) -> str:
    """One panel as SVG: title and names of the lines, frame with labels, and the lines; none if it has no points.

    The first one of several has the names of events.
    """
    title, x_title, floor = panel.title, panel.x_title, panel.floor
    logarithmic = floor is not None
    lines = [finite(line, floor) for line in panel.lines]
    lines = [line for line in lines if len(line.x)]
    if not lines:
        return ""
    x_low, x_high = limits(lines, 0, 0.0)
    low, high = limits(lines, 1, 0.05)
    bottom, top = (high, low) if panel.down else (low, high)
    room = NAMES if first and panel.windows else 0
    drawn = []
    for name, start, end in panel.windows:
        if start < x_high and end > x_low:
            left, right = (LEFT + WIDTH * (min(max(time, x_low), x_high) - x_low) / (x_high - x_low)
                           for time in (start, end))
            drawn.append(f'<path d="M{left:.0f} {TOP}H{right:.0f}v{HEIGHT}H{left:.0f}z" class="window"/>')
            if first:
                drawn.append(f'<text x="{left:.0f}" y="{TOP - 4}" class="window-name">{escape(name)}</text>')
    for value, label in labels(low, high, logarithmic):
        y = TOP + HEIGHT * (top - value) / (top - bottom)
        drawn.append(f'<path d="M{LEFT} {y:.0f}h{WIDTH}" class="grid"/><text x="{LEFT - 5}" y="{y + 4:.0f}" '
                     f'class="end">{label}</text>')
    for value, label in labels(x_low, x_high, False):
        x = LEFT + WIDTH * (value - x_low) / (x_high - x_low)
        drawn.append(f'<text x="{x:.0f}" y="{TOP + HEIGHT + 14}" class="mid">{label}</text>')
    for line in lines:
        across = LEFT + WIDTH * (line.x - x_low) / (x_high - x_low)
        drawn.append(shape(line, across, TOP + HEIGHT * (top - line.y) / (top - bottom),
                           MOST_POINTS * (1 + logarithmic)))
    names = "".join(f'<tspan dx="10" style="fill:var(--{line.colour})">{escape(line.name)}</tspan>' for line in lines
                    if panel.named)
    return (f'<svg class="still" viewBox="0 {-room} {LEFT + WIDTH + 6} {TOP + HEIGHT + BELOW + room}" role="img" '
            f'aria-label="{escape(title)} over {escape(x_title)}"><text x="{LEFT}" y="{14 - room}">'
            f'<tspan font-weight="bold">{escape(title)}</tspan>{names}</text>{"".join(drawn)}'
            f'<path d="M{LEFT} {TOP}h{WIDTH}v{HEIGHT}h-{WIDTH}z" '
            f'class="grid"/><text x="{LEFT + WIDTH // 2}" y="{TOP + HEIGHT + 29}" class="mid">'
            f"{escape(x_title)}</text></svg>")


def finite(line: Line, floor: float | None) -> Line:
    """The line without points that are not finite; of a logarithmic one, from a floor on, logarithms of its sizes."""
    kept = np.isfinite(line.x) & np.isfinite(line.y)
    y = line.y[kept]
    return line._replace(x=line.x[kept], y=y if floor is None else np.log10(np.maximum(np.abs(y), floor)))


def limits(lines: Sequence[Line], of: int, air: float) -> tuple[float, float]:
    """Least and largest abscissa (0) or ordinate (1) of lines, with a share of air; never the same."""
    values = [(line.x, line.y)[of] for line in lines]
    low, high = min(float(each.min()) for each in values), max(float(each.max()) for each in values)
    if high - low < 1e-9 * max(1.0, abs(high)):
        low, high = low - 0.5, high + 0.5
    return low - air * (high - low), high + air * (high - low)


def labels(low: float, high: float, logarithmic: bool) -> list[tuple[float, str]]:
    """At most six places between two limits, and what is written there."""
    if logarithmic:
        return [(power, f"{10.0 ** power:g}") for power in range(math.ceil(low), math.floor(high) + 1)]
    power = 10.0 ** math.floor(math.log10((high - low) / 5.0))
    step = next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power * 5.0 >= (high - low) * (1 - 1e-9))
    return [(k * step, f"{k * step:.6g}".replace("-", "−"))
            for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def shape(line: Line, x: Array, y: Array, most: int) -> str:
    """A line through points (px), with those left out that would not be seen; or marks there."""
    if line.marked:
        marks = "".join(f"M{across:.0f} {down:.0f}h.1" for across, down in zip(x, y, strict=True))
        return f'<path class="mark" style="stroke:var(--{line.colour})" d="{marks}"/>'
    if len(x) > most and (np.diff(x) > 0.0).all():
        rows = thin(x, y, FINEST, most).rows
        x, y = x[rows], y[rows]
    points = np.rint(np.stack([x, y], axis=1)).astype(int)
    # Each point but the first by its distance from the one before, which takes fewer characters.
    steps = [f"{across} {down}" for across, down in np.diff(points, axis=0) if across or down]
    look = (f";stroke-dasharray:{line.dash}" if line.dash != "none" else "") + (
        f";stroke-width:{line.width:g}" if line.width != 1.5 else "")
    return (f'<path style="stroke:var(--{line.colour}){look}" d="M{points[0, 0]} {points[0, 1]}'
            f'l{" ".join(steps) or "0 0"}"/>')
