"""Studies on the workers of a Dask scheduler: the bits of this machine's processes, or one line that says why not."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from facts import raises
from tiny_study import of_a_crash, planned, simulate_samples

import maglev
from maglev.files.errors import ScenarioError
from maglev.many import dask_workers
from maglev.many.batches import runners
from maglev.many.samples import BatchResult
from maglev.many.study_plan import PlannedStudy
from maglev.many.study_run import run_study

if TYPE_CHECKING:   # imports of it take a second
    from distributed import LocalCluster


@pytest.fixture(scope="module")
def cluster(slow: None) -> "Iterator[LocalCluster]":
    """Two workers, whose certificate is in this process's configuration of Dask: their address is enough."""
    import dask
    from distributed import LocalCluster
    from distributed.security import Security

    security = Security.temporary()
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", security=security,
                      dashboard_address=":0", silence_logs=50) as cluster, dask.config.set({
                          "distributed.comm.tls.ca-file": security.tls_ca_file,
                          "distributed.comm.tls.client.cert": security.tls_client_cert,
                          "distributed.comm.tls.client.key": security.tls_client_key}):
        yield cluster


def simulated(cluster: "LocalCluster | None", study: PlannedStudy, out: Path) -> bytes:
    """Bytes of the dataset."""
    address = None if cluster is None else str(cluster.scheduler_address)
    return run_study(study, out, 2, address, False, lambda _done, _all: None, print).read_bytes()


def test_it_gives_the_bytes_of_this_machine(cluster: "LocalCluster", fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus)
    assert simulated(cluster, study, tmp_path / "there") == simulated(None, study, tmp_path / "here")


def test_a_dead_worker_costs_its_batch(cluster: "LocalCluster", fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus)
    found: dict[int, BatchResult] = {}

    from distributed import Client

    def store(batch: BatchResult) -> None:
        if not found:   # batches are under way on both
            with Client(cluster) as client:
                victim = next(iter(client.run(os.getpid).values()))
            os.kill(victim, signal.SIGKILL)
        found[batch.first] = batch

    with runners(str(cluster.scheduler_address), 2) as simulate:
        simulate(study.job, study.batches, study.values, store)
    assert sorted(found) == [batch.first for batch in study.batches]
    assert np.array_equal(np.concatenate([found[first].values for first in sorted(found)]),
                          simulate_samples(study.job, 0, study.values).values)


@pytest.mark.thorough
def test_a_sample_that_takes_its_workers_with_it(cluster: "LocalCluster", fastest_fmus: Path, tmp_path: Path) -> None:
    scheduler: Any = cluster.scheduler
    scheduler.allowed_failures = 0   # the first death is enough
    found: list[BatchResult] = []
    study = of_a_crash(fastest_fmus, tmp_path, limit=None)
    with runners(str(cluster.scheduler_address), 2) as simulate:
        simulate(study.job, study.batches, study.values, found.append)
    assert found[0].failures == ("the process that ran it ended (SIGSEGV)",)


def test_workers_of_another_version_are_refused(cluster: "LocalCluster", fastest_fmus: Path, tmp_path: Path,
                                                monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_workers, "code_of_package", lambda: "0.0 (other)")
    with raises(ScenarioError, "maglev-fmus", "0.0 (other)"):
        simulated(cluster, planned(tmp_path, fastest_fmus), tmp_path)
    assert not (tmp_path / "study.parts").exists()


@pytest.mark.usefixtures("slow")
def test_an_unreachable_scheduler_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_workers, "REACHED_WITHIN", 0.5)
    with raises(ScenarioError, "scheduler", "tcp://127.0.0.1:9"), \
            runners("tcp://127.0.0.1:9", 1):
        pass


@pytest.mark.usefixtures("slow")
def test_it_is_refused_before_anything_is_built(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(dask_workers, "REACHED_WITHIN", 0.5)
    monkeypatch.setattr("maglev.api.studying.experiments_of", None)   # which builds
    with raises(ScenarioError, "scheduler", "tcp://127.0.0.1:9"):
        maglev.study("2dof-step-1-nonlinear", vary={"plant.v.mass": [4.3]}, scheduler="tcp://127.0.0.1:9",
                     out=tmp_path)


@pytest.mark.thorough
def test_without_a_certificate_one_line_says_so(cluster: "LocalCluster") -> None:
    import dask

    with dask.config.set({"distributed.comm.tls.ca-file": None, "distributed.comm.tls.client.cert": None,
                          "distributed.comm.tls.client.key": None}), \
            raises(ScenarioError, "scheduler", cluster.scheduler_address, "TLS"), \
            runners(str(cluster.scheduler_address), 1):
        pass
