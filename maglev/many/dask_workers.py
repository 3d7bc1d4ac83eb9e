"""Batches run by the workers of a Dask scheduler: a bounded number under way, parts written as they come."""

import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

from distributed import Client, Future, KilledWorker, Worker, WorkerPlugin, as_completed, get_worker

from maglev.cosim.step_loop import LIBRARY
from maglev.files.arrays import Array
from maglev.files.cache import digest_of_all
from maglev.files.errors import MaglevError, ScenarioError, in_one_line, option
from maglev.many.samples import (
    LONGEST_OF_DEADLY,
    Batch,
    BatchResult,
    Job,
    Store,
    code_of_package,
    failed_sample,
    gathered,
    run_batch,
    worker_files,
)
from maglev.user.source import FmuFile, Source

AHEAD = 2                # batches under way or waiting for each thread of the cluster
REACHED_WITHIN = 10.0    # s
WORKERS_WITHIN = 60.0    # s


@contextmanager
def connected(scheduler: str) -> Iterator[Client]:
    """Client of the scheduler at an address; errors as of `runners`."""
    def version_there() -> str:
        # Sent as code, not by name: a worker may know nothing of this module.
        try:
            from maglev.many.samples import code_of_package as code
        except ImportError as error:
            return f"no maglev-fmus with the extra study ({error})"
        return code()

    try:
        client = Client(scheduler, timeout=REACHED_WITHIN)
    # the address is wrong, nothing answers at it, or TLS fails
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        raise ScenarioError(f"{option('scheduler', scheduler)}: cannot be reached within {REACHED_WITHIN:g} s "
                            f"({in_one_line(error)[:80]}), expected the address of a Dask scheduler, such as "
                            "tcp://host:8786") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=WORKERS_WITHIN)
        except TimeoutError:
            raise ScenarioError(f"{option('scheduler', scheduler)}: has no worker after {WORKERS_WITHIN:g} s, expected "
                                "one or more") from None
        versions: dict[str, Any] = client.run(version_there, on_error="return")
        for worker, version in versions.items():
            if version != code_of_package():
                raise ScenarioError(f"{option('scheduler', scheduler)}: worker {worker} has maglev-fmus "
                                    f"{in_one_line(version) if isinstance(version, Exception) else version}, expected "
                                    f"{code_of_package()} on all workers")
        yield client


class StudyFiles(WorkerPlugin):
    """The job of a study and its FMUs, in a folder of every worker that is named after their content."""

    def __init__(self, job: Job, files: Mapping[str, bytes]):
        self.job = job
        self.files = files
        self.name = f"maglev-{job.key}"
        self.folder: Path | None = None

    def setup(self, worker: Worker) -> None:
        folder = Path(worker.local_directory) / f"maglev-{digest_of_all(self.files)}"
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        self.folder = folder

    def teardown(self, worker: Worker) -> None:
        if self.folder is not None:
            shutil.rmtree(self.folder, ignore_errors=True)

    def local_job(self) -> Job:
        """The job with the files of this worker."""
        assert self.folder is not None   # Dask sets a plugin up before it is asked
        experiment = self.job.experiment
        sources: dict[str, Source] = {name: FmuFile(self.folder / name / path.name)
                                      for name, path in experiment.fmu_files.items()}
        loop = experiment.loop and experiment.loop._replace(path=self.folder / LIBRARY)
        return replace(self.job, experiment=replace(experiment, sources=sources, loop=loop))


def run_on_worker(plugin: str, first: int, values: Array, apart: bool) -> BatchResult:
    """Run the samples from number `first` on, as of `run_batch`, on a worker, or `apart`: next to it."""
    files = get_worker().plugins[plugin]
    assert isinstance(files, StudyFiles)
    if files.job.code != code_of_package():
        raise MaglevError(f"a worker has maglev-fmus {code_of_package()}, expected {files.job.code}")
    job = files.local_job()
    return run_batch(replace(job, limit=job.limit or LONGEST_OF_DEADLY) if apart else job, first, values)


def run_there(client: Client, job: Job, batches: list[Batch], values: Array, store: Store) -> None:
    """Run batches as `run_here` does: one that took several workers with it is run next to a worker."""
    plugin = StudyFiles(job, worker_files(job.experiment))
    client.register_plugin(plugin)
    try:
        deadly = list(run_in_turn(client, plugin.name, batches, values, store))
        for batch in run_in_turn(client, plugin.name, deadly, values, store, apart=True):
            store(gathered(job, batch.first, [
                failed_sample(job, "every process that ran it ended early") for _ in batch.samples]))
    finally:
        with suppress(OSError, KeyError):   # a worker that is ending, or has just come, has nothing to remove
            client.unregister_worker_plugin(plugin.name)


def run_in_turn(client: Client, plugin: str, batches: list[Batch], values: Array, store: Store,
                apart: bool = False) -> Iterator[Batch]:
    """Run batches, a bounded number at a time; return those whose workers died again and again."""
    waiting = iter(batches)
    under_way: dict[Future[BatchResult], Batch] = {}

    def more() -> list[Future[BatchResult]]:
        room = AHEAD * max(1, sum(client.nthreads().values())) - len(under_way)
        # Not pure: a batch that was cancelled is not to be found again.
        futures = {client.submit(run_on_worker, plugin, batch.first, values[batch.first:batch.last], apart, pure=False,
                                 retries=1): batch for batch in islice(waiting, max(0, room))}
        under_way.update(futures)
        return list(futures)

    try:
        done = as_completed(more())
        for future in done:
            batch = under_way.pop(future)
            try:
                result = future.result()
            except KilledWorker:
                yield batch
            except OSError as error:
                raise MaglevError(f"a worker stopped: {in_one_line(error)}") from error
            else:
                store(result)
            future.release()
            for another in more():
                done.add(another)
    finally:
        with suppress(OSError):
            client.cancel(list(under_way))
