"""Samples of a study, run on one instance of each FMU: side by side in lanes, or one after the other."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from ctypes import c_int64
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from math import nan
from typing import NamedTuple

import numpy as np

from maglev.cosim.helper_process import STARTED_WITHIN, checked, other_process
from maglev.cosim.step_loop import LIBRARY
from maglev.files.arrays import Array
from maglev.files.errors import MaglevError, in_one_line
from maglev.files.installed import code
from maglev.files.worker_process import Forged, Gone, Said, Send, Silent
from maglev.many.repeated_run import Changes, RepeatedRun
from maglev.many.study_columns import Column, named_values
from maglev.many.study_design import Target
from maglev.runs.endings import ABORTED, ending, endings
from maglev.runs.measuring import Found, Measuring, Meter, State, run_metrics
from maglev.runs.metrics import ManyMetrics, Metrics
from maglev.runs.preparation import Experiment
from maglev.user.blocks import Variables

LONGEST_OF_DEADLY = 3600.0   # s, of a sample in a batch whose process died, where samples have no limit
ATTEMPTS = 2            # of a sample whose process dies: the first time it may be want of memory


def code_of_package() -> str:
    """Return the version of this package and the SHA-256 of its modules, which differs between unreleased states."""
    return f"{version('maglev-fmus')} ({code()[:12]})"


def worker_files(experiment: Experiment) -> dict[str, bytes]:
    """FMUs of an experiment, and the library that steps them, by their paths on a worker."""
    paths = {f"{name}/{path.name}": path for name, path in experiment.fmu_files.items()}
    paths |= {} if experiment.loop is None else {LIBRARY: experiment.loop.path}
    return {place: path.read_bytes() for place, path in paths.items()}


@dataclass(frozen=True)
class Job:
    """The data that all batches of a study share."""

    key: str                     # of the study: SHA-256 of all that its result depends on
    code: str                    # of the package that plans it, see `code_of_package`
    experiment: Experiment       # its files are those of the machine that plans the study
    targets: tuple[Target, ...]
    columns: tuple[Column, ...]
    kept: tuple[str, ...] = ()   # signals whose trajectories are kept
    every: int = 1               # communication steps between two rows of these
    # Longest wall time of a sample, s, each then being run in a process next to the worker.
    limit: float | None = None
    written: Mapping[str, Variables] = field(default_factory=dict)   # of users' classes, by name of the FMU
    native: bool = True            # whether all FMUs are, which takes less time
    ahead: int = 0                 # samples of a search in all, whose generations are run one after the other

    def changes(self, sample: Sequence[float]) -> dict[str, float | bool]:
        return {target.name: bool(value) if target.boolean else value
                for target, value in zip(self.targets, sample, strict=True)}

    def repeated_run(self, ended: c_int64 | None = None) -> RepeatedRun:
        """Return the object that runs samples in this process, see `RepeatedRun`."""
        measuring = Measuring(self.experiment.plan, self.experiment.times, self.kept, self.every)
        return RepeatedRun(self.experiment, {*measuring.names, *measuring.amounts}, measuring, ended, self.written)


@dataclass(frozen=True)
class BatchResult:
    """A batch that was run."""

    first: int                          # number of its first sample
    # Metrics, SI, shape (samples, columns); NaN where a sample was not completed, or has no such metric.
    values: Array
    failures: tuple[str | None, ...]    # why a sample was not completed
    endings: tuple[str, ...] = ()       # how each ended, in words
    trajectories: Array | None = None   # shape (samples, rows, signals)


class Batch(NamedTuple):
    """Samples that are run together: the number of the batch, its first sample and the one after its last."""

    number: int
    first: int
    last: int

    @property
    def samples(self) -> range:
        return range(self.first, self.last)

    def is_whole(self, result: BatchResult) -> bool:
        """Return True if all samples were run."""
        return len(result.failures) == len(self.samples)


# Function that stores a batch; after Ctrl-C the batch may have only its first samples, those that were run.
Store = Callable[[BatchResult], None]


class Sample(NamedTuple):
    """One sample that was run."""

    values: Array                        # metrics, shape (columns,)
    ending: str                          # in words
    failure: str | None = None           # why it was not completed
    trajectories: Array | None = None    # shape (rows, signals)


def failed_sample(job: Job, why: str) -> Sample:
    return Sample(np.full(len(job.columns), nan), f"{ABORTED}: {why}", why)


def run_samples(job: Job, values: Array, loaded: Callable[[], None] | None = None,
               ended: c_int64 | None = None) -> Iterator[Sample | Found]:
    """Run samples in this process, with values of the targets, shape (samples, targets); `sampled` has their metrics.

    `loaded` is called when the FMUs are loaded. KeyboardInterrupt as soon as `ended` is not 0, where there is a loop
    with the FMUs' blocks.
    """
    with job.repeated_run(ended) as repeated:
        repeated.load()   # what fails here is no sample's fault
        if loaded is not None:
            loaded()
        samples = [job.changes(sample) for sample in values.tolist()]
        if len(samples) > 1:
            repeated.widen(samples[0])
        for first in range(0, len(samples), repeated.width):
            yield from run_together(job, repeated, samples[first:first + repeated.width])


def run_together(job: Job, repeated: RepeatedRun, samples: Sequence[Changes]) -> Iterator[Sample | Found]:
    """Run samples side by side where there is a loop for it; others, and those that it cannot run, one by one."""
    plan = job.experiment.plan
    for changes, found in zip(samples, repeated.measure(samples), strict=True):
        if isinstance(found, Found):
            yield found
            continue
        try:
            if found is not None:
                raise found
            time, columns = repeated.run(changes)
            metrics = run_metrics(plan, time, columns, repeated.resistances(changes))
        except MaglevError as error:
            yield failed_sample(job, in_one_line(error))
            continue
        kept = np.column_stack([columns[name][::job.every] for name in job.kept]) if job.kept else None
        yield Sample(metric_rows(job, metrics)[0], ending(plan, metrics), None, kept)


def sampled_in_order(job: Job, ran: Sequence[Sample | Found]) -> list[Sample]:
    """Return run samples in their order; the results of one meter become metrics together."""
    plan, together = job.experiment.plan, dict[Meter, list[State]]()
    for one in ran:
        if isinstance(one, Found):
            together.setdefault(one.meter, []).append(one.state)
    many = {meter: meter.metrics(found) for meter, found in together.items()}
    rows = {meter: zip(metric_rows(job, metrics), endings(plan, metrics), strict=True)
            for meter, metrics in many.items()}
    return [Sample(*next(rows[one.meter]), None, one.kept if job.kept else None) if isinstance(one, Found) else one
            for one in ran]


def metric_rows(job: Job, metrics: Metrics | ManyMetrics) -> Array:
    """Metrics of runs, or of one, shape (runs, columns); NaN where there is none."""
    named = named_values(job.experiment.plan, metrics)
    columns = [np.asarray(named.get(column.name, (nan, ""))[0], np.float64) for column in job.columns]
    return np.column_stack(np.broadcast_arrays(*columns)) if columns else np.empty((np.size(metrics.failed), 0))


def gathered(job: Job, first: int, samples: Iterable[Sample | Found]) -> BatchResult:
    """Return a batch of samples from the number `first` on; a failed sample has a row with the reason."""
    done = sampled_in_order(job, list(samples))
    rows = np.array([sample.values for sample in done]).reshape(len(done), len(job.columns))
    given = {row: sample.trajectories for row, sample in enumerate(done) if sample.trajectories is not None}
    kept = None
    if given:
        kept = np.full((len(done), *next(iter(given.values())).shape), nan)
        for row, trajectories in given.items():
            kept[row] = trajectories
    return BatchResult(first, rows, tuple(sample.failure for sample in done),
                       tuple(sample.ending for sample in done), kept)


def run_batch(job: Job, first: int, values: Array, ended: c_int64 | None = None) -> BatchResult:
    """Run a batch here, or next to this process where samples have a limit of time; MaglevError if it cannot begin.

    After Ctrl-C or SIGTERM, and where `ended` is not 0, it is the first samples, those that were done.
    """
    def until_interrupted() -> Iterator[Sample | Found]:
        with suppress(KeyboardInterrupt):
            yield from (run_samples(job, values, ended=ended) if job.limit is None else
                        run_samples_apart(job, values, job.limit))

    return gathered(job, first, until_interrupted())


def run_samples_apart(job: Job, values: Array, limit: float) -> Iterator[Sample]:
    """Run samples in a process next to this one, and in another after each that takes longer than `limit`, s.

    MaglevError if the FMUs cannot be loaded.
    """
    done, deaths, patience = 0, 0, max(limit, STARTED_WITHIN)
    while done < len(values):
        loaded = False
        with other_process() as (worker, _):
            worker.ask(partial(send_samples, job, values[done:]))
            try:
                checked(worker.next(patience), None)
                loaded = True
                while not (said := worker.next(limit)).last:
                    yield sample_of(job, said, len(values) - done)
                    done, deaths = done + 1, 0
                if done < len(values):
                    raise Forged
            except Gone as gone:
                deaths += bool(gone.how)
                if gone.how and deaths < ATTEMPTS:
                    continue
                why = (f"took longer than {limit:g} s" if isinstance(gone, Silent) else
                       f"the process that ran it ended ({gone.how})" if gone.how else f"what ran {gone}")
                if not loaded:
                    raise MaglevError(f"the FMUs were not loaded within {patience:g} s" if isinstance(gone, Silent) else
                                      f"the FMUs cannot be loaded: {why}") from None
                yield failed_sample(job, why)
                done, deaths = done + 1, 0


def sample_of(job: Job, said: Said, most: int) -> Sample:
    """Return the sample that another process reports, if its number is in range; raise Forged for anything else."""
    sample: Sample = checked(said, Sample)
    rows = len(job.experiment.times[::job.every])
    kept = None if sample.trajectories is None else (sample.trajectories.dtype.kind, sample.trajectories.shape)
    if (most < 1 or type(sample.ending) is not str
            or (sample.values.dtype.kind, sample.values.shape) != ("f", (len(job.columns),))
            or kept not in (None, ("f", (rows, len(job.kept))))):
        raise Forged
    return sample


def send_samples(job: Job, values: Array, send: Send) -> None:
    """Run samples in this process, and send first that the FMUs are loaded, then each sample."""
    for one in run_samples(job, values, partial(send, None)):
        send(sampled_in_order(job, [one])[0])
