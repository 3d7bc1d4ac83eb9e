"""Studies on a cluster: the result is the same whoever flies, whatever dies, whenever it is interrupted."""

import os
import signal
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from distributed import Client
from faulty_fmus import faulty, faulty_run
from tiny_study import UNCHANGED, address_of, fly_samples, planned, scenario, tiny, trusted

import maglev
from maglev.errors import Interrupted, MaglevError, ScenarioError
from maglev.studies.flying import cluster
from maglev.studies.flying.batches import fly_all
from maglev.studies.flying.samples import Flown
from maglev.studies.planning import PlannedStudy, plan_study
from maglev.studies.running import run_study


@pytest.fixture(scope="module")
def client(slow: None) -> Iterator[Client]:
    with cluster.connected(None, 2) as client, trusted(client.security):
        yield client


def in_this_process(study: PlannedStudy) -> Flown:
    return fly_samples(study.job, 0, study.values)


def flown(client: Client, study: PlannedStudy, out: Path, **options: Any) -> bytes:
    """Bytes of the dataset."""
    options = {"resume": False, "watch": lambda _done, _all: None, "say": print, **options}
    return run_study(study, out, 2, address_of(client), **options).read_bytes()


def test_a_dead_worker_costs_its_batch(client: Client, fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus)
    found: dict[int, Flown] = {}

    def store(number: int, batch: Flown) -> None:
        if not found:   # batches are under way on both
            victim = next(iter(client.run(os.getpid).values()))
            os.kill(victim, signal.SIGKILL)
        found[number] = batch

    fly_all(client, study.job, study.batches, study.values, store)
    assert sorted(found) == list(range(len(study.batches)))
    expected = in_this_process(study)
    assert np.array_equal(np.concatenate([found[number].values for number in sorted(found)]), expected.values)


def test_an_interrupted_study_goes_on_to_the_same_bytes(client: Client, fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, keep=["plant.v.position"])
    whole = flown(client, study, tmp_path / "whole")

    def interrupt(done: int, _all: int) -> None:
        if done >= 5:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match=r"of 20 samples are kept in .*--resume"):
        flown(client, study, tmp_path / "parts", watch=interrupt)
    assert 0 < len(list((tmp_path / "parts" / "study.parts").glob("samples-*"))) < len(study.batches)
    with pytest.raises(ScenarioError, match="of 20 samples are done, expected --resume"):
        flown(client, study, tmp_path / "parts")
    assert flown(client, study, tmp_path / "parts", resume=True) == whole
    assert not (tmp_path / "parts" / "study.parts").exists()
    kept = [(folder / "study.trajectories.parquet").read_bytes() for folder in (tmp_path / "whole", tmp_path / "parts")]
    assert kept[0] == kept[1]
    other = planned(tmp_path, fastest_fmus, vary=[{"set": "plant.v.mass", "kind": "list", "values": [4.0, 5.0]}])
    (tmp_path / "parts" / "study.parts").mkdir()
    with pytest.raises(ScenarioError, match="has parts of another study"):
        flown(client, other, tmp_path / "parts", resume=True)


def test_batches_do_not_show(client: Client, fastest_fmus: Path, tmp_path: Path) -> None:
    """The rows of the merged parts are those of all samples in one batch, in their order."""
    study = planned(tmp_path, fastest_fmus, keep=["plant.v.position"], limits={"overshoot of v": {"max": "20 %"}})
    flown(client, study, tmp_path)
    table, expected = pq.read_table(tmp_path / "study.parquet"), in_this_process(study)
    assert len(study.batches) > 1
    assert table["sample"].to_pylist() == list(range(20))
    for i, column in enumerate(study.job.columns):
        assert [float(value) for value in table[column.name].to_pylist()] == expected.values[:, i].tolist()
    overshoot = np.array(table["overshoot of v"].to_pylist())
    assert table["passed"].to_pylist() == (overshoot <= 0.2).tolist()
    kept = pq.read_table(tmp_path / "study.trajectories.parquet")
    assert expected.trajectories is not None
    assert np.array_equal(kept["plant.v.position"].to_numpy(), expected.trajectories.ravel())
    assert kept.num_rows == 20 * len(study.times)


def test_a_sample_that_fails_is_a_row_that_says_why(client: Client, fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, vary=[{"set": "controller.sample_time", "kind": "list",
                                                   "values": ["0.5 ms", "0.7 ms"]}])
    flown(client, study, tmp_path)
    good, bad = pq.read_table(tmp_path / "study.parquet").to_pylist()
    assert good["failure"] is None and good["passed"]
    assert "sample_time" in bad["failure"] and not bad["passed"]
    assert bad["rms error of v"] is None and bad["failed"] is None


def test_workers_of_another_version_are_refused(client: Client, fastest_fmus: Path, tmp_path: Path,
                                                monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "code_of_package", lambda: "0.0 (other)")
    with pytest.raises(ScenarioError, match=r"worker tls://.* has maglev-fmus .*, expected 0\.0 \(other\)"):
        flown(client, planned(tmp_path, fastest_fmus), tmp_path)
    assert not (tmp_path / "study.parts").exists()


def test_an_unreachable_scheduler_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "REACHED_WITHIN", 0.5)
    with pytest.raises(ScenarioError, match="--scheduler tcp://127.0.0.1:9: cannot be reached"), \
            cluster.connected("tcp://127.0.0.1:9", 1):
        pass


def test_studies_as_data(client: Client, fastest_fmus: Path, tmp_path: Path) -> None:
    """pandas, xarray, Polars and DuckDB read the same; a sample's command flies it again."""
    import duckdb
    import polars

    study = maglev.sweep(scenario(tmp_path), {"plant.v.mass": "4:5:3", "reference.h.amplitude": [1, 2]}, out=tmp_path,
                         fmus=fastest_fmus, scheduler=address_of(client))
    frame = study.to_pandas()
    overshoot = frame["overshoot of v"].tolist()
    assert polars.read_parquet(study.path)["overshoot of v"].to_list() == overshoot
    read = duckdb.sql(f"select \"overshoot of v\" from '{study.path}' order by sample")
    assert read and [value for value, in read.fetchall()] == overshoot
    grid = study.to_xarray()
    assert grid["overshoot of v"].dims == ("plant.v.mass", "reference.h.amplitude")
    assert grid["overshoot of v"].values.ravel().tolist() == overshoot
    assert grid["plant.v.mass"].attrs["units"] == study.units["plant.v.mass"] == "kg"
    assert frame.attrs["units"]["rms error of v"] == "m"
    words = study.command(5).split()
    assert words[:3] == ["maglev", "run", str(scenario(tmp_path).absolute())]
    run = maglev.run(scenario(tmp_path), fmus=fastest_fmus,
                     set=[setting for flag, setting in zip(words, words[1:], strict=False) if flag == "--set"])
    assert run.metrics.rms_errors["h"] == frame["rms error of h"][5]
    with pytest.raises(MaglevError, match="there is no sample 6"):
        study.command(6)
    study.about = {**study.about, "run": ["maglev", "run", "hold.toml"]}   # as a version before wrote it
    with pytest.raises(MaglevError, match="run = 'maglev run hold.toml' of an earlier version, .*fly the study again"):
        study.command(5)


def of_a_crash(fmus: Path, folder: Path) -> PlannedStudy:
    crashing = faulty_run(faulty("crash", folder), fmus)
    return plan_study(tiny(vary=[{"set": "plant.v.mass", "kind": "list", "values": [4.0]}]), crashing, "study.toml",
                      folder, UNCHANGED)


def test_a_foreign_fmu_that_crashes(client: Client, fastest_fmus: Path, tmp_path: Path) -> None:
    """The study goes on, and says so; no worker dies of it."""
    before = client.run(os.getpid)
    flown(client, of_a_crash(fastest_fmus, tmp_path), tmp_path)
    row, = pq.read_table(tmp_path / "study.parquet").to_pylist()
    assert row["failure"] == "the process that flew it ended (SIGSEGV)"
    assert not row["passed"] and row["rms error of v"] is None
    assert client.run(os.getpid) == before


def test_a_sample_that_takes_its_workers_with_it(client: Client, fastest_fmus: Path, tmp_path: Path) -> None:
    study = of_a_crash(fastest_fmus, tmp_path)
    scheduler: Any = client.cluster
    scheduler.scheduler.allowed_failures = 0   # the first death is enough
    flown(client, replace(study, job=replace(study.job, limit=None)), tmp_path)
    row, = pq.read_table(tmp_path / "study.parquet").to_pylist()
    assert row["failure"] == "every process that flew it died"
    assert not row["passed"] and row["rms error of v"] is None
