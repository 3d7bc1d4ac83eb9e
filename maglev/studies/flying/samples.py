"""Samples of a study flown one after the other in one process, on one instance of each FMU, reset between."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from math import nan
from typing import NamedTuple

import numpy as np

from maglev.arrays import Array
from maglev.errors import MaglevError, in_one_line
from maglev.experiment.preparation import Experiment
from maglev.judging.metrics import evaluate, phase_resistances
from maglev.studies.columns import Column, named_values
from maglev.studies.flying.flight import Flight
from maglev.studies.targets import Target


@dataclass(frozen=True)
class Job:
    """What every batch of a study has in common."""

    key: str                     # of the study: SHA-256 of all that its result depends on
    code: str                    # of the package that plans it, see `code_of_package`
    experiment: Experiment       # its files are those of the machine that plans the study
    targets: tuple[Target, ...]
    columns: tuple[Column, ...]
    kept: tuple[str, ...] = ()   # signals whose trajectories are kept
    every: int = 1               # communication steps between two rows of these
    # Longest wall time of a sample, s, each then being flown in a process beside the worker.
    limit: float | None = None


@dataclass(frozen=True)
class Flown:
    """A batch that was flown."""

    first: int                          # number of its first sample
    # Metrics, SI, shape (samples, columns); NaN where a sample was not flown to its end, or has no such metric.
    values: Array
    failures: tuple[str | None, ...]    # why a sample was not flown to its end
    trajectories: Array | None = None   # shape (samples, rows, signals)


class Sample(NamedTuple):
    """One sample that was flown: its metrics, shape (columns,), why it was not flown to its end, and what is kept.

    Trajectories have the shape (rows, signals).
    """

    values: Array
    failure: str | None = None
    trajectories: Array | None = None


def failed(job: Job, why: str) -> Sample:
    """A sample that was not flown to its end."""
    return Sample(np.full(len(job.columns), nan), why)


def each_flown(job: Job, values: Array, loaded: Callable[[], None] | None = None) -> Iterator[Sample]:
    """Fly samples in this process, with values of the targets, shape (samples, targets).

    `loaded` is called when the FMUs are loaded.
    """
    plan = job.experiment.plan
    with Flight(job.experiment) as flight:
        flight.load()   # what fails here is no sample's fault
        if loaded is not None:
            loaded()
        for sample in values.tolist():
            changes = {target.name: bool(value) if target.boolean else value
                       for target, value in zip(job.targets, sample, strict=True)}
            try:
                time, columns = flight.fly(changes)
                found = named_values(plan, evaluate(plan, time, columns, phase_resistances(plan, changes)))
            except MaglevError as error:
                yield failed(job, in_one_line(error))
                continue
            row = np.array([found.get(column.name, (nan, ""))[0] for column in job.columns])
            yield Sample(row, None, np.column_stack([columns[name][::job.every] for name in job.kept])
                         if job.kept else None)


def gathered(job: Job, first: int, count: int, samples: Iterable[Sample]) -> Flown:
    """A batch of so many samples from the number `first` on; a sample that fails has a row that says why."""
    rows = np.full((count, len(job.columns)), nan)
    failures: list[str | None] = []
    kept = None
    for row, sample in enumerate(samples):
        rows[row] = sample.values
        failures.append(sample.failure)
        if sample.trajectories is not None:
            if kept is None:
                kept = np.full((count, *sample.trajectories.shape), nan)
            kept[row] = sample.trajectories
    return Flown(first, rows, tuple(failures), kept)
