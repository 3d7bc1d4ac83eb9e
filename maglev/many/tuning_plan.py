"""A tuning: its TOML file, and its unknowns and its cost; every error of the file is found before a run.

The file has the searched parameters, the minimised metrics, their limits, and the plants.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError
from maglev.files.toml_file import read_toml
from maglev.files.units import measures
from maglev.linear.design import gains_of
from maglev.many.sample_key import study_key
from maglev.many.samples import Job
from maglev.many.study_columns import FLAWS, Column, columns_of, metric_names, named_values
from maglev.many.study_design import Target, samples, target_values, targets_of
from maglev.many.study_file import LISTED, Count, Quantity, Repetition, Seed, StudyFile, Varied, file_for, read_study
from maglev.many.study_plan import job_of, require_alone
from maglev.runs.execution import expected
from maglev.runs.preparation import Experiment
from maglev.scenario.layers import PACKAGED, Layer
from maglev.scenario.toml_table import Table, key_refused

FOLDER = PACKAGED / "tuning"   # those that come with the package

REFUSED = 1e6          # cost of a candidate that breaks a limit: more than any that meets all
SMALLEST = 1e-6        # by which an excess is divided at least
LARGEST_EXCESS = 1.0   # that one metric of one run counts

DIGITS = 5   # of the parameters that are run, and written: those of the published gains, and one more


class Range(Table):
    low: Quantity
    high: Quantity

    @model_validator(mode="after")
    def not_empty(self) -> "Range":
        if not self.low.value < self.high.value:
            raise key_refused("high", self.high.written, f"expected more than low = {self.low.written}")
        return self


class Poles(Table):
    """Axes of an output regulator whose gains k1…k5 are searched together, by the poles that they place.

    One real pole at −rate, and two pairs with s² + 2 damping · rate · s + rate²; a pair with a damping above 1 is two
    real poles.
    """

    of: Annotated[list[str], Field(min_length=1)]   # "controller.x"
    rate: Range      # 1/s or rad/s
    damping: Range

    @model_validator(mode="after")
    def stable(self) -> "Poles":
        """Refuse poles that are not on the left, and other units."""
        for key, ends, units in (("rate", self.rate, ("1/s", "rad/s")), ("damping", self.damping, ())):
            for end, given in (("low", ends.low), ("high", ends.high)):
                if given.unit is not None and not any(measures(given.unit, unit) for unit in units):
                    raise key_refused(end, given.written, f"expected {' or '.join(units) or 'a plain number'}", key)
            if not ends.low.value > 0.0:
                raise key_refused("low", ends.low.written, "expected more than 0", key)
        return self


class Searched(Range):
    """One or several parameters that take one value, which is searched."""

    set: Annotated[list[str], Field(min_length=1)]


class TuneFile(Repetition):
    """A tuning: the scenario, searched parameters, minimised metrics, limits, and plants.

    `minimise` are metrics of a study. The largest value of a run counts, and the worst or the mean of the plants.
    `times_before` limits metrics, on every plant, to multiples of their values with the scenario's own parameters.
    """

    minimise: Annotated[list[str], Field(min_length=1)]
    over: Literal["worst", "mean"] = "worst"
    times_before: dict[str, Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]] = {}
    poles: list[Poles] = []
    search: list[Searched] = []
    vary: list[Varied] = []
    population: Annotated[Count, Field(ge=5)] = 30
    generations: Count = 20
    seed: Seed = 0
    fresh: Annotated[int, Field(strict=True, ge=0)] = 0   # plants that were not searched with

    @model_validator(mode="after")
    def something_to_search(self) -> "TuneFile":
        """Refuse a file that searches nothing, or asks for fresh plants where there is but a grid of them."""
        if not self.poles and not self.search:
            raise key_refused("poles", None, "required key is missing: expected [[poles]] or [[search]]")
        if self.fresh and (not self.vary or self.design.kind in (*LISTED, "saltelli")):
            raise key_refused("fresh", self.fresh, "expected [[vary]] with a [design] of kind latin hypercube, sobol "
                              "or halton")
        if self.design.kind == "sobol" and self.fresh & (self.fresh - 1):
            raise key_refused("fresh", self.fresh, "expected a power of 2, as Sobol's sequence needs")
        return self

    def plants(self, samples: int | None = None, seed: int | None = None) -> StudyFile | None:
        """Study of the plants, with another number of samples and another seed if given; None if nothing varies."""
        design = self.design if samples is None else self.design.model_copy(update={"samples": samples, "seed": seed})
        return StudyFile(name=self.name, scenario=self.scenario, vary=self.vary, design=design) if self.vary else None


def load_tuning(name_or_path: str | Path) -> tuple[TuneFile, Path]:
    """Read a tuning file of the package by its name, or any other by its path; ScenarioError if it cannot be used."""
    path = file_for(name_or_path, FOLDER, "tuning file")
    return read_tuning(read_toml(path), path), path


def read_tuning(table: Mapping[str, Any], path: Path) -> TuneFile:
    """Return the tuning of a table; `path` is the file that errors name."""
    tuning = TuneFile.of_file(table, [Layer(path, dict(table))])
    if tuning.vary:   # what a study refuses of its design
        read_study({key: table[key] for key in ("name", "scenario", "vary", "design") if key in table}, path)
    return tuning


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
