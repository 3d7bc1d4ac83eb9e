"""Batches flown in processes of this machine, beside each other."""

from collections.abc import Callable
from contextlib import suppress
from functools import partial

from fmi_export.errors import ExportError
from maglev.arrays import Array
from maglev.errors import MaglevError
from maglev.processes.side_by_side import Idle, Progress, side_by_side
from maglev.studies.flying.flight import Flight
from maglev.studies.flying.samples import Batch, Flown, Job, Sample, Store, failed, flown_batch, gathered, only_sample

WORTH_COMPILING = 10_000_000   # steps, which take longer by calls of FMUs than the compiler for a loop without


def fly_here(jobs: int, idle: Idle, job: Job, batches: list[Batch], values: Array, store: Store) -> None:
    """Fly batches in so many processes and store each as it is done; `values` are those of the targets by sample.

    Of a batch whose process dies, the samples are flown again one by one; one whose process dies then, too, has a row
    that says so. MaglevError if a batch cannot be flown at all; Stopped after Ctrl-C or SIGTERM.
    """
    steps = job.experiment.plan.stop_time / job.experiment.step * sum(batch.last - batch.first for batch in batches)
    if steps >= WORTH_COMPILING and job.limit is None:
        with suppress(ExportError, OSError), Flight(job.experiment) as flight:   # all go on without it
            flight.load(build=True)
    deadly: list[Batch] = []
    fly_batches(jobs, idle, job, batches, values, store, deadly.append)
    for batch in deadly:
        samples = [alone(idle, job, number, values) for number in range(batch.first, batch.last)]
        store(batch.number, gathered(job, batch.first, len(samples), samples))


def alone(idle: Idle, job: Job, number: int, values: Array) -> Sample:
    """Fly one sample with nothing else under way: if its process dies now, it dies of it."""
    found = [failed(job, "every process that flew it died")]
    fly_batches(1, idle, job, [Batch(0, number, number + 1)], values,
                lambda _, flown: found.append(only_sample(flown)), lambda _: None)
    return found[-1]


def fly_batches(jobs: int, idle: Idle, job: Job, batches: list[Batch], values: Array, store: Store,
                died: Callable[[Batch], None]) -> None:
    """Fly each batch once; store it, or say whose process died."""
    by_name = {str(batch.number): batch for batch in batches}

    def take(name: str, flown: Flown | MaglevError | None) -> None:
        if isinstance(flown, MaglevError):
            raise flown
        if flown is None:
            died(by_name[name])
        else:
            store(by_name[name].number, flown)

    side_by_side({name: partial(fly_task, job, batch.first, values[batch.first:batch.last])
                  for name, batch in by_name.items()}, jobs, lambda _name, _why: None, unwatched, idle, take=take)


def fly_task(job: Job, first: int, values: Array, _progress: Progress) -> Flown | MaglevError | None:
    """Fly a batch in this process; an error that stops a study is what it returns."""
    try:
        return flown_batch(job, first, values)
    except MaglevError as error:
        return error


def unwatched(_name: str, _done: int, _all: int) -> None:
    """Batches are reported as they are stored."""
