"""The Dask cluster that a study is flown on: processes of this machine, or a scheduler elsewhere."""

import logging
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

import dask
from distributed import Client, LocalCluster
from distributed.security import Security

from maglev.errors import ScenarioError, in_one_line
from maglev.processes.interrupts import interrupts_blocked
from maglev.studies.flying.batch import code_of_package
from maglev_files.scratch import scratch

LOOPBACK = "127.0.0.1"

# What Dask looks at and shows beside the work: a batch is one call, of which a profile of its lines says nothing.
UNWATCHED = {"distributed.scheduler.http.routes": [], "distributed.worker.http.routes": [],
             "distributed.worker.profile.enabled": False, "distributed.admin.system-monitor.interval": "5s",
             "distributed.admin.tick.interval": "500ms",
             # And memory that a sample needs stays with the process for the next one: Dask would have it given back.
             "distributed.nanny.pre-spawn-environ": {
                 "MALLOC_TRIM_THRESHOLD_": 256_000_000, "MALLOC_MMAP_THRESHOLD_": 32_000_000, "OMP_NUM_THREADS": 1,
                 "MKL_NUM_THREADS": 1, "OPENBLAS_NUM_THREADS": 1}}
SCRATCH = "temporary-directory"
REACHED_WITHIN = 10.0    # s
WORKERS_WITHIN = 60.0    # s


@contextmanager
def connected(scheduler: str | None, jobs: int) -> Iterator[Client]:
    """Client of the scheduler at an address, or of a cluster of so many processes here, which ends with the block.

    ScenarioError if the scheduler cannot be reached, has no worker, or a worker has another version of this package.
    """
    if scheduler is None:
        # Dask starts processes now, and when one has died; what they have on the disk goes with the folder.
        with scratch() as folder, quiet(), without_script(), dask.config.set(UNWATCHED | {SCRATCH: str(folder)}):
            with interrupts_blocked():   # and the thread that starts them stays as this one is now
                # A worker's memory is that of one flight; Dask would pause one for ever that is over its share of a
                # small machine.
                # Whoever connects to a cluster can have it run code: this one takes its own processes alone, by a
                # certificate that is made for it. There are no pages, but without an address for them Dask would try
                # port 8787.
                cluster = LocalCluster(n_workers=jobs, threads_per_worker=1, processes=True, host=LOOPBACK,
                                       security=Security.temporary(), dashboard_address=f"{LOOPBACK}:0",
                                       scheduler_kwargs={"dashboard": False}, memory_limit=None,
                                       silence_logs=logging.CRITICAL)
            with cluster, Client(cluster) as client:
                client.run(ignore_interrupts)   # asyncio has let them through again
                yield client
        return
    try:
        client = Client(scheduler, timeout=REACHED_WITHIN)
    except (OSError, ValueError, TypeError, RuntimeError) as error:   # one that none answers at, or is none, or TLS
        raise ScenarioError(f"--scheduler {scheduler}: cannot be reached within {REACHED_WITHIN:g} s "
                            f"({in_one_line(error)[:80]}), expected the address of a Dask scheduler, such as "
                            "tcp://host:8786") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=WORKERS_WITHIN)
        except TimeoutError:
            raise ScenarioError(f"--scheduler {scheduler}: has no worker after {WORKERS_WITHIN:g} s, expected one or "
                                "more") from None
        require_same_package(client, scheduler)
        yield client


@contextmanager
def without_script() -> Iterator[None]:
    """Hide the script that runs: a process that is started would run it again, if it does not guard against that."""
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


def ignore_interrupts() -> None:
    """Ignore Ctrl-C in a process of this machine: the one that plans handles it for all."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def require_same_package(client: Client, scheduler: str) -> None:
    """Refuse workers that lack this package or have another version of it."""
    def version_there() -> str:
        # Sent as code, not by name: a worker may know nothing of this module.
        try:
            from maglev.studies.flying.batch import code_of_package as code
        except ImportError as error:
            return f"no maglev-fmus with the extra study ({error})"
        return code()

    versions: dict[str, Any] = client.run(version_there, on_error="return")
    for worker, version in versions.items():
        if version != code_of_package():
            raise ScenarioError(f"--scheduler {scheduler}: worker {worker} has maglev-fmus "
                                f"{in_one_line(version) if isinstance(version, Exception) else version}, expected "
                                f"{code_of_package()} on all workers")


@contextmanager
def quiet() -> Iterator[None]:
    """Without Dask's words about workers that come and go, which a study takes as they are."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.nanny", "distributed.scheduler",
                                                    "distributed.worker", "distributed.core", "distributed.client",
                                                    "distributed.comm")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
