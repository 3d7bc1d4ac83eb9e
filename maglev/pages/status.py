"""The ends of runs, in the words of the terminal and of the page, and whether they are the user's own."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from maglev.runs.endings import events
from maglev.runs.execution import RunResult
from maglev.runs.metrics import Metrics
from maglev.runs.procedure_outcome import Outcome
from maglev.runs.verdicts import Judgements

AROUND = 5.0     # times the time until a crash that are drawn of a run which it ends early
SHORTEST = 0.1   # s, that are drawn of it at least


def shown_until(runs: Iterable[tuple[Metrics | None, float]]) -> float | None:
    """Return the time (s) to which runs, each with its end (s), are drawn: soon after the last crash, None for all.

    It is only for runs that are all lost early, because the rest would hide the way to the crash.
    """
    ends = []
    for metrics, end in runs:
        first = events(metrics)[:1]
        if not first:
            return None
        ends.append((max(AROUND * first[0].time, SHORTEST), end))
    until = max((shown for shown, _ in ends), default=0.0)
    return until if ends and until < 0.5 * max(end for _, end in ends) else None


def modification(result: RunResult) -> str:
    """Return the differences of a run from its plan; empty if there are none."""
    return f"modified run: {', '.join(result.provenance.differences)}" if (
        result.provenance is not None and result.modified) else ""


def run_status(result: RunResult, reason: bool = True) -> list[str]:
    """Return the most important facts about a run: its differences from the plan, and its errors."""
    went_wrong = [] if result.outcome == "completed" else [result.ending if reason else result.outcome]
    return [*filter(None, [modification(result)]), *went_wrong]


def is_listed(result: RunResult, judgements: Judgements) -> bool:
    """Return True if tables list a run: of a procedure, which has dozens, only failed runs and those with claims."""
    return bool(result.plan.procedure is None or result.failure is not None
                or judgements.get(result.plan.name))


class Part(NamedTuple):
    """Runs with the outcomes of the procedures that these belong to."""

    results: list[RunResult]
    outcomes: list[Outcome]

    def __bool__(self) -> bool:
        return bool(self.results or self.outcomes)


def own_and_packaged(results: Sequence[RunResult], outcomes: Sequence[Outcome]) -> tuple[Part, Part]:
    """A user's own runs and procedures, and those of the package."""
    own = {result.plan.name for result in results if result.plan.own}

    def part(mine: bool) -> Part:
        return Part([result for result in results if result.plan.own is mine],
                    [outcome for outcome in outcomes if bool(own & {*outcome.runs}) is mine])

    return part(True), part(False)
