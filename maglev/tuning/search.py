"""The search: differential evolution, whose generations are run side by side."""

import hashlib
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np
from scipy.optimize import Bounds, differential_evolution
from scipy.stats import qmc

from maglev.arrays import Array
from maglev.errors import Interrupted, MaglevError, ScenarioError, name_of, option, signal_of
from maglev.processes.side_by_side import Progress, Say
from maglev.studies.flying.batches import Fly, batches_of
from maglev.studies.flying.samples import Flown
from maglev.studies.parts import Parts
from maglev.tuning.planning import PlannedTuning


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
    flights: int                   # number that were run


class Search:
    """A planned tuning; `parts` keep the metrics of all runs by what was run."""

    def __init__(self, planned: PlannedTuning, fly_batches: Fly, parts: Parts, watch: Progress):
        self.planned = planned
        self.fly_batches = fly_batches
        self.parts = parts
        self.watch = watch
        self.flights = 0
        self.failure: str | None = None   # why the last one that was not completed was not
        tuning = planned.tuning
        self.all_flights = (len(planned.plants) * (tuning.population * (tuning.generations + 1) + 2)
                            + 2 * len(planned.fresh) * (tuning.fresh > 0))

    def fly(self, candidates: Array, plants: Array) -> Array:
        """Metrics, shape (candidates, plants, columns), of candidates with their parameters."""
        values = self.planned.values(candidates, plants)
        kept = f"flights-{hashlib.sha256(values.tobytes()).hexdigest()}.npy"
        if kept in self.parts.files:
            self.flights += len(values)
            rows = np.load(BytesIO(self.parts.read(kept)))
            return np.asarray(rows).reshape(len(candidates), len(plants), -1)
        rows = np.full((len(values), len(self.planned.job.columns)), np.nan)

        def store(_: int, flown: Flown) -> None:
            rows[flown.first:flown.first + len(flown.values)] = flown.values
            self.failure = next(filter(None, flown.failures), self.failure)
            self.flights += len(flown.values)
            self.watch(min(self.flights, self.all_flights - 1), self.all_flights)

        self.fly_batches(self.planned.job, batches_of(self.planned.job, len(values), 0), values, store)
        content = BytesIO()
        np.save(content, rows)
        self.parts.write(kept, content.getvalue())
        return rows.reshape(len(candidates), len(plants), -1)

    def run(self) -> SearchResult:
        """Search, and run what was found on fresh plants."""
        planned, tuning = self.planned, self.planned.tuning
        before, = self.fly(planned.nominal[None, :], planned.plants)
        if np.isnan(before[:, 0]).all():   # even `failed`
            raise MaglevError(f"{tuning.name}: with the scenario's own values no run is completed"
                              + (f": {self.failure}" if self.failure else ""))

        def costs(numbers: Array, /) -> Any:
            candidates = np.array([planned.unknowns.parameters(column) for column in numbers.T])
            return planned.cost.of(self.fly(candidates, planned.plants), before)

        lows, highs = np.array(planned.unknowns.bounds).T
        first = lows + (highs - lows) * qmc.LatinHypercube(len(lows), rng=tuning.seed).random(tuning.population)
        result = differential_evolution(costs, Bounds(lows, highs), init=first, maxiter=tuning.generations, tol=0.0,
                                        atol=0.0, polish=False, vectorized=True, updating="deferred", rng=tuning.seed)
        parameters = planned.unknowns.parameters(result.x)
        after, = self.fly(parameters[None, :], planned.plants)
        both = np.array([planned.nominal, parameters])
        fresh_before, fresh_after = self.fly(both, planned.fresh) if tuning.fresh else (before, after)
        self.watch(self.all_flights, self.all_flights)
        cost_before, cost = planned.cost.of(np.array([before, after]), before)
        return SearchResult(dict(zip(planned.unknowns.names, parameters.tolist(), strict=True)),
                            tuple(result.x.tolist()), float(cost_before), float(cost), before, after, fresh_before,
                            fresh_after, self.flights)


def search(planned: PlannedTuning, parts: Parts, who: Callable[[], AbstractContextManager[Fly]], resume: bool,
           watch: Progress, say: Say) -> SearchResult:
    """Search, with the samples run by `who`.

    While it goes on, the folder of `parts` holds every generation that is done: the search takes the same course again,
    and runs what is not there. `say` is told what is broken of it. MaglevError if something cannot be run, another
    process is writing there, or parts are there and `resume` is not asked for; Interrupted after Ctrl-C or SIGTERM;
    what is done is kept.
    """
    with parts.alone():
        others = parts.find()
        if parts.folder.exists() and not resume:
            raise ScenarioError(f"{parts.folder}: a part is done, expected {option('resume', True)} to go on with it, "
                                "or no such folder")
        if others:
            say(f"{parts.folder}: not as it was written: {others} of the parts, run again")
        try:
            with who() as fly_batches:
                parts.begin()
                result = Search(planned, fly_batches, parts, watch).run()
        except KeyboardInterrupt as error:
            raise Interrupted(f"{name_of(error)}: generations that are done are kept in {parts.folder}, "
                              f"{option('resume', True)} goes on with them", signal_of(error)) from error
        parts.remove()
    return result
