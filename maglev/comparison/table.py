"""What was measured on several runs, side by side, with the best of each row."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import exp, fsum, inf, log

from maglev.experiment.execution import RunResult
from maglev.judging.measures import Measure
from maglev.judging.verdicts import DIFFERENCE
from maglev.quantities import metric_text
from maglev.report.status import troubles
from maglev.report.text import state_of

TINY = 1e-15   # m, below which an error is none


@dataclass(frozen=True)
class Row:
    """One quantity of several runs; of every one, less is better. Quantity, of, time and unit are as of `Measure`."""

    quantity: str
    of: str
    time: float | None
    unit: str
    values: Mapping[str, float]              # SI, by label of the run; one on which it was not measured is left out
    failed: frozenset[str] = frozenset()     # labels of runs that touched a stop, tripped or ended far off: no winners
    steps: int = 0                           # over which the largest value was taken; 0 if it is of one alone

    @property
    def held(self) -> dict[str, float]:
        """Values of the completed runs, SI, by label."""
        return {label: value for label, value in self.values.items() if label not in self.failed}

    @property
    def least(self) -> float:
        """Least value of the completed runs, SI."""
        return min(self.held.values(), default=0.0)

    @property
    def best(self) -> tuple[str, ...]:
        """Labels of the least value among the completed runs, and of those that are alike; none if all are."""
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
        """How many times the best value the next one of a completed run is; 1 where none is the best."""
        others = [value for value in self.held.values() if value > DIFFERENCE * self.least]
        return 1.0 if not others else min(others) / self.least if self.least else inf

    @property
    def ahead(self) -> str:
        """The same in words, behind "the next is"; a dash where none is the best."""
        return times_larger(self.lead).removesuffix(" as large")

    def text(self, label: str) -> str:
        """Value of a run with its unit."""
        return metric_text(self.quantity, self.values[label], self.unit) if label in self.values else "–"


def measure_rows(measured: Mapping[str, Sequence[Measure]]) -> list[Row]:
    """Rows of what was measured, in the order of the first run that has it; `measured` is by label of the run."""
    failed = frozenset(label for label, measures in measured.items()
                       if any(measure.quantity == "failed" and measure.value for measure in measures))
    values: dict[tuple[str, str, float | None, str], dict[str, float]] = {}
    for label, measures in measured.items():
        for measure in (measure for measure in measures if measure.of):   # of the whole run it is said how it ended
            values.setdefault((measure.quantity, measure.of, measure.time, measure.unit), {})[label] = measure.value
    return [Row(*key, by_label, failed) for key, by_label in values.items()]


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
        worst.append(Row(quantity, of, None, unit, largest, steps[0].failed, len(steps)))
    return [*(row for row in rows if row.time is None), *worst]


def times_larger(times: float) -> str:
    """How much larger one value is than another; a dash where it is not, or cannot be said."""
    return ("–" if times in (1.0, inf) else f"{100.0 * (times - 1.0):.2g} % larger" if times < 2.0 else
            f"{times:.2g} times as large" if times < 100.0 else
            f"{times:.0f} times as large" if times < 1000.0 else "over 1000 times as large")


def ending(run: RunResult) -> str:
    """How a run ended, in a line."""
    if run.metrics is None:
        return ", ".join(troubles(run))
    return ", ".join([state_of(run.metrics), *troubles(run)])


def comparison_verdict(runs: Mapping[str, RunResult], rows: Sequence[Row]) -> str:
    """One sentence: which run is the better one, by its rms errors, by how much, and in what another one is better.

    Rows are those of the summary. Of completed runs; that others failed comes last, or decides.
    """
    ours = [label for label, run in runs.items() if run.metrics is not None and not run.metrics.failed]
    others = [f"{label} {ending(run)}" for label, run in runs.items() if label not in ours]
    if len(ours) < 2:
        said = f"{'Only ' * bool(others)}{ours[0]} completed" if ours else "None completed"
        return "; ".join([said, *others]) + "."
    errors = [row for row in rows if row.quantity == "rms error" and set(ours) <= row.values.keys()]
    mean = {label: fsum(log(max(row.values[label], TINY)) for row in errors) / max(len(errors), 1) for label in ours}
    best, second = sorted(ours, key=mean.__getitem__)[:2]
    times = exp(mean[second] - mean[best])
    if times < DIFFERENCE:
        said = (f"{best} and {second} are alike: their rms errors differ by less than 5 %" if errors else
                f"{' and '.join(ours)} completed")
    else:
        most = max(errors, key=lambda row: row.values[second] / max(row.values[best], TINY))
        said = (f"{best} is {'better' if len(ours) == 2 else 'best'}: the rms errors of {second} are on average "
                f"{times_larger(times)} (most on {most.of}, {most.text(best)} against {most.text(second)})")
    parts = [said]
    for label in ours if times < DIFFERENCE else [label for label in ours if label != best]:
        rival = best if label != best else second
        won = [row for row in rows if label in row.best and rival not in row.best and rival in row.values]
        if won:
            top = max(won, key=lambda row: row.lead)
            parts.append(f"{label} is better in {len(won)} of {len(rows)} rows" + (
                f" (most in {top.quantity} of {top.of}, {top.text(label)} against {top.text(rival)})"
                if len(ours) == 2 else ""))
    return "; ".join([*parts, *others]) + "."


def legend(runs: Iterable[RunResult], sign: str) -> str:
    """What a table says of its marks: one has to complete to win, and against another that completed."""
    held = sum(run.metrics is not None and not run.metrics.failed for run in runs)
    return "Less is better; " + (f"the best of the completed runs has a {sign}, unless they differ by less than 5 %"
                                 if held > 1 else
                                 "a best value is marked where at least two runs completed")
