"""The search: differential evolution, whose generations are run side by side; and its result as text."""

import hashlib
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from io import BytesIO
from typing import Any

import numpy as np
from rich.console import Console
from scipy.optimize import Bounds, differential_evolution
from scipy.stats import qmc

from maglev.files.arrays import Array
from maglev.files.console import ResultTable, heading
from maglev.files.errors import (
    Interrupted,
    MaglevError,
    ScenarioError,
    ended_by,
    in_one_line,
    key_path,
    option,
    quoted,
    signal_of,
)
from maglev.files.side_by_side import Progress, Say
from maglev.many.batches import RunBatches, batches_of
from maglev.many.samples import BatchResult
from maglev.many.study_columns import FLAWS, OF_EVERY_RUN
from maglev.many.study_parts import Parts
from maglev.many.tuning_plan import Cost, PlannedTuning, TuneFile
from maglev.scenario.quantities import metric_text


@dataclass(frozen=True)
class SearchResult:
    parameters: dict[str, float]   # by `fmu.variable`, SI, rounded as they were run
    numbers: tuple[float, ...]     # what was searched: of poles the rates and dampings
    cost_before: float             # with the scenario's own values
    cost: float
    before: Array                  # metrics on the plants that were searched with, shape (plants, columns)
    after: Array
    fresh_before: Array            # on plants that were not, shape (fresh plants, columns)
    fresh_after: Array
    runs: int                   # number that were run


@dataclass
class Search:
    """A planned tuning; `parts` keep the metrics of all runs by their parameters."""

    planned: PlannedTuning
    run_batches: RunBatches
    parts: Parts
    watch: Progress
    runs: int = 0
    failure: str | None = None   # why the last one that was not completed was not

    @property
    def all_runs(self) -> int:
        tuning, planned = self.planned.tuning, self.planned
        return (len(planned.plants) * (tuning.population * (tuning.generations + 1) + 2)
                + 2 * len(planned.fresh) * (tuning.fresh > 0))

    def metrics(self, candidates: Array, plants: Array) -> Array:
        """Metrics, shape (candidates, plants, columns), of candidates with their parameters."""
        values = self.planned.values(candidates, plants)
        kept = f"runs-{hashlib.sha256(values.tobytes()).hexdigest()}.npy"
        if kept in self.parts.files:
            self.runs += len(values)
            return np.asarray(np.load(BytesIO(self.parts.read(kept)))).reshape(len(candidates), len(plants), -1)
        rows = np.full((len(values), len(self.planned.job.columns)), np.nan)

        def store(result: BatchResult) -> None:
            rows[result.first:result.first + len(result.values)] = result.values
            self.failure = next(filter(None, result.failures), self.failure)
            self.runs += len(result.values)
            self.watch(min(self.runs, self.all_runs - 1), self.all_runs)

        job = replace(self.planned.job, ahead=self.all_runs)
        self.run_batches(job, batches_of(job, len(values), 0), values, store)
        content = BytesIO()
        np.save(content, rows)
        self.parts.write(kept, content.getvalue())
        return rows.reshape(len(candidates), len(plants), -1)

    def run(self) -> SearchResult:
        """Search, and run the result on fresh plants."""
        planned, tuning = self.planned, self.planned.tuning
        before, = self.metrics(planned.nominal[None, :], planned.plants)
        if np.isnan(before[:, 0]).all():   # even `failed`
            raise MaglevError(f"{tuning.name}: with the scenario's own values no run is completed"
                              + (f": {self.failure}" if self.failure else ""))

        def costs(numbers: Array, /) -> Any:
            candidates = np.array([planned.unknowns.parameters(column) for column in numbers.T])
            return planned.cost.of(self.metrics(candidates, planned.plants), before)

        lows, highs = np.array(planned.unknowns.bounds).T
        first = lows + (highs - lows) * qmc.LatinHypercube(len(lows), rng=tuning.seed).random(tuning.population)
        result = differential_evolution(costs, Bounds(lows, highs), init=first, maxiter=tuning.generations, tol=0.0,
                                        atol=0.0, polish=False, vectorized=True, updating="deferred", rng=tuning.seed)
        parameters = planned.unknowns.parameters(result.x)
        after, = self.metrics(parameters[None, :], planned.plants)
        both = np.array([planned.nominal, parameters])
        fresh_before, fresh_after = self.metrics(both, planned.fresh) if tuning.fresh else (before, after)
        self.watch(self.all_runs, self.all_runs)
        cost_before, cost = planned.cost.of(np.array([before, after]), before)
        return SearchResult(dict(zip(planned.unknowns.names, parameters.tolist(), strict=True)),
                            tuple(result.x.tolist()), float(cost_before), float(cost), before, after, fresh_before,
                            fresh_after, self.runs)


def search(planned: PlannedTuning, parts: Parts, who: Callable[[], AbstractContextManager[RunBatches]], resume: bool,
           watch: Progress, say: Say) -> SearchResult:
    """Search, with the samples run by `who`; see `run_study` for errors and for `say`.

    While it continues, the folder of `parts` holds every finished generation. A resumed search takes the same course
    again, and runs only the missing generations.
    """
    with parts.alone():
        others = parts.find()
        if parts.folder.exists() and not resume:
            raise ScenarioError(f"{parts.folder}: a part is done: continue with {option('resume', True)}, or remove "
                                "the folder")
        if others:
            say(f"{parts.folder}: {others} of the parts are changed and run again")
        try:
            with who() as run_batches:
                parts.begin()
                result = Search(planned, run_batches, parts, watch).run()
        except KeyboardInterrupt as error:
            raise Interrupted(f"{ended_by(error)}: finished generations are kept in {parts.folder}, "
                              f"{option('resume', True)} continues with them", signal_of(error)) from error
        parts.remove()
    return result


def gains_toml(tuning: TuneFile, result: SearchResult) -> str:
    """Return the best parameters as a file that a scenario extends."""
    lines = [f"# {in_one_line(line)}" for line in (tuning.title or tuning.name, f"Found by maglev tune {tuning.name}: "
                                      f"{tuning.population} candidates, {tuning.generations} generations, "
                                      f"{result.runs} runs of {tuning.scenario}.")]
    by_fmu: dict[str, list[str]] = {}
    for name, value in result.parameters.items():
        fmu, _, own = name.partition(".")
        by_fmu.setdefault(fmu, []).append(f"{quoted(own)} = {value!r}")
    for fmu, entries in by_fmu.items():
        lines += ["", f"[{key_path(['fmus', fmu, 'start'])}]", *entries]
    return "\n".join(lines) + "\n"


def show_result(console: Console, tuning: TuneFile, cost: Cost, result: SearchResult) -> None:
    """Print the metrics before and after, on the plants of the search and on fresh ones, and the parameters."""
    console.print(heading(tuning.name, tuning.title or tuning.scenario))
    groups = [(f"the {len(result.before)} plants of the search", result.before, result.after)]
    if tuning.fresh:
        groups.append((f"{len(result.fresh_before)} other plants", result.fresh_before, result.fresh_after))
    for title, before, after in groups:
        heads = ("median before", "after", "largest before", "after", "never settled before", "after", "lower on")
        console.print(ResultTable(title, ("metric", *heads), (
            row(column.name, before[:, i], after[:, i], column.unit) for i, column in enumerate(cost.columns)
            if column.name not in OF_EVERY_RUN or column.name in FLAWS)))
        within = percent((cost.excess(after[None], before) == 0.0).mean())
        console.print(f"{within} of the plants are within all limits", highlight=False)
    console.print(", ".join(f"{name} = {value:g}" for name, value in result.parameters.items()), highlight=False)


def row(name: str, before: Array, after: Array, unit: str) -> list[str]:
    """Row of a metric: name, medians, largest finite values, and the shares of plants without one, and with less."""
    cells = [metric_text(name, summary(values), unit) for summary in (median, largest) for values in (before, after)]
    shares = [percent(np.mean(share)) for share in (~np.isfinite(before), ~np.isfinite(after), after < before)]
    return [name, *cells, *shares]


def percent(share: float | np.floating[Any]) -> str:
    return f"{100.0 * share:.0f} %"


def median(values: Array) -> float:
    """Return the median over the plants; infinite if half of them never settle."""
    return float(np.quantile(np.where(np.isnan(values), np.inf, values), 0.5, method="higher"))


def largest(values: Array) -> float:
    """Return the largest finite value; minus infinity if there is none."""
    return float(np.max(values[np.isfinite(values)], initial=-np.inf))
