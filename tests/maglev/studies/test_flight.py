"""A scenario flown again and again on the same instances: bit for bit what single runs give."""

from pathlib import Path

import numpy as np
import pytest
from tiny_study import experiment, scenario

import maglev
from maglev.cosim.master import RunFailed
from maglev.studies.flying.flight import Changes, Flight

CHANGES: list[Changes] = [
    {}, {"plant.v.mass": 5.0}, {"controller.antiwindup": True, "controller.current_limit": 1.5},
    {"reference.h.amplitude": 3.0, "plant.v.position_start": 0.0205}, {"reference.v.end": 0.021}, {},
    {"reference.v.start": 0.0195, "plant.v.position_start": 0.0195}]


def test_flights_are_runs(either_kind: Path, tmp_path: Path) -> None:
    with Flight(experiment(tmp_path, either_kind)) as flight:
        for changes in CHANGES:
            time, columns = flight.fly(changes)
            run = maglev.run(scenario(tmp_path), fmus=either_kind, set=changes)
            every = len(time) // (len(run.time) - 1)
            assert set(columns) == set(run.columns)
            for name, values in columns.items():
                assert np.array_equal(values[::every], run[name]), (changes, name)


def test_a_refusal_leaves_the_next_flight_alone(fastest_fmus: Path, tmp_path: Path) -> None:
    with Flight(experiment(tmp_path, fastest_fmus)) as flight:
        before = {name: values.copy() for name, values in flight.fly({})[1].items()}
        with pytest.raises(RunFailed, match="sample_time"):
            flight.fly({"controller.sample_time": 0.7e-3})
        _, after = flight.fly({})
        assert all(np.array_equal(after[name], values) for name, values in before.items())


@pytest.mark.parametrize(("setting", "words"), [
    ("reference.h.amplitud=2", "nearest is 'amplitude'"), ("reference.w.end=2", "has no axis 'w', nearest is"),
    ("reference.h.end=2 kg", "expected a number, or a quantity in m"),
    ("reference.controller.h.reference.end=2", "is no axis, expected reference.controller.h.reference.amplitude")])
def test_references_that_cannot_be_set_are_refused(setting: str, words: str, fastest_fmus: Path,
                                                   tmp_path: Path) -> None:
    with pytest.raises(maglev.ScenarioError) as refusal:
        maglev.run(scenario(tmp_path), fmus=fastest_fmus, set=[setting])
    assert words in str(refusal.value)


def test_other_references_are_in_the_provenance(fastest_fmus: Path, tmp_path: Path) -> None:
    run = maglev.run(scenario(tmp_path), fmus=fastest_fmus, set={"reference.h.amplitude": 2})
    assert run.result.provenance is not None
    assert run.result.provenance.changes == ("reference.h.amplitude = 2",)
    assert run["controller.h.reference"][-1] == pytest.approx(0.002, abs=1e-15)
