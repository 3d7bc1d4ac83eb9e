"""How runs ended, in the same words everywhere: completed, failed, off target or aborted, with the cause and axis."""

import re
from math import inf
from typing import NamedTuple

from maglev.runs.metrics import ManyMetrics, Metrics
from maglev.scenario.quantities import printed
from maglev.scenario.run_plan import RunPlan

COMPLETED = "completed"
ABORTED = "did not complete"

# Causes by the beginning of an ending in words, the worst first; the axis follows.
CAUSES = {ABORTED: "an abort", "failed: touched an end stop": "an end stop", "failed: the controller tripped": "a trip",
          "ended off target": "an end off target"}
AXIS = re.compile(r" on (\w+)")


class Event(NamedTuple):
    """The event that made a run fail: its time (s), its words, one word for narrow tables, and its axis."""

    time: float
    words: str
    word: str
    axis: str = ""

    def text(self, brief: bool = False) -> str:
        """Return the event, its axis and its time in words."""
        return f"{self.word if brief else self.words}{f' on {self.axis}' if self.axis else ''} at {self.time:.3f} s"


def events(metrics: Metrics | None) -> list[Event]:
    """Return the failures of a run in order of time; empty for a run that did not complete."""
    if metrics is None:
        return []
    happened = ((metrics.stop_contact, "touched an end stop", "stop", metrics.stop_axis),
                (metrics.tripped, "the controller tripped", "trip", metrics.trip_axis))
    return sorted(Event(time, words, word, axis) for time, words, word, axis in happened if time is not None)


def ending(plan: RunPlan, metrics: Metrics, brief: bool = False) -> str:
    """Return how a run ended: "failed: touched an end stop …", "ended off target: 1.04 mm on z", or "completed"."""
    if happened := events(metrics):
        return "failed: " + (happened[0].text(brief) if brief else ", ".join(event.text() for event in happened))
    errors = ", ".join(f"{printed(error, plan.axes[axis].unit)} on {axis}" for axis, error in metrics.ended_off.items())
    return f"ended off target: {errors}" if errors else COMPLETED


def endings(plan: RunPlan, many: ManyMetrics) -> list[str]:
    """Return how each of many runs ended."""
    said = [COMPLETED] * len(many.failed)
    for k in (many.failed | many.ended_off).nonzero()[0].tolist():
        off = {axis: float(errors[k]) for axis, errors in many.end_errors.items()
               if errors[k] > plan.metrics.fail_error_of(plan.axes[axis])}
        stop, trip = (float(times[k]) if times[k] < inf else None for times in (many.stop_contact_time, many.trip_time))
        said[k] = ending(plan, Metrics((), (), (), {}, stop, trip, bool(many.failed[k]), ended_off=off,
                                       stop_axis=str(many.stop_axis[k]), trip_axis=str(many.trip_axis[k])))
    return said


def severity(said: str) -> int:
    """Return the rank of an ending in words: 0 for an abort, the largest for a run that completed."""
    return next((k for k, begin in enumerate(CAUSES) if said.startswith(begin)), len(CAUSES))


def cause(said: str) -> str:
    """Return the cause of a failure, or of an end off target, with its axis, from the ending in words; empty if
    completed.
    """
    begin = next(filter(said.startswith, CAUSES), "")
    axis = AXIS.search(said) if begin != ABORTED else None
    return (CAUSES[begin] + (axis[0] if axis else "")) if begin else ""
