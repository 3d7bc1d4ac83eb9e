"""Samples of a study flown one after the other in one process, on one instance of each FMU, reset between."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from math import nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maglev.errors import MaglevError, in_one_line
from maglev.experiment.preparation import Experiment
from maglev.judging.metrics import evaluate
from maglev.judging.windings import phase_resistances
from maglev.studies.columns import Column, named_values
from maglev.studies.flying.flight import Flight
from maglev.studies.targets import Target

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Job:
    """What every batch of a study has in common.

    Attributes
    ----------
    key : str
        Of the study: SHA-256 of all that its result depends on.
    code : str
        Of the package that plans it, see `code_of_package`.
    experiment : Experiment
        Its files are those of the machine that plans the study.
    targets : tuple of Target
    columns : tuple of Column
    kept : tuple of str
        Signals whose trajectories are kept.
    every : int
        Communication steps between two rows of these.
    limit : float or None
        Longest wall time of a sample, s, each then being flown in a process beside the worker.
    """

    key: str
    code: str
    experiment: Experiment
    targets: tuple[Target, ...]
    columns: tuple[Column, ...]
    kept: tuple[str, ...] = ()
    every: int = 1
    limit: float | None = None


@dataclass(frozen=True)
class Flown:
    """A batch that was flown.

    Attributes
    ----------
    first : int
        Number of its first sample.
    values : ndarray, shape (samples, columns)
        Metrics, SI; NaN where a sample was not flown to its end, or has no such metric.
    failures : tuple of str or None
        Why a sample was not flown to its end.
    trajectories : ndarray, shape (samples, rows, signals), or None
    """

    first: int
    values: Array
    failures: tuple[str | None, ...]
    trajectories: Array | None = None


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
    """Fly samples in this process.

    Parameters
    ----------
    job : Job
    values : ndarray, shape (samples, targets)
        Of the targets.
    loaded : callable, optional
        Called when the FMUs are loaded.
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
