"""The batches of a study, and who flies them: processes of this machine, or the workers of a Dask scheduler."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from maglev.arrays import Array
from maglev.errors import extra, option
from maglev.processes.side_by_side import kept_processes
from maglev.studies.flying.here import fly_here
from maglev.studies.flying.samples import Batch, Job, Store

STEPS_OF_A_BATCH = 2_500_000      # communication steps of native FMUs, which take some seconds
PYTHON_COST = 20                  # steps of native FMUs in one of those that run Python inside
FEWEST_BATCHES = 8                # of a small study, so that many workers have something to do
LARGEST_TRAJECTORIES = 32e6       # bytes of a batch

Fly = Callable[[Job, list[Batch], Array, Store], None]   # flies batches with values of the targets by sample


def batches_of(job: Job, samples: int, native: bool, rows: int) -> list[Batch]:
    """Batches of a study; they depend on the study alone, not on who flies it."""
    steps = job.experiment.plan.stop_time / job.experiment.step * (1 if native else PYTHON_COST)
    size = min(int(STEPS_OF_A_BATCH / steps), -(-samples // FEWEST_BATCHES))
    if job.kept:
        size = min(size, int(LARGEST_TRAJECTORIES / (8 * rows * len(job.kept))))
    size = max(1, size)
    return [Batch(number, first, min(first + size, samples))
            for number, first in enumerate(range(0, samples, size))]


@contextmanager
def flyers(scheduler: str | None, jobs: int) -> Iterator[Fly]:
    """Who flies batches: the workers of a scheduler at an address, or so many processes here, which end with the block.

    A batch whose process dies is flown again; a sample that takes a process with it again has a row that says so.
    ScenarioError if the scheduler cannot be reached, has no worker, or a worker has another version of this package.
    """
    if scheduler is None:
        with kept_processes() as idle:
            yield partial(fly_here, jobs, idle)
        return
    extra("distributed", "cluster", option("scheduler"))
    from maglev.studies.flying.dask_workers import connected, fly_there

    with connected(scheduler) as client:
        yield partial(fly_there, client)
