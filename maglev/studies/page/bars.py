"""Bars of a study's page as SVG: histograms of metrics with their limits, and Sobol indices with their confidence."""

import math
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from maglev.arrays import Array
from maglev.report.plots.static import labels
from maglev.studies.page.sensitivity import Indices

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 300, 90, 34, 6, 20, 34   # units of a histogram and around it
MOST_BARS = 20
ROW, NAMES, SPAN = 17, 150, 330   # units of the indices: of a bar, of the names before the bars, and of an index of 1


def histogram(name: str, unit: str, values: Array, limits: Mapping[str, float]) -> str:
    """Histogram of a metric as SVG, all in one unit: bars, those beyond a limit striped, and the limits.

    What is infinite is in no bar; how many these are stands below.
    """
    known = values[np.isfinite(values)]
    endless = len(values) - len(known)
    if not len(known):
        return ""
    ends = [*known, *limits.values()]
    low, high = float(min(ends)), float(max(ends))
    air = 0.03 * (high - low) or 0.5
    counts, edges = np.histogram(known, np.linspace(low, high, MOST_BARS + 1) if high > low else np.array(
        [low - air, high + air]))
    low, high = low - air, high + air
    most = int(counts.max())

    def across(value: float) -> float:
        return LEFT + WIDTH * (value - low) / (high - low)

    parts = []
    for count, start, end in zip(counts.tolist(), edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        tall = HEIGHT * count / most
        middle = 0.5 * (start + end)
        beyond = middle < limits.get("min", -math.inf) or middle > limits.get("max", math.inf)
        if count:
            left, right = across(start) + 0.5, across(end) - 0.5
            parts.append(f'<path class="bar{" beyond" if beyond else ""}" d="M{left:.1f} {TOP + HEIGHT - tall:.1f}'
                         f'H{right:.1f}V{TOP + HEIGHT}H{left:.1f}z">'
                         f"<title>{count} from {start:.4g} to {end:.4g} {escape(unit)}</title></path>")
    parts += [f'<path class="limit" d="M{across(value):.1f} {TOP}v{HEIGHT}"/>' for value in limits.values()]
    parts += [f'<text x="{across(value):.1f}" y="{TOP + HEIGHT + 14}">{label}</text>'
              for value, label in labels(low, high, False)]
    parts.append(f'<text class="end" x="{LEFT - 4}" y="{TOP + 8}">{most}</text>')
    title = escape(f"{name} ({unit})" if unit else name)
    never = f"; {endless} never" if endless else ""
    return (f'<svg class="bars" viewBox="0 0 {LEFT + WIDTH + RIGHT} {TOP + HEIGHT + BOTTOM}" role="img" aria-label="'
            f'{title}: {len(known)} samples from {known.min():.4g} to {known.max():.4g}{never}">'
            f'{"".join(parts)}<path class="frame" d="M{LEFT} {TOP}v{HEIGHT}h{WIDTH}"/>'
            f'<text x="{LEFT + WIDTH / 2:g}" y="{TOP + HEIGHT + 29}">{title}{never}</text></svg>')


def index_bars(indices: Sequence[Indices]) -> str:
    """Sobol indices as SVG: of each metric and quantity the total one, in it that of first order, with whiskers."""
    rows, parts = 0, []

    def whisker(index: float, confidence: float, y: float) -> str:
        low, high = (NAMES + SPAN * min(max(index + sign * confidence, 0.0), 1.2) for sign in (-1, 1))
        return f'<path class="whisker" d="M{low:.0f} {y:.0f}H{high:.0f}"/>' if math.isfinite(confidence) else ""

    for each in indices:
        rows += 1
        parts.append(f'<text class="start" x="0" y="{ROW * rows}" font-weight="bold">{escape(each.metric)}</text>')
        for name, total in each.total.items():
            y, first = ROW * rows + 4, each.first[name]
            rows += 1
            parts.append(f'<text class="end" x="{NAMES - 6}" y="{y + 12}">{escape(name)}</text>'
                         f'<path class="total" d="M{NAMES} {y}h{SPAN * max(total, 0.0):.0f}v{ROW - 3}H{NAMES}z"/>'
                         f'<path class="bar" d="M{NAMES} {y + 3}h{SPAN * max(first, 0.0):.0f}v{ROW - 9}H{NAMES}z"/>'
                         f"{whisker(total, each.total_confidence[name], y + ROW / 2 - 1)}")
    ticks = "".join(f'<path class="frame" d="M{NAMES + SPAN * at:.0f} 4V{ROW * (rows + 0.5):.0f}"/>'
                    f'<text x="{NAMES + SPAN * at:.0f}" y="{ROW * (rows + 1.3):.0f}">{at:g}</text>'
                    for at in (0.0, 0.5, 1.0))
    return (f'<svg class="indices" viewBox="0 0 {NAMES + SPAN + 40} {ROW * (rows + 1.6):.0f}" role="img" '
            f'aria-label="Sobol indices; as numbers below">{ticks}{"".join(parts)}</svg>')
