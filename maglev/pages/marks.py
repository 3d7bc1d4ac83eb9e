"""Marks in the panels of a figure: the values that the thesis states in words, and the ends of its axes."""

import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from maglev.pages.figures import Panel, Shown, needed_columns
from maglev.runs.execution import RunResult
from maglev.runs.verdicts import ClaimResult, Judgements, bound_claims, sentences
from maglev.scenario.claims import RunClaim

# "Fig. 4.18", "Figs. 5.34-5.36", "Figures 4.18, 4.19 and 4.21"; a number elsewhere is an equation or a section.
FIGURE_LIST = re.compile(r"Fig(?:ure|ures|s)?\.?\s*(\d+\.\d+(?:\s*(?:,|-|–|and|to)\s*\d+\.\d+)*)")
FIGURE_NUMBER = re.compile(r"\d+\.\d+")
FIGURE_RANGE = re.compile(r"(\d+)\.(\d+)\s*(?:-|–|to)\s*(\d+)\.(\d+)")


class Mark(NamedTuple):
    """A line in a panel, SI: at a time (s), or at a level between two times."""

    kind: str                     # of the panel
    of: str                       # its axis or motor
    time: float | None = None
    level: float | None = None
    start: float = 0.0
    end: float | None = None      # None means to the end


def figure_marks(shown: Shown, judgements: Judgements) -> list[dict[str, Any]]:
    """Return marks in a figure: the panel's number, a time, or a level between two times, and the claim; each once.

    Claims about other figures are left out.
    """
    texts: dict[tuple[int, Mark, str], None] = {}
    for run in shown.recorded:
        for result in sentences(judgements.get(run.plan.name, ())):
            claim = result.claim
            cited = cited_figures(claim.source)
            if isinstance(claim, RunClaim) and isinstance(claim.target, float) and (not cited or shown.number in cited):
                words = f"{claim.criterion}, of one of them" if claim.over == "any" else claim.criterion
                texts |= dict.fromkeys((k, mark, words) for mark in marks(claim, claim.target, run, shown)
                                       for k, panel in enumerate(shown.panels) if tuple(panel) == (mark.kind, mark.of))
    return [{"panel": k, "text": f"thesis: {text}",
             **{key: value for key, value in mark._asdict().items() if key not in ("kind", "of")}}
            for k, mark, text in texts]


def marks(claim: RunClaim, target: float, run: RunResult, shown: Shown) -> Iterator[Mark]:
    """Return the marks of the value (SI) that a claim states about a run, whatever panels there are."""
    quantity, plan = claim.quantity, run.plan
    axes = claim.axes or list(plan.axes)
    if claim.measured is None or run.metrics is None:
        return
    if claim.measured.on == "step":
        yield from marks_of_steps(claim, target, run, shown, axes)
    elif claim.measured.on == "tracking":
        for axis in axes:
            yield (Mark("error", axis, time=target) if quantity == "tracking_transient" else
                   Mark("error", axis, level=target, start=plan.metrics.tracking_from or 0.0))
    elif claim.measured.on == "motor":
        yield from (Mark(claim.measured.recorded, motor, level=sign * target) for motor in claim.motors or plan.motors
                    for sign in (1.0, -1.0))
    elif claim.measured.on == "event":
        for event in run.metrics.events if quantity != "integral_absolute_error" else ():
            for axis in axes if claim.event in (None, event.name) else ():
                yield (Mark("error", axis, time=event.time + target) if quantity == "recovery_time" else
                       Mark("error", axis, level=target, start=event.time, end=event.end))
    elif claim.measured.on == "column":
        yield from (Mark(panel.kind, panel.of, level=sign * target) for panel in shown.panels
                    if draws(shown, panel, claim.columns or ()) for sign in (1.0, -1.0)[:1 + (quantity == "largest")])
    elif quantity == "trip_time":
        yield from (Mark(panel.kind, panel.of, time=target) for panel in shown.panels)


def marks_of_steps(claim: RunClaim, target: float, run: RunResult, shown: Shown,
                   axes: Sequence[str]) -> Iterator[Mark]:
    """Return the marks of a claim about each step: its settling time, its overshoot, or its error at the end.

    A time beyond the next step has no mark.
    """
    assert run.metrics is not None
    for step in (step for step in run.metrics.steps if step.axis in axes):
        end = min((other.time for other in run.metrics.steps if other.time > step.time), default=None)
        if claim.quantity == "settling_time":
            if step.time + target < (end or run.time[-1]):
                kind = "error" if Panel("error", step.axis) in shown.panels else "position"
                yield Mark(kind, step.axis, time=step.time + target)
        elif claim.quantity == "overshoot" and claim.over != "any":   # five levels for one step would hide it
            peak = step.target + target * (step.target - step.start)
            yield Mark("position", step.axis, level=peak, start=step.time, end=end)
        elif claim.quantity == "steady_state_error":
            yield Mark("error", step.axis, level=target, start=step.time, end=end)


def figure_bounds(shown: Shown, judgements: Judgements) -> list[dict[str, Any]]:
    """Ranges (SI) in a figure: the panel's number, the limits, and whether the bound is met; None if not judged."""
    shown_bounds = []
    for run in shown.runs:
        for result in bound_claims(judgements.get(run.plan.name, ())):
            if result.claim.figure == shown.number and isinstance(result.claim, RunClaim):
                panels = [k for k, panel in enumerate(shown.panels) if draws(shown, panel, result.claim.columns or ())]
                shown_bounds += [{"panel": k, "low": low, "high": high, "met": {"met": True, "not met": False}.get(
                    result.verdict)} for k in panels for low, high in ranges(result)]
    return shown_bounds


def draws(shown: Shown, panel: Panel, columns: Sequence[str]) -> bool:
    """Return True if a panel draws one of the columns, or the true position that an encoder measures."""
    drawn = {column for run in shown.runs for column in needed_columns(run.plan, panel.kind, panel.of)}
    return any(column.replace(".encoder", ".position") in drawn for column in columns)


def ranges(result: ClaimResult) -> Iterator[tuple[float, float]]:
    """The range of a bound; of an absolute value also that below zero."""
    assert isinstance(result.claim.target, tuple)
    low, high = result.claim.target
    yield low, high
    if result.claim.quantity == "largest":
        yield -high, -low


def cited_figures(source: str) -> set[str]:
    """Numbers of the figures that a source cites, those within a range too."""
    numbers: set[str] = set()
    for text in FIGURE_LIST.findall(source):
        numbers.update(FIGURE_NUMBER.findall(text))
        for chapter, first, _, last in FIGURE_RANGE.findall(text):
            numbers.update(f"{chapter}.{k}" for k in range(int(first), int(last) + 1))
    return numbers
