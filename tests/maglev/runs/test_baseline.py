"""Baselines: what is written is read bit for bit, and what is malformed is refused with file, line and value."""

from pathlib import Path

import numpy as np
import pytest
from facts import raises
from hypothesis import given
from hypothesis import strategies as st

from maglev.cosim.master import Recording
from maglev.files.errors import BaselineError, CsvError
from maglev.runs.baseline_file import Baseline, baseline_file, from_recording, read_baseline, write_baseline
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import CheckSettings, RunPlan, SignalTolerance

SAMPLES = '"time","plant.y.position","plant.at_stop"\n0.0,0.025,0.0\n0.05,0.0250001,0.0\n0.1,0.0250002,1.0\n'
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
# Names with commas, quotes and letters of every script; a space in front is no name, line breaks are none either.
NAMES = st.text(st.characters(exclude_categories=("C", "Z")), min_size=1).filter(lambda name: name != "time")


@st.composite
def baselines(draw: st.DrawFn) -> Baseline:
    """Baselines with irregular samples."""
    step = draw(st.sampled_from([2e-4, 5e-4, 1e-3, 1 / 3]))
    points = sorted(draw(st.sets(st.integers(0, 10**6), min_size=2, max_size=20)))
    time = step * np.array(points, dtype=np.float64)
    names = draw(st.lists(NAMES, min_size=1, max_size=4, unique=True))
    columns = {name: np.array(draw(st.lists(NUMBERS, min_size=len(time), max_size=len(time)))) for name in names}
    return Baseline("any", time, columns, step)


def plan_of(name: str, step: float = 0.0002) -> RunPlan:
    return load_plan("2dof-setpoints").model_copy(update={"name": name, "step": step})


def bits(values: np.ndarray) -> list[int]:
    return values.view(np.int64).tolist()


@given(baseline=baselines())
def test_reading_gives_the_same_bits(tmp_path_factory: pytest.TempPathFactory, baseline: Baseline) -> None:
    folder = tmp_path_factory.mktemp("baselines") / "made"
    write_baseline(folder, baseline)
    read = read_baseline(folder, plan_of("any", baseline.step))
    assert bits(read.time) == bits(baseline.time)
    assert list(read.columns) == list(baseline.columns)
    assert all(bits(read.columns[name]) == bits(values) for name, values in baseline.columns.items())
    assert (read.name, read.step, read.stop_time, read.digest) == ("any", baseline.step, baseline.time[-1], None)
    assert [path.name for path in folder.iterdir()] == ["any_ref.csv"]


def written(folder: Path, samples: str = SAMPLES) -> Path:
    """Folder with a baseline of this text, named bad."""
    baseline_file(folder, "bad").write_text(samples)
    return folder


def test_the_form_of_the_file(tmp_path: Path) -> None:
    write_baseline(tmp_path / "again", read_baseline(written(tmp_path), plan_of("bad")))
    assert baseline_file(tmp_path / "again", "bad").read_text() == SAMPLES


def test_spaces_and_windows_line_ends_are_read(tmp_path: Path) -> None:
    written(tmp_path, SAMPLES.replace(",", ", ").replace("\n", "\r\n"))
    assert list(read_baseline(tmp_path, plan_of("bad")).columns) == ["plant.y.position", "plant.at_stop"]


@pytest.mark.parametrize(("old", "new", "kind", "facts"), [
    (SAMPLES, "", CsvError, ["empty"]), ('"time"', '"t"', BaselineError, ["'t'", "time"]),
    ("plant.at_stop", "plant.y.position", CsvError, ["row 1", "'plant.y.position'", "2 times"]),
    ("0.05,0.0250001,0.0", "0.05,0.0250001", CsvError, ["row 3", "2 values", "3"]),
    ("0.0250001", "fast", CsvError, ["row 3", "plant.y.position", "'fast'"]),
    ("0.0250001", "nan", CsvError, ["row 3", "plant.y.position", "'nan'"]),
    ("0.0250001", "-inf", CsvError, ["row 3", "plant.y.position", "'-inf'"]),
    ("0.0250001", '"1" 2', CsvError, ["row 3", "plant.y.position", "'1 2'"]),
    ("0.05,", "0.0,", CsvError, ["row 3", "time", "0", "0.0 s"]),
    ("0.05,", "0.05001,", CsvError, ["row 3", "time", "0.05001", "0.0002 s"]),
    ("0.05,0.0250001,0.0\n0.1,0.0250002,1.0\n", "", BaselineError, ["1 sample", "2"])])
def test_malformed_samples(tmp_path: Path, old: str, new: str, kind: type[Exception], facts: list[str]) -> None:
    assert SAMPLES.count(old) == 1
    expect(written(tmp_path, SAMPLES.replace(old, new)), kind, *facts)


def test_missing_and_unreadable_files(tmp_path: Path) -> None:
    file = baseline_file(written(tmp_path), "bad")
    file.write_bytes(b"\xff")
    expect(tmp_path, CsvError, "one column")
    file.unlink()
    expect(tmp_path, BaselineError, "`maglev check --update`")


def expect(folder: Path, kind: type[Exception], *facts: str) -> None:
    """Reading the baseline named bad is refused."""
    with raises(kind, folder / "bad_ref.csv", *facts):
        read_baseline(folder, plan_of("bad"))


def checked(interval: float = 0.05, *signals: str) -> RunPlan:
    """The 2-DOF setpoints with settings of a check."""
    close = SignalTolerance.model_validate({"absolute": 1e-9})
    settings = CheckSettings(interval=interval, signals=dict.fromkeys(signals, close))
    return load_plan("2dof-setpoints").model_copy(update={"check": settings})


def simulated(at_stop: int = 1000, tripped: int = 1000) -> Recording:
    """0.5 s at 0.5 ms, with flags set from these communication points on."""
    k = np.arange(1001, dtype=float)
    return Recording(0.0005 * k, {"plant.v.position": 0.02 + 1e-6 * k,
                                  "plant.at_stop": (k >= at_stop).astype(np.int32),
                                  "controller.tripped": (k >= tripped).astype(np.int32)})


def test_samples_at_the_interval() -> None:
    baseline = from_recording(checked(0.05, "plant.v.position", "plant.at_stop"), 0.0005, simulated(2000, 2000))
    assert baseline.time.tolist() == [0.0005 * k for k in range(0, 1001, 100)]
    assert baseline.columns["plant.v.position"][1] == 0.02 + 1e-6 * 100
    assert baseline.columns["plant.at_stop"].dtype == np.float64
    assert baseline.stop_time == 0.5
    assert (baseline.name, baseline.step) == ("2dof-setpoints", 0.0005)
    assert baseline.digest is None


def test_an_exact_one_has_a_digest_of_all_that_was_recorded() -> None:
    def digest(recording: Recording) -> str:
        exact = from_recording(checked(0.05, "plant.v.position"), 0.0005, recording, exact=True)
        assert exact.digest is not None
        return exact.digest.sha256

    changed = simulated()
    changed.columns["controller.tripped"][-1] = 0    # no signal of the check, and at a sample that it does not take
    later = Recording(np.append(simulated().time[:-1], 0.6), simulated().columns)
    assert digest(simulated()) == digest(simulated())
    assert len({digest(simulated()), digest(changed), digest(later)}) == 3


@pytest.mark.parametrize(("at_stop", "tripped", "last"), [(350, 900, 300), (900, 300, 200), (301, 301, 300)])
def test_ends_before_contact_or_trip(at_stop: int, tripped: int, last: int) -> None:
    baseline = from_recording(checked(0.05, "plant.v.position"), 0.0005, simulated(at_stop, tripped))
    assert baseline.stop_time == 0.0005 * last


def test_goes_through_contact_and_trip_where_the_scenario_says_so() -> None:
    plan = checked(0.05, "plant.at_stop")
    through = plan.model_copy(update={"check": plan.check.model_copy(update={"through_contact": True})})
    baseline = from_recording(through, 0.0005, simulated(350, 900))
    assert baseline.columns["plant.at_stop"].tolist() == [0.0] * 4 + [1.0] * 7


def test_recordings_that_make_no_baseline() -> None:
    for plan, recording, *facts in (
            (checked(), simulated(), "check.signals"),
            (checked(0.05, "plant.v.positon"), simulated(), "plant.v.positon", "'plant.v.position'"),
            (checked(0.0007, "plant.v.position"), simulated(), "check.interval", "0.0007 s", "0.0005 s"),
            (checked(0.05, "plant.v.position"), simulated(at_stop=100), "check.interval", "0.05 s", "1 samples", "2"),
            (checked(0.05, "plant.v.position"), simulated(at_stop=0), "check.interval", "0.05 s", "0 samples", "2")):
        with raises(BaselineError, *facts):
            from_recording(plan, 0.0005, recording)
    recording = simulated()
    recording.columns["plant.v.position"][200] = np.nan
    with raises(BaselineError, "plant.v.position", "0.1 s"):
        from_recording(checked(0.05, "plant.v.position"), 0.0005, recording)


def test_a_baseline_is_small(tmp_path: Path) -> None:
    time = 0.0005 * np.arange(60_000, dtype=float)
    large = Baseline("large", time, {"a": time / 3.0}, 0.0005)
    with raises(BaselineError, tmp_path / "large_ref.csv", 1000000, "check.interval"):
        write_baseline(tmp_path, large)
    assert not list(tmp_path.iterdir())


def test_a_baseline_is_a_plain_csv(tmp_path: Path) -> None:
    """What a spreadsheet has saved again may have lost bits."""
    file = baseline_file(written(tmp_path), "bad")
    file.write_text(file.read_text(encoding="utf-8").replace(",", ";"), encoding="utf-8")
    expect(tmp_path, BaselineError, "semicolons", "`maglev check --update`")
