"""Verdict on a study: the metrics by which samples fail, and the values from which on they do."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from scipy.stats import binomtest, chi2_contingency

from maglev.files.arrays import Bools
from maglev.many.study_columns import FLAWS
from maglev.many.study_file import LISTED
from maglev.pages.findings import html_table, typeset
from maglev.pages.study_text import beyond_limits, numbers, passing_text, units_of
from maglev.pages.varied import Varied, varied_of
from maglev.runs.endings import cause
from maglev.scenario.quantities import metric_text


def failing(table: pa.Table, about: Mapping[str, Any]) -> list[tuple[str, str, Bools]]:
    """Reasons, most first: metric with a limit or none, words, and which samples fail by it, shape (samples,).

    Samples that failed or ended off target have the cause as their reason.
    """
    units, limits = units_of(table), about["limits"]
    beyond = {name: beyond_limits(numbers(table, name), about, name) for name in limits}
    reasons = [(name, reason(about, name, units[name]), beyond[name]) for name in limits if name not in FLAWS]
    flaws = [beyond[name] for name in FLAWS if name in limits]
    if limits:
        reasons.append(("", "not completed", np.array([why is not None for why in table["failure"].to_pylist()])))
    else:
        flaws = [np.ones(len(table), bool)]   # every ending counts
    for of_flaw in flaws:
        causes = np.where(of_flaw, [*map(cause, table["ending"].to_pylist())], "")
        reasons += [("", words, causes == words) for words in sorted({*causes.tolist()} - {""})]
    return sorted((item for item in reasons if item[2].any()), key=lambda item: -item[2].sum())


def reason(about: Mapping[str, Any], name: str, unit: str) -> str:
    """Return why a sample fails by a metric with limits: "overshoot of v above its limit 0.25"."""
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
    """Return the largest ratio of a metric to its upper limit, and the metric; 0 and empty without such limits."""
    shares = [(max((value for value in table[name].to_pylist() if value is not None), default=0.0) / limits["max"],
               name) for name, limits in about["limits"].items() if (limits.get("max") or 0.0) > 0.0]
    return max(shares, default=(0.0, ""))


def telling(table: pa.Table, about: Mapping[str, Any]) -> list[str]:
    """Return the varied quantities by the difference of passing and failing samples in standard deviations, largest
    first.
    """
    passed = np.array(table["passed"].to_pylist())

    def apart(name: str) -> float:
        values = numbers(table, name)
        if passed.all() or not passed.any() or not values.std():
            return 0.0
        return float(abs(values[passed].mean() - values[~passed].mean()) / values.std())

    return sorted((parameter["name"] for parameter in about["vary"]), key=lambda name: -apart(name))


def question(table: pa.Table, about: Mapping[str, Any]) -> str:
    """Return the question of a study: does a run hold for the varied quantities, each from its least to its largest
    value?
    """
    varied = []
    for each in varied_of(table, about)[:MOST_NAMED]:
        tried = each.text(each.values.min(), each.values.max(), digits=3 if each.signed else 4)
        label = each.label.replace(", change", " changed")
        varied.append(f"{label}{' by ' if each.signed else ' from ' if ' to ' in tried else ' = '}{tried}")
    more = [f"{len(about['vary']) - MOST_NAMED} more"] if len(about["vary"]) > MOST_NAMED else []
    wanted = "stay within its limits" if about["limits"] else "keep the stage in the air"
    return f"Does {about['scenario']} {wanted} with {' and '.join([*varied, *more])}?"


def answer(table: pa.Table, about: Mapping[str, Any]) -> tuple[str, str]:
    """Return how many samples pass, and the reasons why others fail or the metric nearest to its limit; text."""
    passed, reasons = np.array(table["passed"].to_pylist()), failing(table, about)
    share, name = nearest_to_limit(table, about)
    said = f"; {name} comes nearest to its limit: {100.0 * share:.0f} % of it." if name else "."
    if reasons:
        whose = "the others fail" if passed.any() else "it fails" if len(passed) == 1 else "all fail"
        parts = [f"{failed.sum():,} by {why}" for _, why, failed in reasons]
        said = f": {whose} by {reasons[0][1]}." if len(parts) == 1 else f": {whose}, {', '.join(parts)}."
    return passing_text(passed.sum(), len(passed)), said


def study_verdict(table: pa.Table, about: Mapping[str, Any]) -> str:
    """Return the question of a study and its answer; HTML."""
    passing, said = answer(table, about)
    return (f'<p class="message">{typeset(question(table, about))} <strong>{escape(passing)}</strong>'
            f"{typeset(said)}</p>")


def where(table: pa.Table, about: Mapping[str, Any]) -> str:
    """Return the share of passing samples over each varied quantity, if some pass and some do not; HTML.

    For a grid it gives the values at which all pass and all fail. For random values it gives the share in each part of
    them, with its uncertainty, and the quantities without a clear influence.
    """
    passed = np.array(table["passed"].to_pylist())
    if passed.all() or not passed.any():
        return ""
    order = telling(table, about)
    varied = sorted(varied_of(table, about), key=lambda each: order.index(each.name))
    if about["design"]["kind"] in LISTED:
        rows = [(escape(each.label), *map(typeset, edges(each, passed))) for each in varied]
        told = [row for row in rows if row[2:] != (NOWHERE, NOWHERE)]
        idle = [escape(each.label) for each in varied if changes_nothing(each, varied, passed)]
        return (html_table(("quantity", "simulated", "all pass", "all fail"), told) if told else "") + (
            f"<p>Without influence on passing: {', '.join(idle)}.</p>" if idle else "")
    shares = {each.label: passing_shares(each, passed) for each in varied}
    clear = {label: parts for label, parts in shares.items() if has_influence(parts, SURE / len(varied))}
    tables = [html_table(("values", "pass", "95 % sure", "samples"), [
        (typeset(part.values), f'<span class="share" style="--share: {100.0 * part.share:.0f}%; --low: '
         f'{100.0 * part.low:.0f}%; --high: {100.0 * part.high:.0f}%">{100.0 * part.share:.0f} %</span>',
         f"{100.0 * part.low:.0f} to {100.0 * part.high:.0f} %", f"{part.passing} of {part.samples}")
        for part in parts], label) for label, parts in clear.items()]
    unclear = [escape(label) for label in shares if label not in clear]
    return f'<div class="shares">{"".join(tables)}</div>' * bool(tables) + (
        f"<p>Without clear influence on passing: {', '.join(unclear)}.</p>" if unclear else "")


def changes_nothing(one: Varied, varied: Sequence[Varied], passed: Bools) -> bool:
    """Return True if samples that differ in one quantity alone all pass or all fail, and there are such samples."""
    others = [each.values for each in varied if each is not one]
    if not others:
        return False
    _, group = np.unique(np.column_stack(others), axis=0, return_inverse=True)
    samples, passing = np.bincount(group), np.bincount(group, passed)
    return bool(samples.max() > 1 and ((passing == 0) | (passing == samples)).all())


class Part(NamedTuple):
    """Samples whose values are next to each other: how many there are and pass, and the share with its limits."""

    values: str
    samples: int
    passing: int
    low: float    # of the share that passes, by Wilson's interval of 95 %
    high: float

    @property
    def share(self) -> float:
        return self.passing / self.samples


def passing_shares(varied: Varied, passed: Bools) -> list[Part]:
    """The samples in up to five parts as large as each other, in the order of their values."""
    order = np.argsort(varied.values, kind="stable")
    parts = []
    for chosen in np.array_split(order, max(1, min(MOST_PARTS, len(order) // LEAST_OF_A_PART))):
        samples, passing = len(chosen), int(passed[chosen].sum())
        low, high = binomtest(passing, samples).proportion_ci(0.95, "wilson")
        parts.append(Part(varied.text(varied.values[chosen[0]], varied.values[chosen[-1]], digits=3), samples, passing,
                          low, high))
    return parts


def has_influence(parts: Sequence[Part], level: float) -> bool:
    """Return True if shares differ by more than by chance: Pearson's test of homogeneity, below a level."""
    counts = np.array([[part.passing, part.samples - part.passing] for part in parts])
    return len(parts) > 1 and bool(chi2_contingency(counts, correction=False).pvalue < level)


def edges(varied: Varied, passed: Bools) -> tuple[str, str, str]:
    """Range of values that were run, at which values all samples pass, and at which all fail; in one unit."""
    tested, place, samples = np.unique(varied.values, return_inverse=True, return_counts=True)
    passing = np.bincount(place[passed], minlength=len(tested))

    def runs(inside: Bools) -> str:
        ends = np.flatnonzero(np.diff(inside, prepend=False, append=False)).reshape(-1, 2)
        return ", ".join(varied.text(tested[start], tested[end - 1]) for start, end in ends.tolist()) or NOWHERE

    return varied.text(tested[0], tested[-1]), runs(passing == samples), runs(passing == 0)


NOWHERE = "nowhere"
MOST_NAMED = 3        # quantities that the question names
MOST_PARTS = 5        # of the samples, by one quantity
LEAST_OF_A_PART = 8   # samples
SURE = 0.05           # level of all tests together (Bonferroni)
