"""Charts of the procedures on the page: where they stand among the figures, and the numbers of their curves."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from maglev.pages.figures import Shown, anchor
from maglev.pages.series import thin
from maglev.runs.procedure_outcome import Chart, Curve, Outcome

DIGITS = 6              # significant ones of the numbers of a curve
MOST_POINTS = 4000      # of a line
FINEST = 1e-4           # of the height of a line: tolerance from which on points are left out of a longer one


class ShownChart(NamedTuple):
    """A chart with points, and its outcome; see `Shown` for the rest."""

    outcome: Outcome
    chart: Chart
    id: str
    number: str | None
    title: str
    caption: str
    names: list[str]     # the procedure, and the runs that it rests on


def shown_charts(outcomes: Iterable[Outcome]) -> Iterator[ShownChart]:
    for outcome in outcomes:
        name, seen = outcome.settings.name, Counter[str | None]()
        for chart in outcome.charts:
            if any(len(curve.x) for panel in chart.panels for curve in panel.curves):
                number = chart.number
                seen[number] += 1
                parts = filter(None, (number, name, str(seen[number]) if seen[number] > 1 else ""))
                title = f"Figure {number}" if number else outcome.settings.title
                yield ShownChart(outcome, chart, anchor("figure", *parts), number, title, chart.caption,
                                 [name, *outcome.runs])


def by_number(figures: Iterable[Shown], charts: Iterable[ShownChart]) -> list[Shown | ShownChart]:
    """Figures of a user's own runs, then figures and charts by number, figures first, then those that have none."""
    def place(shown: Shown | ShownChart) -> tuple[bool, bool, list[int]]:
        packaged = isinstance(shown, ShownChart) or not any(run.plan.own for run in shown.runs)
        return packaged, shown.number is None, [int(part) for part in re.findall(r"\d+", shown.number or "")]

    return sorted([*figures, *charts], key=place)


def chart_data(shown: ShownChart) -> dict[str, Any]:
    return {"runs": [], "chart": [{"x": panel.x_title, "y": panel.y_title,
                                   "curves": [curve_data(curve) for curve in panel.curves]}
                                  for panel in shown.chart.panels]}


def curve_data(curve: Curve) -> dict[str, Any]:
    """Return one curve; a long line is thinned to distinguishable points. `margin` is there if the curve has one."""
    x, y = np.asarray(curve.x, dtype=np.float64), np.asarray(curve.y, dtype=np.float64)
    rows: NDArray[np.intp] | slice = slice(None)
    # Only of a line along ascending abscissae can points be left out.
    if len(x) > MOST_POINTS and not curve.marked and np.isfinite(x + y).all() and (np.diff(x) > 0.0).all():
        rows = thin(x, y, max(FINEST * float(np.ptp(y)), np.finfo(float).tiny), MOST_POINTS)[0]
    data: dict[str, Any] = {"label": curve.label, "kin": curve.kin or curve.label, "marked": curve.marked,
                            "x": rounded(x[rows].tolist()), "y": rounded(y[rows].tolist())}
    if curve.margin is not None:
        data["margin"] = rounded(np.asarray(curve.margin, dtype=np.float64)[rows].tolist())
    return data


def rounded(values: Iterable[float], digits: int = DIGITS) -> list[float | None]:
    """Return numbers in JSON form; None, where a line has a gap, for a number that is not finite."""
    return [float(f"{value:.{digits}g}") if np.isfinite(value) else None for value in values]
