"""Studies in processes of this machine: the result is the same whatever dies, whenever it is interrupted."""

import threading
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from facts import raises
from psutil import STATUS_ZOMBIE, Process
from tiny_study import of_a_crash, planned, scenario, simulate_samples

import maglev
from maglev.files.errors import Interrupted, ScenarioError, UnknownName
from maglev.many import batches
from maglev.many.batches import runners
from maglev.many.samples import BatchResult
from maglev.many.study_plan import PlannedStudy
from maglev.many.study_run import run_study


def in_this_process(study: PlannedStudy) -> BatchResult:
    return simulate_samples(study.job, 0, study.values)


def simulated(study: PlannedStudy, out: Path, **options: Any) -> bytes:
    """Bytes of the dataset."""
    options = {"resume": False, "watch": lambda _done, _all: None, "say": print, **options}
    return run_study(study, out, 2, None, **options).read_bytes()


@pytest.mark.few(1)
@pytest.mark.parametrize("end", ["kill", "terminate"])
def test_a_dead_process_costs_its_batch(fastest_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                        end: str) -> None:
    """Also one that is asked to end, and gives what it has done."""
    # Threads, where a loop of another test was kept, are no processes.
    monkeypatch.setattr(batches, "has_loop", lambda *_: False)
    study = planned(tmp_path, fastest_fmus)
    found: dict[int, BatchResult] = {}

    def store(batch: BatchResult) -> None:
        if not found:
            victim = next(each for each in Process().children(recursive=True)
                          if each.status() != STATUS_ZOMBIE and "worker_process" in " ".join(each.cmdline()))
            getattr(victim, end)()
        found[batch.first] = batch

    with runners(None, 2) as simulate:
        simulate(study.job, study.batches, study.values, store)
    assert sorted(found) == [batch.first for batch in study.batches]
    expected = in_this_process(study)
    assert np.array_equal(np.concatenate([found[first].values for first in sorted(found)]), expected.values)


def test_an_interrupted_study_continues_to_the_same_bytes(fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, keep=["plant.v.position"])
    whole = simulated(study, tmp_path / "whole")

    def interrupt(done: int, _all: int) -> None:
        if done >= 5:
            raise KeyboardInterrupt

    with raises(Interrupted, "20 samples", "study.parts", "resume"):
        simulated(study, tmp_path / "parts", watch=interrupt)
    assert 0 < len(list((tmp_path / "parts" / "study.parts").glob("samples-*"))) < len(study.batches)
    with raises(ScenarioError, "20 samples", "resume"):
        simulated(study, tmp_path / "parts")
    assert simulated(study, tmp_path / "parts", resume=True) == whole
    assert not (tmp_path / "parts" / "study.parts").exists()
    kept = [(folder / "study.trajectories.parquet").read_bytes() for folder in (tmp_path / "whole", tmp_path / "parts")]
    assert kept[0] == kept[1]
    other = planned(tmp_path, fastest_fmus, vary=[{"set": "plant.v.mass", "kind": "list", "values": [4.0, 5.0]}])
    (tmp_path / "parts" / "study.parts").mkdir()
    with raises(ScenarioError, "study.parts", "another study"):
        simulated(other, tmp_path / "parts", resume=True)


def test_batches_do_not_show(fastest_fmus: Path, tmp_path: Path) -> None:
    """The rows of the merged parts are those of all samples in one batch, in their order."""
    study = planned(tmp_path, fastest_fmus, keep=["plant.v.position", "controller.v.reference"],
                    limits={"overshoot of v": {"max": "20 %"}})
    simulated(study, tmp_path)
    table, expected = pq.read_table(tmp_path / "study.parquet"), in_this_process(study)
    assert len(study.batches) > 1
    assert table["sample"].to_pylist() == list(range(20))
    for i, column in enumerate(study.job.columns):
        assert [float(value) for value in table[column.name].to_pylist()] == expected.values[:, i].tolist()
    overshoot = np.array(table["overshoot of v"].to_pylist())
    assert table["passed"].to_pylist() == (overshoot <= 0.2).tolist()
    kept = pq.read_table(tmp_path / "study.trajectories.parquet")
    assert expected.trajectories is not None
    for i, name in enumerate(study.job.kept):
        assert np.array_equal(kept[name].to_numpy(), expected.trajectories[:, :, i].ravel())
        assert kept.schema.field(name).metadata == {b"unit": b"m"}
    assert kept.num_rows == 20 * len(study.times)


def test_a_sample_that_fails_is_a_row_that_says_why(fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, vary=[{"set": "controller.sample_time", "kind": "list",
                                                   "values": ["0.5 ms", "0.7 ms"]}])
    simulated(study, tmp_path)
    good, bad = pq.read_table(tmp_path / "study.parquet").to_pylist()
    assert good["failure"] is None and good["passed"]
    assert "sample_time" in bad["failure"] and not bad["passed"]
    assert bad["rms error of v"] is None and bad["failed"] is None


def test_studies_as_data(fastest_fmus: Path, tmp_path: Path) -> None:
    """pandas, xarray, Polars and DuckDB read the same; a sample's command runs it again."""
    import duckdb
    import polars

    study = maglev.study(scenario(tmp_path), vary={"plant.v.mass": "4:5:3", "reference.h.amplitude": [1, 2]},
                         out=tmp_path, fmus=fastest_fmus)
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
                     set=[setting for flag, setting in pairwise(words) if flag == "--set"])
    assert run.metrics.rms_errors["h"] == frame["rms error of h"][5]
    again = study.run(5)
    assert again.keys() == run.keys() and all(again[name].tobytes() == run[name].tobytes() for name in run)
    for what in (study.command, study.run):
        with raises(UnknownName, "sample", 6, 0, 5):
            what(6)


@pytest.mark.thorough
def test_a_foreign_fmu_that_crashes(fastest_fmus: Path, tmp_path: Path) -> None:
    """The study continues, and says so; it was run next to the process of its batch."""
    simulated(of_a_crash(fastest_fmus, tmp_path), tmp_path)
    row, = pq.read_table(tmp_path / "study.parquet").to_pylist()
    assert row["failure"] == "the process that ran it ended (SIGSEGV)"
    assert not row["passed"] and row["rms error of v"] is None


def test_a_sample_that_takes_its_processes_with_it(fastest_fmus: Path, tmp_path: Path) -> None:
    """The others of its batch are run all the same."""
    study = of_a_crash(fastest_fmus, tmp_path, limit=None)
    simulated(study, tmp_path)
    row, = pq.read_table(tmp_path / "study.parquet").to_pylist()
    assert row["failure"] == "the process that ran it ended (SIGSEGV)"
    assert not row["passed"] and row["rms error of v"] is None


def test_threads_give_the_bytes_of_processes(native_fmus: Path, tmp_path: Path,
                                             monkeypatch: pytest.MonkeyPatch) -> None:
    """With trajectories, a sample that hits a stop, and one that is refused, which has its reason in both."""
    study = planned(tmp_path, native_fmus, keep=["plant.v.position", "controller.v.reference"], vary=[
        {"set": "plant.v.mass", "kind": "list", "values": [4.0, 4.5, 6.5]},
        {"set": "controller.sample_time", "kind": "list", "values": [5e-4, 7e-4]}])
    processes = simulated(study, tmp_path / "processes")
    monkeypatch.setattr(batches, "WORTH_COMPILING", 1)
    monkeypatch.setattr(batches, "side_by_side", None)   # which nothing asks for
    assert simulated(study, tmp_path / "threads") == processes
    table = pq.read_table(tmp_path / "threads" / "study.parquet")
    refused = [why for why in table["failure"].to_pylist() if why is not None]
    assert len(refused) == 3
    assert all("sample_time" in why for why in refused)
    kept = [(tmp_path / folder / "study.trajectories.parquet").read_bytes() for folder in ("processes", "threads")]
    assert kept[0] == kept[1]


def test_an_interrupt_ends_threads(native_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also within a sample; what is done is kept, and `--resume` continues to the same bytes."""
    monkeypatch.setattr(batches, "WORTH_COMPILING", 1)
    study = planned(tmp_path, native_fmus)
    whole = simulated(study, tmp_path / "whole")

    def interrupt(done: int, _all: int) -> None:
        if done >= 3:
            raise KeyboardInterrupt

    with raises(Interrupted, "20 samples", "resume"):
        simulated(study, tmp_path / "parts", watch=interrupt)
    assert not [each.name for each in threading.enumerate() if "simulate_waiting" in each.name]
    assert simulated(study, tmp_path / "parts", resume=True) == whole
