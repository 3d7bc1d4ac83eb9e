"""A tuning made ready: its unknowns and its cost; every error of its file is found before a run."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError
from maglev.linear.design import gains_of
from maglev.many.sample_key import study_key
from maglev.many.samples import Job
from maglev.many.study_columns import FLAWS, Column, columns_of, metric_names, named_values
from maglev.many.study_design import samples
from maglev.many.study_file import StudyFile, Varied
from maglev.many.study_plan import job_of, require_alone
from maglev.many.study_targets import Target, target_values, targets_of
from maglev.many.tuning_file import TuneFile
from maglev.runs.execution import expected
from maglev.runs.preparation import Experiment

REFUSED = 1e6          # cost of a candidate that breaks a limit: more than any that meets all
SMALLEST = 1e-6        # by which an excess is divided at least
LARGEST_EXCESS = 1.0   # that one metric of one run counts

DIGITS = 5   # of the parameters that are run, and written: those of the published gains, and one more


@dataclass(frozen=True)
class Cost:
    # Metrics with their limits; the first are the flaws, which every tuning limits.
    columns: tuple[Column, ...]
    minimised: tuple[int, ...]          # numbers of columns
    # By number of a column: how many times what it is with the scenario's own values it may be.
    times_before: Mapping[int, float]
    over: str                           # "worst" or "mean" of the plants

    def excess(self, metrics: Array, before: Array) -> Array:
        """Return how far runs are beyond the limits, 0 if within all, shape (candidates, plants).

        `metrics` has the shape (candidates, plants, columns), NaN where a sample was not completed; `before`,
        those with the scenario's own values, (plants, columns).
        """
        lows, highs = (np.array([getattr(column, end) for column in self.columns]) for end in ("min", "max"))
        highs = np.broadcast_to(highs, before.shape).copy()
        for column, times in self.times_before.items():
            highs[:, column] = np.minimum(highs[:, column], times * before[:, column])
        with np.errstate(invalid="ignore"):   # of infinite limits, and of metrics without an end
            beyond = np.fmax((metrics - highs) / np.maximum(np.abs(highs), SMALLEST),
                             (lows - metrics) / np.maximum(np.abs(lows), SMALLEST))
        beyond = np.where(np.isnan(beyond), 0.0, beyond)
        beyond[np.isnan(metrics)] = LARGEST_EXCESS
        # A minimised time that never ends, such as settling, is beyond all limits.
        minimised = list(self.minimised)
        beyond[..., minimised] = np.where(np.isfinite(metrics[..., minimised]), beyond[..., minimised], LARGEST_EXCESS)
        return np.asarray(np.clip(beyond, 0.0, LARGEST_EXCESS).sum(axis=-1))

    def of(self, metrics: Array, before: Array) -> Array:
        """Cost of each candidate, shape (candidates,); see `excess` for the arguments.

        Among candidates that break limits, the one that breaks them less costs less (Deb's rules).
        """
        excess = self.excess(metrics, before).mean(axis=1)
        largest = metrics[..., list(self.minimised)].max(axis=-1)
        with np.errstate(invalid="ignore"):
            cost = largest.max(axis=1) if self.over == "worst" else largest.mean(axis=1)
        return np.asarray(np.where(excess > 0.0, REFUSED * (1.0 + excess), cost))


def placed_gains(numbers: Iterable[float], omega0: float) -> list[float]:
    """Gains k1…k5 that place a real pole and two pairs, see `Poles`; `omega0` is that of the internal model, rad/s."""
    real, rate1, damping1, rate2, damping2 = numbers
    polynomial = np.polymul([1.0, real], np.polymul([1.0, 2.0 * damping1 * rate1, rate1 * rate1],
                                                    [1.0, 2.0 * damping2 * rate2, rate2 * rate2]))
    return list(gains_of(polynomial.tolist(), omega0))


@dataclass(frozen=True)
class Unknowns:
    """All that a search looks for: numbers of poles, of which each of their axes gets k1…k5, then plain ones."""

    tuning: TuneFile
    omega0: Mapping[str, float]   # rad/s, of the internal models by FMU

    @property
    def entries(self) -> dict[str, list[Varied]]:
        """Return the unknowns as entries of a study: any gains for poles, otherwise numbers in their units."""
        return {"poles": [Varied.model_construct(set=[f"{axis}.k{i}" for axis in poles.of for i in range(1, 6)],
                                                 kind="list") for poles in self.tuning.poles],
                "search": [Varied.model_construct(kind="uniform", **dict(searched)) for searched in self.tuning.search]}

    @property
    def names(self) -> list[str]:
        """Names of the parameters, `fmu.variable`."""
        return [name for entries in self.entries.values() for entry in entries for name in entry.set]

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """Ends of the ranges of the numbers."""
        ranges = [*(one for poles in self.tuning.poles for one in (
            poles.rate, poles.rate, poles.damping, poles.rate, poles.damping)), *self.tuning.search]
        return [(float(one.low.value), float(one.high.value)) for one in ranges]

    def parameters(self, numbers: Array) -> Array:
        """Return the parameters for numbers of a search, shape (number of bounds,), rounded as they are written."""
        waiting, values = iter(numbers.tolist()), list[float]()
        for poles in self.tuning.poles:
            values += placed_gains(islice(waiting, 5), self.omega0[poles.of[0].partition(".")[0]]) * len(poles.of)
        for searched in self.tuning.search:
            values += [next(waiting)] * len(searched.set)
        return np.array([float(f"{value:.{DIGITS}g}") for value in values])


@dataclass(frozen=True)
class PlannedTuning:
    """A tuning that can be searched."""

    tuning: TuneFile
    job: Job         # its targets are the varied parameters of the plants, then the searched parameters
    unknowns: Unknowns
    cost: Cost
    nominal: Array   # values of the searched parameters in the scenario itself, shape (number searched,)
    plants: Array    # shape (plants, number that the plants vary)
    fresh: Array     # likewise, those that were not searched with

    def values(self, candidates: Array, plants: Array) -> Array:
        """Values of the targets, shape (candidates · plants, targets), of candidates with their parameters."""
        return np.hstack([np.tile(plants, (len(candidates), 1)), np.repeat(candidates, len(plants), axis=0)])


def plan_tuning(tuning: TuneFile, experiment: Experiment, origin: str) -> PlannedTuning:
    """Plan a tuning; MaglevError, with `origin`, the file, if something in it cannot be used, or is out of range."""
    descriptions, plan = experiment.check(), experiment.plan
    require_alone(experiment, tuning.scenario, origin)
    omega0 = {name: experiment.start_value(f"{name}.omega0", descriptions) for name in descriptions
              if any(variable.name == "omega0" for variable in descriptions[name].modelVariables)}
    for axis in (axis for poles in tuning.poles for axis in poles.of):
        if axis.partition(".")[0] not in omega0:
            raise ScenarioError(f"{origin}: poles.of = {axis!r}: expected an axis of an output regulator, such as "
                                "'controller.x'")
    unknowns = Unknowns(tuning, omega0)
    for name, times in Counter([*(name for entry in tuning.vary for name in entry.set), *unknowns.names]).items():
        if times > 1:
            raise ScenarioError(f"{origin}: {name} is set twice, expected to be searched, or to vary, once")
    varied = targets_of(tuning.vary, experiment, origin)
    searched = [target for key, entries in unknowns.entries.items()
                for target in targets_of(entries, experiment, origin, key)]
    ends = np.array([unknowns.parameters(np.array(end)) for end in zip(*unknowns.bounds, strict=True)])
    target_values([replace(target, column=i) for i, target in enumerate(searched)], ends, origin)
    known = named_values(plan, expected(experiment))
    columns = columns_of(known, [*tuning.minimise, *tuning.times_before], tuning.limits, origin)
    columns = [replace(column, max=0.0) if column.name in FLAWS else column for column in columns]
    cost = Cost(tuple(columns), column_numbers(columns, known, tuning.minimise, origin),
                {i: times for name, times in tuning.times_before.items()
                 for i in column_numbers(columns, known, [name], origin)}, tuning.over)
    plants = plants_of(tuning.plants(), varied, origin)
    fresh = plants_of(tuning.plants(tuning.fresh, tuning.design.seed + 1), varied, origin) if tuning.fresh else plants
    job = job_of(experiment, [*varied, *searched], columns, None, origin)
    nominal = np.array([target.nominal for target in searched])
    return PlannedTuning(tuning, replace(job, key=study_key(job, plants)), unknowns, cost, nominal, plants, fresh)


def column_numbers(columns: list[Column], known: dict[str, tuple[float, str]], asked: list[str],
                   origin: str) -> tuple[int, ...]:
    names = [column.name for column in columns]
    return tuple(names.index(name) for pattern in asked for name in metric_names(known, pattern, origin))


def plants_of(study: StudyFile | None, targets: list[Target], origin: str) -> Array:
    """Return the varied values of the plants; one plant without any if nothing varies."""
    return np.empty((1, 0)) if study is None else target_values(targets, samples(study), origin)
