"""Bounds by the axes of the thesis's figures, as the ranges that a figure of the page shades in its panels."""

from collections.abc import Iterator, Sequence
from typing import Any

from maglev.judging.verdicts import ClaimResult, Judgements, bounds
from maglev.report.plots.figures import Panel, Shown, needed_columns
from maglev.schema.claims import RunClaim


def figure_bounds(shown: Shown, judgements: Judgements) -> list[dict[str, Any]]:
    """Ranges (SI) in a figure: the panel's number, the limits, and whether the bound is met; None if not judged."""
    found = []
    for run in shown.runs:
        for result in bounds(judgements.get(run.plan.name, ())):
            if result.claim.figure == shown.number and isinstance(result.claim, RunClaim):
                panels = [k for k, panel in enumerate(shown.panels) if draws(shown, panel, result.claim.columns or ())]
                found += [{"panel": k, "low": low, "high": high, "met": {"met": True, "not met": False}.get(
                    result.verdict)} for k in panels for low, high in ranges(result)]
    return found


def draws(shown: Shown, panel: Panel, columns: Sequence[str]) -> bool:
    """Whether a panel draws one of the columns, or the true position that an encoder measures."""
    drawn = {column for run in shown.runs for column in needed_columns(run.plan, panel.kind, panel.of)}
    return any(column.replace(".encoder", ".position") in drawn for column in columns)


def ranges(result: ClaimResult) -> Iterator[tuple[float, float]]:
    """The range of a bound; of an absolute value also that below zero."""
    assert isinstance(result.claim.target, tuple)
    low, high = result.claim.target
    yield low, high
    if result.claim.quantity == "largest":
        yield -high, -low
