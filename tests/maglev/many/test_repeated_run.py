"""A scenario run again and again on the same instances: bit for bit what single runs give."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from facts import raises
from tiny_study import experiment, scenario

import maglev
from maglev.cosim.master import RunFailed
from maglev.files.arrays import Array
from maglev.many.repeated_run import Changes, RepeatedRun
from maglev.runs.measuring import Found, Measuring
from maglev.scenario.signals import Steps

CHANGES: list[Changes] = [
    {}, {"plant.v.mass": 5.0}, {"controller.antiwindup": True, "controller.current_limit": 1.5},
    {"reference.h.amplitude": 3.0, "plant.v.position_start": 0.0205}, {"reference.v.end": 0.021}, {},
    {"reference.v.start": 0.0195, "plant.v.position_start": 0.0195}]

WEAKER = """
[[signals]]
to = "plant.C1"
kind = "steps"
times = [0, 0.1]
values = [14.2, 14.2]
"""


def test_runs_are_runs(either_kind: Path, tmp_path: Path) -> None:
    with RepeatedRun(experiment(tmp_path, either_kind)) as trial:
        for changes in CHANGES:
            time, columns = trial.run(changes)
            run = maglev.run(scenario(tmp_path), fmus=either_kind, set=changes)
            every = len(time) // (len(run.time) - 1)
            assert set(columns) == set(run.columns)
            for name, values in columns.items():
                assert np.array_equal(values[::every], run[name]), (changes, name)


def test_signals_that_stay_are_made_once(fastest_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: Counter[str] = Counter()
    values_at = Steps.values_at

    def counting(signal: Steps, times: Array) -> Array:
        made[signal.to] += 1
        return values_at(signal, times)

    monkeypatch.setattr(Steps, "values_at", counting)
    with RepeatedRun(experiment(tmp_path, fastest_fmus)) as trial:
        for amplitude in (2.0, 3.0):
            trial.run({"reference.h.amplitude": amplitude})
    assert made == {"controller.h.reference": 3, "controller.v.reference": 1}


def test_what_measures_stays_while_steps_are_at_the_same_samples(native_fmus: Path, tmp_path: Path) -> None:
    """And what was found on a run stays what it was when the next one has other references in their place."""
    own = experiment(tmp_path, native_fmus, WEAKER)
    with RepeatedRun(own, measuring=Measuring(own.plan, own.times)) as trial:
        trial.widen({"reference.plant.C1.end": 12.0, "reference.h.amplitude": 2.0}, build=True)
        first, weaker, larger = (trial.measure([changes])[0] for changes in (
            {}, {"reference.plant.C1.end": 12.0}, {"reference.h.amplitude": 2.0}))
        assert isinstance(first, Found) and isinstance(weaker, Found) and isinstance(larger, Found)
        assert first.meter is weaker.meter is larger.meter
        h = [*own.plan.axes].index("h")
        target, twice = (found.state["target"][0, h] for found in (first, larger))
        assert 2.0 * target == twice != 0.0
        assert first.state["squares"][h] != weaker.state["squares"][h]


def test_a_refusal_leaves_the_next_run_alone(fastest_fmus: Path, tmp_path: Path) -> None:
    with RepeatedRun(experiment(tmp_path, fastest_fmus)) as trial:
        before = {name: values.copy() for name, values in trial.run({})[1].items()}
        with raises(RunFailed, "sample_time", "0.0007 s", "0.0005 s"):
            trial.run({"controller.sample_time": 0.7e-3})
        _, after = trial.run({})
        assert all(np.array_equal(after[name], values) for name, values in before.items())


@pytest.mark.parametrize(("name", "value", "facts"), [
    ("reference.h.amplitud", "2", ["'amplitude'"]), ("reference.w.end", "2", ["'w'", "'v', 'h'"]),
    ("reference.h.end", "2 kg", ["2 kg", "m"]), ("reference.plant.C2.end", "2", ["'plant.C2'", "'v', 'h'"]),
    ("reference.h.time", "-1 s", ["-1 s", "0 s"]), ("reference.h.time", "20 mm", ["20 mm", "s"])])
def test_references_that_cannot_be_set_are_refused(name: str, value: str, facts: list[str], fastest_fmus: Path,
                                                   tmp_path: Path) -> None:
    with raises(maglev.ScenarioError, name, *facts):
        maglev.run(scenario(tmp_path), fmus=fastest_fmus, set=[f"{name}={value}"])


def test_other_references_are_in_the_provenance(fastest_fmus: Path, tmp_path: Path) -> None:
    run = maglev.run(scenario(tmp_path), fmus=fastest_fmus, set={"reference.h.amplitude": 2})
    assert run.result.provenance is not None
    assert run.result.provenance.changes == ("reference.h.amplitude = 2",)
    assert run["controller.h.reference"][-1] == pytest.approx(0.002, abs=1e-15)


def test_size_and_time_of_a_fault(fastest_fmus: Path, tmp_path: Path) -> None:
    """Any signal of steps can be set, by where it leads; in a batch, too, and once more as a run."""
    path = scenario(tmp_path, WEAKER)
    sizes, times = [10.0, 12.0], [0.05, 0.15]
    batch = maglev.batch(path, {"reference.plant.C1.end": sizes, "reference.plant.C1.time": times,
                                "reference.h.time": [0.02, 0.03]}, fmus=fastest_fmus, keep=["plant.h.position"])
    for k, (size, time) in enumerate(zip(sizes, times, strict=True)):
        run = batch.run(k)
        assert np.array_equal(run["plant.C1"], np.where(run.time < time - 1e-9, 14.2, size))
        assert run.time[np.flatnonzero(run["controller.h.reference"])[0]] == pytest.approx(0.02 + 0.01 * k)
        assert np.array_equal(batch.signals["plant.h.position"][k], run["plant.h.position"])
