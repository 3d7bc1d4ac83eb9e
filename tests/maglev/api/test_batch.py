"""Batches: each sample is the run that `maglev.run` gives, in threads and in processes."""

import os
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from facts import raises, require_facts, warns

import maglev
from maglev.api.studying import plain
from maglev.cosim import lane_loop
from maglev.cosim.lane_loop import DONE, Taken
from maglev.files.errors import ScenarioError, UnknownName
from maglev.language.errors import ExportError
from maglev.many import batches
from maglev.many.repeated_run import RepeatedRun
from maglev.many.samples import Batch

RUN = "2dof-step-1-nonlinear"
MASSES = np.array([4.0, 4.35, 9.0])
WAYS = ("threads", "processes")


def only(way: str, patch: pytest.MonkeyPatch) -> None:
    """Samples are run in this way, and in no other."""
    patch.setattr(batches, "WORTH_COMPILING", 1 if way == "threads" else np.inf)
    patch.setattr(batches, "side_by_side" if way == "threads" else "run_in_threads", None)
    # Whether a loop was kept of another test does not count.
    patch.setattr("maglev.cosim.lane_loop.kept", lambda *_: None)


@pytest.fixture(scope="module", params=WAYS)
def batch(request: pytest.FixtureRequest, native_fmus: Path) -> maglev.Batch:
    with pytest.MonkeyPatch.context() as patch:
        only(request.param, patch)
        return maglev.batch(
            RUN, {"plant.v.mass": MASSES, "controller.v.k1,controller.h.k1": [-1662.0, -1500.0, -1662.0]},
            keep=["plant.v.position", "plant.at_stop", "controller.v.reference"], keep_interval=0.5, fmus=native_fmus)


def test_samples_are_runs(batch: maglev.Batch) -> None:
    assert len(batch) == 3
    assert batch.failures == (None,) * 3
    for sample in range(3):
        run = batch.run(sample)
        assert run.metrics is not None
        assert batch["overshoot of v"][sample] == max(
            step.overshoot for step in run.metrics.steps if step.axis == "v")
        assert batch["rms error of h"][sample] == run.metrics.rms_errors["h"]
        every = round(0.5 / (run.time[1] - run.time[0]))
        for name, kept in batch.signals.items():
            assert np.array_equal(kept[sample], run[name][::every]), name
        assert run.result.provenance is not None
        assert f"plant.v.mass = {MASSES[sample]:g}" in " ".join(run.result.provenance.changes) or sample == 1
    assert len({*batch["overshoot of v"].tolist()}) == 3


def test_samples_side_by_side_are_runs(native_fmus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that an FMU refuses has a row that says so."""
    for worth in ("WORTH_COMPILING", "FEWEST_BATCHES"):
        monkeypatch.setattr(batches, worth, 1)
    monkeypatch.setattr(batches, "side_by_side", None)
    together: list[int] = []
    fly = RepeatedRun.fly

    def watched(repeated: RepeatedRun, taken: Taken, of_meters: Any) -> Any:
        sizes = fly(repeated, taken, of_meters)
        together.append(taken.status.tolist().count(DONE))
        return sizes

    monkeypatch.setattr(RepeatedRun, "fly", watched)
    found = maglev.batch(RUN, {"plant.v.mass": MASSES, "plant.h.position_start": [0.0, 9.0, 0.001]}, fmus=native_fmus,
                         jobs=1)
    assert together == [2]
    assert found.failures[1] is not None
    for sample in (0, 2):
        run = found.run(sample)
        assert run.metrics is not None and found["rms error of h"][sample] == run.metrics.rms_errors["h"]
    assert found["rms error of h"][0] != found["rms error of h"][2]


def test_names_a_loop_that_cannot_be_compiled(native_fmus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: Any) -> bytes:
        raise ExportError("the C compiler refuses the sources")

    monkeypatch.setattr(batches, "WORTH_COMPILING", 1)
    monkeypatch.setattr(lane_loop, "kept", lambda *_: None)
    monkeypatch.setattr(lane_loop, "library", refused)
    with warns("samples", "FMUs"):
        found = maglev.batch(RUN, {"plant.v.mass": MASSES[:1]}, fmus=native_fmus, jobs=1)
    run = found.run(0)
    assert run.metrics is not None and found["rms error of v"][0] == run.metrics.rms_errors["v"]


def of_ten(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What is run, 40 samples, in batches of ten."""
    monkeypatch.setattr("maglev.many.study_plan.batches_of", lambda _job, count, *_: [
        Batch(first // 10, first, first + 10) for first in range(0, count, 10)])
    return {"scenario": RUN, "values": {"plant.v.mass": np.linspace(4.0, 5.0, 40)}, "metrics": ["rms error of v"],
            "jobs": 2}


def require_done(error: maglev.BatchInterrupted, least: int) -> None:
    """The samples of an interrupted batch that were done are runs, and no others have values."""
    found = error.batch
    done = np.array([why is None for why in found.failures])
    assert least <= done.sum() < 40
    require_facts(error, f"{done.sum()} of 40", "`batch`")
    assert {*found.failures} == {None, "was not run: the batch was interrupted"}
    assert np.array_equal(np.isfinite(found["rms error of v"]), done)
    last = int(np.flatnonzero(done)[-1])
    run = found.run(last)
    assert run.metrics is not None and found["rms error of v"][last] == run.metrics.rms_errors["v"]


@pytest.mark.parametrize("way", WAYS)
def test_finished_samples_are_there_after_an_interrupt(native_fmus: Path, monkeypatch: pytest.MonkeyPatch,
                                                       way: str) -> None:
    only(way, monkeypatch)

    @contextmanager
    def watch(_names: Sequence[str]) -> Iterator[Any]:
        def interrupt(_name: str, _done: int, _all: int) -> None:
            os.kill(os.getpid(), signal.SIGINT)
        yield interrupt

    with pytest.raises(maglev.BatchInterrupted) as error:
        maglev.batch(**of_ten(monkeypatch), watch=watch, fmus=native_fmus)
    require_done(error.value, 10)


def test_samples_of_a_batch_under_way_are_there_after_an_interrupt(native_fmus: Path,
                                                                   monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batches, "WORTH_COMPILING", 1)
    flown, fly = [], RepeatedRun.fly

    def interrupt(*given: Any) -> Any:
        sizes = fly(*given)
        flown.append(1)
        if len(flown) == 3:
            os.kill(os.getpid(), signal.SIGINT)
        return sizes

    monkeypatch.setattr(RepeatedRun, "fly", interrupt)
    with pytest.raises(maglev.BatchInterrupted) as error:
        maglev.batch(**of_ten(monkeypatch), fmus=native_fmus)
    require_done(error.value, 3)


def test_metrics_are_a_dataset(batch: maglev.Batch) -> None:
    found = batch.metrics
    assert found["overshoot of v"].dims == ("sample",)
    assert found["rms error of v"].attrs["units"] == "m"
    assert found["plant.v.mass"].values.tolist() == MASSES.tolist()
    assert found["controller.h.k1"].values.tolist() == [-1662.0, -1500.0, -1662.0]
    assert found["plant.v.position"].dims == ("sample", "time")
    assert found["time"].values[-1] == pytest.approx(12.0)


def test_a_sample_that_fails_is_a_row(native_fmus: Path) -> None:
    found = maglev.batch(RUN, {"controller.sample_time": [5e-4, 7e-4]}, metrics=["overshoot of v"], fmus=native_fmus,
                         jobs=1)
    assert found.failures[0] is None
    assert "sample_time" in str(found.failures[1])
    assert np.isnan(found["overshoot of v"][1])
    assert repr(found) == f"<Batch of {RUN}: 2 samples, 1 not completed, {len(found.columns)} metrics>"
    with raises(UnknownName, "'overshoot of v'"):
        found["overshot of v"]
    for sample in (2, -1, True, 1.0, "a"):
        with raises(UnknownName, "sample", repr(sample), 0, 1):
            found.run(sample)   # type: ignore[arg-type]


@pytest.mark.parametrize(("values", "facts"), [
    ({"plant.v.mass": [4.0, 5.0], "plant.h.mass": [1.5]}, ["plant.v.mass", "2", "plant.h.mass", "1"]),
    ({"plant.v.mass": [-4.0]}, ["plant.v.mass", "1 of 1", "-4", "0.001"]),
    ({"plant.v.mass": [np.nan]}, ["vary[0].values[0]", "nan"]), ({"plant.v.mass": []}, ["vary[0].values", "1"]),
    ({"plant.v.mass": None}, ["vary[0].values", "'list'"]),
    ({"plant.v.mass": np.array(4.0)}, ["vary[0].values", "array(4.)", "list"])])
def test_what_cannot_be_used_is_refused(native_fmus: Path, values: dict[str, list[float]], facts: list[str]) -> None:
    with raises(ScenarioError, *facts):
        maglev.batch(RUN, values, fmus=native_fmus)


def test_refuses_a_table_without_a_repeatable_sample(tmp_path: Path) -> None:
    table, masses = {"name": "mine"}, {"plant.v.mass": [4.0]}
    with raises(ScenarioError, "batch", "scenario", "{'name': 'mine'}"):
        maglev.batch(table, masses)   # type: ignore[arg-type]
    with raises(ScenarioError, "scenario", "{'name': 'mine'}"):
        maglev.study(table, vary=masses, out=tmp_path)   # type: ignore[arg-type]


@pytest.mark.parametrize("jobs", [0, -2, 1.5, True, "2"])
def test_fewer_than_one_job_is_refused(native_fmus: Path, jobs: Any) -> None:
    """Nothing waits for a process that never starts."""
    with raises(ScenarioError, "jobs", repr(jobs), 1):
        maglev.batch(RUN, {"plant.v.mass": [4.0]}, jobs=jobs, fmus=native_fmus)


def test_numbers_and_texts_are_taken_side_by_side(native_fmus: Path) -> None:
    given = ["4 kg", 5.0, np.float64(4.5), np.float32(4.25), np.int64(4), np.array(4.75)]
    found = maglev.batch(RUN, {"plant.v.mass": given}, fmus=native_fmus)
    assert found.settings["plant.v.mass"].tolist() == [4.0, 5.0, 4.5, 4.25, 4.0, 4.75]
    texts = maglev.batch(RUN, {"plant.v.mass": np.array(["4 kg", "5 kg"])}, fmus=native_fmus)
    assert texts.settings["plant.v.mass"].tolist() == [4.0, 5.0]
    with raises(ScenarioError, "metrics", "'overshoot'", "list"):
        maglev.batch(RUN, {"plant.v.mass": [4.0]}, metrics="overshoot", fmus=native_fmus)
    with raises(ScenarioError, "vary[0].values", "[]", 1):
        maglev.batch(RUN, {"plant.v.mass": []}, fmus=native_fmus)


@pytest.mark.parametrize("place", [1, 2])   # 1 is a processor's memory, 2 that of a CUDA device
def test_takes_arrays_of_other_libraries_in_memory_of_this_machine(place: int) -> None:
    own = np.array([4.0, 5.0])

    class Other:
        """An array with nothing but DLPack."""

        def __dlpack_device__(self) -> tuple[int, int]:
            return place, 0

        def __dlpack__(self, **options: Any) -> Any:
            return own.__dlpack__(**options)

    if place == 1:
        assert plain(Other()) == [4.0, 5.0]
    else:
        with raises(ScenarioError, "memory"):
            plain(Other())
