"""How runs ended, in the words of the terminal and of the page."""

from typing import NamedTuple

from maglev.experiment.execution import RunResult
from maglev.judging.metrics import Metrics
from maglev.judging.verdicts import Judgements


class Event(NamedTuple):
    """What disturbed or stopped a run: when (s), in words, and in one word where there is no room."""

    time: float
    words: str
    word: str


def events(metrics: Metrics | None) -> list[Event]:
    """What disturbed or stopped a run, in order of time; nothing of a run that did not complete."""
    if metrics is None:
        return []
    found = ((metrics.stop_contact, "touched an end stop", "stop"), (metrics.tripped, "the controller tripped", "trip"))
    return sorted(Event(time, words, word) for time, words, word in found if time is not None)


def modification(result: RunResult) -> str:
    """What makes a run another one than its plan says; empty if nothing does."""
    return f"modified run: {', '.join(result.provenance.differences)}" if (
        result.provenance is not None and result.modified) else ""


def troubles(result: RunResult) -> list[str]:
    """What went wrong in a run, if anything."""
    if result.failure is not None:
        return [f"did not complete: {result.failure}"]
    return [f"{event.words} at {event.time:.3f} s" for event in events(result.metrics)]


def run_status(result: RunResult) -> list[str]:
    """What a reader must know before anything else about a run: that it is another one, and what went wrong."""
    modified = modification(result)
    return [*([modified] if modified else []), *troubles(result)]


def is_listed(result: RunResult, judgements: Judgements) -> bool:
    """Whether tables list a run: of a procedure, which has dozens, only those that have something to tell."""
    return bool(result.plan.procedure is None or result.failure is not None
                or judgements.get(result.plan.name))
