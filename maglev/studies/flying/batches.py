"""The batches of a study on a Dask cluster: a bounded number under way, parts written as they come."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import islice
from typing import NamedTuple

from distributed import Client, Future, KilledWorker, as_completed

from maglev.arrays import Array
from maglev.errors import MaglevError, in_one_line
from maglev.studies.flying.batch import StudyFiles, files_of, fly_batch
from maglev.studies.flying.samples import Flown, Job, Sample, failed, gathered

STEPS_OF_A_BATCH = 2_500_000      # communication steps of native FMUs, which take some seconds
PYTHON_COST = 20                  # steps of native FMUs in one of those that run Python inside
FEWEST_BATCHES = 8                # of a small study, so that many workers have something to do
LARGEST_TRAJECTORIES = 32e6       # bytes of a batch
AHEAD = 2                         # batches under way or waiting for each thread of the cluster

Store = Callable[[int, Flown], None]   # what is done with a batch by its number


class Batch(NamedTuple):
    """Samples that are flown together: the number of the batch, its first sample and the one after its last."""

    number: int
    first: int
    last: int


def batches_of(job: Job, samples: int, native: bool, rows: int) -> list[Batch]:
    """Batches of a study; they depend on the study alone, not on who flies it."""
    steps = job.experiment.plan.stop_time / job.experiment.step * (1 if native else PYTHON_COST)
    size = min(int(STEPS_OF_A_BATCH / steps), -(-samples // FEWEST_BATCHES))
    if job.kept:
        size = min(size, int(LARGEST_TRAJECTORIES / (8 * rows * len(job.kept))))
    size = max(1, size)
    return [Batch(number, first, min(first + size, samples))
            for number, first in enumerate(range(0, samples, size))]


def fly_all(client: Client, job: Job, batches: list[Batch], values: Array, store: Store) -> None:
    """Fly batches and store each as it is done; `values` are those of the targets by sample.

    A batch whose worker dies is flown again elsewhere. One that took several workers with it is flown sample by sample,
    alone on the cluster; a sample that takes its worker again has a row that says so. MaglevError if a batch cannot be
    flown at all, such as by a worker with another version of this package.
    """
    plugin = StudyFiles(job, files_of(job.experiment))
    client.register_plugin(plugin)
    try:
        deadly = list(fly_in_turn(client, plugin.name, batches, values, store))
        for batch in deadly:
            numbers = range(batch.first, batch.last)
            store(batch.number, gathered(job, batch.first, len(numbers), (
                alone(client, plugin.name, number, values, job) for number in numbers)))
    finally:
        with suppress(OSError, KeyError):   # a worker that is ending, or has just come, has nothing to remove
            client.unregister_worker_plugin(plugin.name)


def fly_in_turn(client: Client, plugin: str, batches: list[Batch], values: Array,
                store: Store) -> Iterator[Batch]:
    """Fly batches, a bounded number at a time; gives those whose workers died again and again."""
    waiting = iter(batches)
    under_way: dict[Future[Flown], Batch] = {}

    def more() -> list[Future[Flown]]:
        room = AHEAD * max(1, sum(client.nthreads().values())) - len(under_way)
        futures = {submit(client, plugin, batch, values): batch for batch in islice(waiting, max(0, room))}
        under_way.update(futures)
        return list(futures)

    try:
        done = as_completed(more())
        for future in done:
            batch = under_way.pop(future)
            try:
                store(batch.number, result(future))
            except KilledWorker:
                yield batch
            future.release()
            for another in more():
                done.add(another)
    finally:
        with suppress(OSError):
            client.cancel(list(under_way))


def submit(client: Client, plugin: str, batch: Batch, values: Array) -> Future[Flown]:
    """Give a batch to the cluster."""
    # Not pure: a batch that was cancelled is not to be found again.
    return client.submit(fly_batch, plugin, batch.first, values[batch.first:batch.last], pure=False, retries=1)


def result(future: Future[Flown]) -> Flown:
    """What a batch gave; MaglevError if it could not be flown."""
    try:
        found: Flown = future.result()
    except (KilledWorker, MaglevError):
        raise
    except OSError as error:
        raise MaglevError(f"a worker cannot go on: {in_one_line(error)}") from error
    return found


def alone(client: Client, plugin: str, number: int, values: Array, job: Job) -> Sample:
    """Fly one sample with nothing else under way: if workers die now, they die of it."""
    future = submit(client, plugin, Batch(0, number, number + 1), values)
    try:
        flown = result(future)
    except KilledWorker:
        return failed(job, "every process that flew it died")
    finally:
        future.release()
    return Sample(flown.values[0], flown.failures[0], None if flown.trajectories is None else flown.trajectories[0])
