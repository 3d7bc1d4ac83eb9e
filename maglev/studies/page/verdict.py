"""Where a study's scenario holds and where it breaks: by what it fails, and from which values on."""

from collections.abc import Mapping
from html import escape
from typing import Any

import numpy as np
import pyarrow as pa

from maglev.arrays import Array, Bools
from maglev.judging.endings import cause
from maglev.quantities import metric_text, shown_in
from maglev.report.findings import html_table
from maglev.studies.page.text import beyond_limits, numbers, units_of


def failing(table: pa.Table, about: Mapping[str, Any]) -> list[tuple[str, str, Bools]]:
    """Reasons, most first: metric with a limit or none, words, and which samples fail by it, shape (samples,)."""
    units = units_of(table)
    reasons = [(name, reason(about, name, units[name]), beyond_limits(numbers(table, name), about, name))
               for name in about["limits"]]
    if not about["limits"]:
        causes = [*map(cause, table["ending"].to_pylist())]
        reasons += [("", words, np.array([each == words for each in causes])) for words in sorted({*causes} - {""})]
    else:
        reasons.append(("", "not completed", np.array([why is not None for why in table["failure"].to_pylist()])))
    return sorted((item for item in reasons if item[2].any()), key=lambda item: -item[2].sum())


def reason(about: Mapping[str, Any], name: str, unit: str) -> str:
    """Why a sample fails by a metric with limits: "overshoot of v above its limit 0.25"."""
    low, high = (None if value is None else metric_text(name, value, unit)
                 for value in (about["limits"][name].get(key) for key in ("min", "max")))
    if low and high:
        return f"{name} outside its limits {low} to {high}"
    return f"{name} below its limit {low}" if low else f"{name} above its limit {high}"


def decisive_metric(table: pa.Table, about: Mapping[str, Any]) -> str:
    """Metric with a limit that most samples are beyond or, where all pass, that comes nearest to it; empty if none."""
    reasons = failing(table, about)
    return next((name for name, _, _ in reasons if name), "") if reasons else nearest_to_limit(table, about)[1]


def nearest_to_limit(table: pa.Table, about: Mapping[str, Any]) -> tuple[float, str]:
    """Largest share of an upper limit that a metric comes to, and the metric; 0 and empty without such limits."""
    shares = [(max((value for value in table[name].to_pylist() if value is not None), default=0.0) / limits["max"],
               name) for name, limits in about["limits"].items() if (limits.get("max") or 0.0) > 0.0]
    return max(shares, default=(0.0, ""))


def telling(table: pa.Table, about: Mapping[str, Any]) -> list[str]:
    """What varies, that first by which samples that pass and that fail differ most, in standard deviations."""
    passed = np.array(table["passed"].to_pylist())

    def apart(name: str) -> float:
        values = numbers(table, name)
        if passed.all() or not passed.any() or not values.std():
            return 0.0
        return float(abs(values[passed].mean() - values[~passed].mean()) / values.std())

    return sorted((parameter["name"] for parameter in about["vary"]), key=lambda name: -apart(name))


def question(table: pa.Table, about: Mapping[str, Any]) -> str:
    """What a study asks: whether a run holds for what varies, each from its least to its largest value."""
    units, every = units_of(table), np.ones(table.num_rows, dtype=bool)
    varied = []
    for parameter in about["vary"][:MOST_NAMED]:
        tried, _, _ = edges(numbers(table, parameter["name"]), every, units[parameter["name"]])
        varied.append(f"{parameter['name']} {'from ' if ' to ' in tried else '= '}{tried}")
    more = [f"{len(about['vary']) - MOST_NAMED} more"] if len(about["vary"]) > MOST_NAMED else []
    wanted = "stay within its limits" if about["limits"] else "keep the stage in the air"
    return f"Does {about['scenario']} {wanted} with {' and '.join([*varied, *more])}?"


def study_verdict(table: pa.Table, about: Mapping[str, Any]) -> str:
    """What was asked and how many samples pass, and by what others fail; HTML."""
    passed, reasons = np.array(table["passed"].to_pylist()), failing(table, about)
    share, name = nearest_to_limit(table, about)
    said = (f": the others fail by{f' {escape(reasons[0][1])}.' if len(reasons) == 1 else ''}" if reasons else
            f"; {escape(name)} comes nearest to its limit: {100.0 * share:.0f} % of it." if name else ".")
    parts = "".join(f"<li>{failed.sum()} by {escape(why)}</li>" for _, why, failed in reasons)
    return (f'<p class="message">{escape(question(table, about))} <strong>{passed.sum():,} of '
            f"{len(passed):,} samples pass</strong>{said}</p>" + (f"<ul>{parts}</ul>" if len(reasons) > 1 else ""))


def where(table: pa.Table, about: Mapping[str, Any]) -> str:
    """Between which values of what varies all samples pass and all fail, if some do and some do not; HTML."""
    passed, units = np.array(table["passed"].to_pylist()), units_of(table)
    if passed.all() or not passed.any():
        return ""
    rows = [(escape(name), *map(escape, edges(numbers(table, name), passed, units[name])))
            for name in telling(table, about)]
    told = [row for row in rows if row[2:] != (NOWHERE, NOWHERE)]
    return html_table(("what varies", "simulated", "all pass", "all fail"), told) if told else ""


def edges(values: Array, passed: Bools, unit: str) -> tuple[str, str, str]:
    """Range of values that were run, at which values all samples pass, and at which all fail; in one unit."""
    shown, scale = shown_in(values.tolist(), unit)
    tested, place, samples = np.unique(values, return_inverse=True, return_counts=True)
    passing = np.bincount(place[passed], minlength=len(tested))

    def text(low: float, high: float) -> str:
        return (f"{scale * low:.4g}" if low == high else f"{scale * low:.4g} to {scale * high:.4g}") + (
            f" {shown}" if shown else "")

    def runs(inside: Bools) -> str:
        ends = np.flatnonzero(np.diff(inside, prepend=False, append=False)).reshape(-1, 2)
        return ", ".join(text(tested[start], tested[end - 1]) for start, end in ends.tolist()) or NOWHERE

    every_passes, every_fails = passing == samples, passing == 0
    if len(tested) == len(values) and len(tested) > MOST_VALUES:
        # At random: from the end of the range to the first that does otherwise.
        every_passes, every_fails = outer_part(every_passes), outer_part(every_fails)
    return text(tested[0], tested[-1]), runs(every_passes), runs(every_fails)


NOWHERE = "nowhere"
MOST_NAMED = 3     # quantities that the question names
MOST_VALUES = 12   # that a grid has along a side; more are drawn at random


def outer_part(inside: Bools) -> Bools:
    """What is inside from one of the ends on, without a gap."""
    return np.logical_and.accumulate(inside) | np.logical_and.accumulate(inside[::-1])[::-1]
