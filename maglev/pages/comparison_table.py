"""Measured values of several runs side by side, with the best of each row."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf

from maglev.runs.execution import RunResult
from maglev.runs.measures import Measure
from maglev.runs.verdicts import DIFFERENCE
from maglev.scenario.quantities import metric_text

FLAWS = {"ended off": "ended off target", "failed": "failed"}   # outcomes by quantity; failed goes before


@dataclass(frozen=True)
class Row:
    """One quantity of several runs, for which less is better. See `Measure` for quantity, of, time and unit."""

    quantity: str
    of: str
    time: float | None
    unit: str
    values: Mapping[str, float]              # SI, by label of the run; one on which it was not measured is left out
    flaws: Mapping[str, str] = field(default_factory=dict)   # outcomes by label of those that win nothing
    steps: int = 0                           # over which the largest value was taken; 0 if it is of one alone

    @property
    def held(self) -> dict[str, float]:
        """Values of the runs that completed, SI, by label."""
        return {label: value for label, value in self.values.items() if label not in self.flaws}

    @property
    def least(self) -> float:
        """Least value of the runs that completed, SI."""
        return min(self.held.values(), default=0.0)

    @property
    def best(self) -> tuple[str, ...]:
        """Labels of the least value among the runs that completed, and of those that are alike; none if all are."""
        tied = tuple(label for label, value in self.held.items() if value <= DIFFERENCE * self.least)
        return () if len(tied) == len(self.held) else tied

    @property
    def name(self) -> str:
        """Quantity, and the step or steps that it is about."""
        if self.steps:
            return f"{self.quantity}, worst of {self.steps}" if self.steps > 1 else self.quantity
        return self.quantity if self.time is None else f"{self.quantity} at {self.time:g} s"

    @property
    def lead(self) -> float:
        """Return the ratio of the next completed run's value to the best value; 1 if no value is the best."""
        others = [value for value in self.held.values() if value > DIFFERENCE * self.least]
        return 1.0 if not others else min(others) / self.least if self.least else inf

    @property
    def ahead(self) -> str:
        """Return the same in words, to follow "the next is"; a dash if no value is the best."""
        return times_larger(self.lead).removesuffix(" as large")

    def text(self, label: str) -> str:
        """Value of a run with its unit."""
        return metric_text(self.quantity, self.values[label], self.unit) if label in self.values else "–"


def measure_rows(measured: Mapping[str, Sequence[Measure]]) -> list[Row]:
    """Return rows of measured values, in the order of the first run that has them; `measured` is by label of the run.
    """
    flaws = {label: flaw for label, measures in measured.items() for quantity, flaw in FLAWS.items()
             if any(measure.quantity == quantity and measure.value for measure in measures)}
    values: dict[tuple[str, str, float | None, str], dict[str, float]] = {}
    for label, measures in measured.items():
        for measure in (measure for measure in measures if measure.of):   # its ending describes the whole run
            values.setdefault((measure.quantity, measure.of, measure.time, measure.unit), {})[label] = measure.value
    return [Row(*key, by_label, flaws) for key, by_label in values.items()]


def summary(rows: Sequence[Row]) -> list[Row]:
    """The rows of whole runs, and of those about steps the largest value over all steps of an axis."""
    groups: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        if row.time is not None:
            groups.setdefault((row.quantity, row.of, row.unit), []).append(row)
    worst = []
    for (quantity, of, unit), steps in groups.items():
        labels = dict.fromkeys(label for step in steps for label in step.values)
        largest = {label: max(step.values[label] for step in steps if label in step.values) for label in labels}
        worst.append(Row(quantity, of, None, unit, largest, steps[0].flaws, len(steps)))
    return [*(row for row in rows if row.time is None), *worst]


def times_larger(times: float) -> str:
    """Return how much larger one value is than another; a dash if it is not, or the ratio is undefined."""
    return ("–" if times in (1.0, inf) else f"{100.0 * (times - 1.0):.2g} % larger" if times < 2.0 else
            f"{times:.2g} times as large" if times < 100.0 else
            f"{times:.0f} times as large" if times < 1000.0 else "over 1000 times as large")


def comparison_verdict(runs: Mapping[str, RunResult], rows: Sequence[Row]) -> str:
    """Return a sentence with the better run: the one that is the best in most rows about axes.

    Rows are those of the summary. Runs are alike if they are so in most of these rows. Then come the rows in which each
    is better, also about motors, and the ends of the other runs.
    """
    ours = [label for label, run in runs.items() if run.outcome == "completed"]
    others = [f"{label} {run.ending}" for label, run in runs.items() if label not in ours]
    if len(ours) < 2:
        said = f"{'Only ' if others else ''}{ours[0]} completed" if ours else "No run completed"
        return "; ".join([said, *others]) + "."
    shared = [row for row in rows if set(ours) <= row.values.keys()]
    judged = [row for row in shared if any(row.of in runs[label].plan.axes for label in ours)]
    if not judged:
        return "; ".join([f"{in_words(ours)} completed", *others]) + "."
    won = {label: [row for row in judged if label in row.best] for label in ours}
    order = sorted(filter(won.get, ours), key=lambda label: -len(won[label]))
    places = [f"{len(won[label])}{leading(label, ours, won[label])}" for label in order]
    better, about = "better" if len(ours) == 2 else "best", f"of {in_rows(judged)} about axes"
    alike = sum(not row.best for row in judged)
    parts = [f"{label} in {place}" for label, place in zip(order, places, strict=True)]
    if 2 * alike > len(judged):
        parts = [f"{in_words(ours)} are equal in {alike} {about}",
                 *(f"{label} is {better} in {place}" for label, place in zip(order, places, strict=True))]
    elif len(order) > 1 and len(won[order[0]]) == len(won[order[1]]):
        parts[0] = f"No run leads: {about} {order[0]} is {better} in {places[0]}"
    else:
        parts[0] = f"{order[0]} is {better} in {len(won[order[0]])} {about}{leading(order[0], ours, won[order[0]])}"
    efforts = [row for row in shared if any(row.of in runs[label].plan.motors for label in ours)]
    counts = {label: sum(label in row.best for row in efforts) for label in ours}
    if any(counts.values()):
        parts.append(f"of {in_rows(efforts)} about motors " + ", ".join(
            f"{label} is {better} in {count}" for label, count in counts.items() if count))
    return "; ".join([*parts, *others]) + "."


def in_words(labels: Sequence[str]) -> str:
    """Labels as a list in a sentence."""
    return " and ".join(filter(None, (", ".join(labels[:-1]), labels[-1])))


def in_rows(rows: Sequence[Row]) -> str:
    """Number of rows, such as "1 row"."""
    return f"{len(rows)} row{'s' if len(rows) != 1 else ''}"


def leading(label: str, labels: Sequence[str], won: Sequence[Row]) -> str:
    """Return where a run leads most over the next one, in parentheses, among the rows in which it is the best."""
    if not won:
        return ""
    # A metric that is 0 in one run has no lead in proportion; a metric that never ends in another has the largest.
    most = max(won, key=lambda row: row.lead if row.least else 1.0)
    other = min((rival for rival in labels if rival not in most.best), key=most.values.__getitem__)
    return f" (most in {most.name} of {most.of}, {most.text(label)} against {most.text(other)})"


def legend(runs: Iterable[RunResult], sign: str) -> str:
    """Return the meaning of a table's marks: a run that did not complete wins nothing, nor does one alone."""
    held = sum(run.outcome == "completed" for run in runs)
    return "Less is better; " + (f"the best of the runs that completed has a {sign}, unless they differ by less "
                                 "than 5 %" if held > 1 else "a best value is marked if at least two runs "
                                 "completed")
