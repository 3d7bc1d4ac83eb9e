"""The batches of a study, and who runs them: this machine, or the workers of a Dask scheduler.

Here they run side by side: by threads of this process where the FMUs' blocks are in one loop, which is C and lets other
threads run. FMUs that are called run in processes of their own.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from ctypes import c_int64
from functools import partial

from maglev.cosim.lane_loop import MOST_LANES
from maglev.files.arrays import Array
from maglev.files.errors import MaglevError, extra, option
from maglev.files.side_by_side import Idle, Progress, Stopped, kept_processes, side_by_side, warn
from maglev.language.errors import ExportError
from maglev.many.samples import (
    LONGEST_OF_DEADLY,
    Batch,
    BatchResult,
    Job,
    Store,
    gathered,
    run_batch,
    run_samples_apart,
)
from maglev.scenario.fmus_for_runs import has_compiler

STEPS_OF_A_BATCH = 2_500_000      # communication steps of native FMUs, which take some seconds
PYTHON_COST = 20                  # steps of native FMUs in one of those that run Python inside
FEWEST_BATCHES = 8                # of a small study, so that many workers have something to do
MOST_BATCHES = 1_000              # of a large one: each becomes a file until all are done
LARGEST_TRAJECTORIES = 32e6       # bytes of a batch
WORTH_COMPILING = 10_000_000      # steps, which take longer by calls of FMUs than the compiler and lanes together

RunBatches = Callable[[Job, list[Batch], Array, Store], None]   # runs batches with values of the targets by sample


def batches_of(job: Job, samples: int, rows: int) -> list[Batch]:
    """Return the batches of a study; they depend on the study alone, not on the processes that run it."""
    steps = job.experiment.plan.stop_time / job.experiment.step * (1 if job.native else PYTHON_COST)
    size = min(max(int(STEPS_OF_A_BATCH / steps), -(-samples // MOST_BATCHES)), -(-samples // FEWEST_BATCHES))
    if job.kept:
        size = min(size, int(LARGEST_TRAJECTORIES / (8 * rows * len(job.kept))))
    size = max(1, size // MOST_LANES * MOST_LANES or size)
    return [Batch(number, first, min(first + size, samples))
            for number, first in enumerate(range(0, samples, size))]


@contextmanager
def runners(scheduler: str | None, jobs: int) -> Iterator[RunBatches]:
    """Yield the function that runs batches: by a scheduler's workers, or by processes here until the block ends.

    A batch whose process dies is run again; a sample that kills a process again gets a row that says so. ScenarioError
    if the scheduler cannot be reached, has no worker, or a worker has another version of this package.
    """
    if scheduler is None:
        with kept_processes() as idle:
            yield partial(run_here, jobs, idle)
        return
    extra("distributed", "cluster", option("scheduler"))
    from maglev.many.dask_workers import connected, run_there

    with connected(scheduler) as client:
        yield partial(run_there, client)


def run_here(jobs: int, idle: Idle, job: Job, batches: list[Batch], values: Array, store: Store) -> None:
    """Run batches in several threads or processes, and store each when it is done; `values` of the targets are by
    sample.

    MaglevError if a batch cannot be run at all; KeyboardInterrupt after Ctrl-C or SIGTERM, with all finished batches
    stored.
    """
    if has_loop(job, batches, values):
        run_in_threads(jobs, job, batches, values, store)
        return
    by_name = {str(batch.number): batch for batch in batches}
    deadly: list[Batch] = []   # whose process died, or was ended from outside

    def take(name: str, result: BatchResult | MaglevError | None) -> None:
        if isinstance(result, MaglevError):
            raise result
        if result is None or not by_name[name].is_whole(result):
            deadly.append(by_name[name])
        else:
            store(result)

    try:   # batches are reported as they are stored
        side_by_side({name: partial(run_task, job, batch.first, values[batch.first:batch.last])
                      for name, batch in by_name.items()}, jobs, lambda *_: None, lambda *_: None, idle, take=take)
    except Stopped as stopped:
        for result in stopped.results.values():   # of those that were under way
            if isinstance(result, BatchResult):
                store(result)
        raise
    for batch in deadly:
        samples = run_samples_apart(job, values[batch.first:batch.last], job.limit or LONGEST_OF_DEADLY)
        store(gathered(job, batch.first, samples))


def has_loop(job: Job, batches: list[Batch], values: Array) -> bool:
    """Return True if there is a loop for samples side by side; it is compiled now if their number is worth it."""
    samples = [sample for batch in batches for sample in batch.samples]
    if job.limit is not None or not samples:
        return False
    steps = job.experiment.plan.stop_time / job.experiment.step * max(job.ahead, len(samples))
    with job.repeated_run() as repeated:
        try:
            repeated.widen(job.changes(values[samples[0]].tolist()), build=steps >= WORTH_COMPILING)
        except (ExportError, OSError) as error:   # samples then take longer, which is reported if there is a compiler
            if has_compiler():
                warn(f"{error}; samples run by calls of the FMUs: the same results, slower")
        return repeated.loop is not None


def run_in_threads(jobs: int, job: Job, batches: list[Batch], values: Array, store: Store) -> None:
    """Run batches in several threads, each with its own FMUs, and store each here as it is done."""
    ended = c_int64()
    with ThreadPoolExecutor(jobs) as pool:
        waiting = {pool.submit(run_batch, job, batch.first, values[batch.first:batch.last], ended) for batch in batches}
        try:
            for future in as_completed([*waiting]):
                waiting.remove(future)   # what is stored is not kept
                store(future.result())
        except KeyboardInterrupt:
            ended.value = 1
            pool.shutdown(cancel_futures=True)
            for future in waiting:
                if not future.cancelled() and future.exception() is None:
                    store(future.result())
            raise
        finally:
            ended.value = 1
            pool.shutdown(cancel_futures=True)


def run_task(job: Job, first: int, values: Array, _progress: Progress) -> BatchResult | MaglevError | None:
    """Run a batch in this process; return an error that stops a study instead of raising it."""
    try:
        return run_batch(job, first, values)
    except MaglevError as error:
        return error
