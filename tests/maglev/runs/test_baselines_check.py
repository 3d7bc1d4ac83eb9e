"""The check of a run: exactly the first deviation is found, and real runs pass or fail with the right message."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from facts import raises
from hypothesis import given
from hypothesis import strategies as st

import maglev
from maglev.cosim.master import Recording, RunFailed
from maglev.files.errors import BaselineError, ScenarioError
from maglev.runs.baseline_check import check_run, renewed, write_updated
from maglev.runs.baseline_file import Baseline, Tolerance, baseline_file, read_baseline, read_digests, write_digests
from maglev.runs.check_outcome import (
    CheckResult,
    DeviatingSample,
    UpdateResult,
    WorstDifference,
    describe,
    exit_code,
    first_deviation,
    samples_of,
    worst,
)
from maglev.runs.preparation import Experiment, prepare
from maglev.runs.replacement import Replacement
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import CheckSettings, RunPlan, SignalTolerance
from maglev.scenario.settings import start_values
from maglev.user.new_controller import new_controller
from maglev.user.source import PythonFile

STEP, EVERY, SAMPLES = 0.0005, 10, 8
SIGNALS = {"plant.v.position": Tolerance(1e-6, 1e-3), "plant.motor.i_a": Tolerance(0.0, 1e-2),
           "plant.at_stop": Tolerance(0.0, 0.0)}

VALUES = st.floats(-1e3, 1e3).map(lambda value: round(value, 6))


@st.composite
def runs(draw: st.DrawFn) -> tuple[Baseline, Recording]:
    """A baseline, and the recording that it was made from."""
    rows = EVERY * SAMPLES
    columns = {name: np.repeat(draw(st.lists(VALUES, min_size=SAMPLES, max_size=SAMPLES)), EVERY) for name in SIGNALS}
    columns["plant.at_stop"] = (columns["plant.at_stop"] > 0.0).astype(np.int32)
    time = STEP * np.arange(rows, dtype=float)
    baseline = Baseline("any", time[::EVERY], {name: values[::EVERY].astype(float) for name, values in columns.items()},
                        STEP)
    return baseline, Recording(time, columns)


def first_of(baseline: Baseline, recording: Recording,
             tolerances: dict[str, Tolerance] = SIGNALS) -> DeviatingSample | None:
    return first_deviation(baseline.time, baseline.columns, samples_of(baseline, recording), tolerances)


def worst_of(baseline: Baseline, recording: Recording) -> dict[str, WorstDifference]:
    return worst(baseline.time, baseline.columns, samples_of(baseline, recording))


@given(run=runs(), signal=st.sampled_from(list(SIGNALS)), sample=st.integers(0, SAMPLES - 1),
       sign=st.sampled_from([-1.0, 1.0]), share=st.floats(0.0, 0.999), excess=st.floats(1.001, 1e6), data=st.data())
def test_first_deviation_is_found_exactly(run: tuple[Baseline, Recording], signal: str, sample: int, sign: float,
                                          share: float, excess: float, data: st.DataObject) -> None:
    """One change within the tolerance is none; one beyond it is found, and later ones do not hide it."""
    baseline, recording = run
    assert first_of(baseline, recording) is None
    assert set(worst_of(baseline, recording).values()) == {(0.0, 0.0)}
    expected = float(baseline.columns[signal][sample])
    allowed = SIGNALS[signal].absolute + SIGNALS[signal].relative * abs(expected)
    column = recording.columns[signal] = recording.columns[signal].astype(float)   # type: ignore[index]
    column[sample * EVERY] = expected + sign * share * allowed
    assert first_of(baseline, recording) is None
    column[sample * EVERY] = got = expected + sign * (excess * allowed if allowed else 1.0)
    found = DeviatingSample(signal, float(baseline.time[sample]), expected, got, allowed)
    assert first_of(baseline, recording) == found
    difference, time = worst_of(baseline, recording)[signal]
    assert (difference, time) == (abs(got - expected), found.time)
    if sample + 1 < SAMPLES:
        later = data.draw(st.integers(sample + 1, SAMPLES - 1))
        other = data.draw(st.sampled_from(list(SIGNALS)))
        recording.columns[other][later * EVERY] = 10**6
        assert first_of(baseline, recording) == found


@given(run=runs(), sample=st.integers(0, SAMPLES - 1), value=st.sampled_from([np.nan, np.inf, -np.inf]))
def test_a_value_that_is_not_finite_deviates(run: tuple[Baseline, Recording], sample: int, value: float) -> None:
    baseline, recording = run
    recording.columns["plant.motor.i_a"][sample * EVERY] = value
    found = first_of(baseline, recording, {**SIGNALS, "plant.motor.i_a": Tolerance(1e300, 0.0)})
    assert found is not None
    assert (found.signal, found.time) == ("plant.motor.i_a", baseline.time[sample])
    assert worst_of(baseline, recording)["plant.motor.i_a"] == (np.inf, baseline.time[sample])


def test_of_several_at_one_time_the_largest_relative_to_its_tolerance() -> None:
    time = STEP * np.arange(3, dtype=float)
    baseline = Baseline("any", time, {"a": np.ones(3), "b": np.ones(3)}, STEP)
    moved = np.array([1.0, 1.01, 1.0])
    for order in (("a", "b"), ("b", "a")):
        ordered = replace(baseline, columns={name: baseline.columns[name] for name in order})
        found = first_of(ordered, Recording(time, {"a": moved, "b": moved}),
                         {"a": Tolerance(1e-3, 0.0), "b": Tolerance(1e-6, 0.0)})
        assert found is not None and found.signal == "b"
        # What may not differ at all goes before what differs a thousand times as much as it may.
        found = first_of(ordered, Recording(time, {"a": moved, "b": moved}),
                         {"a": Tolerance(0.0, 0.0), "b": Tolerance(1e-6, 0.0)})
        assert found is not None and (found.signal, found.allowed) == ("a", 0.0)


def test_recordings_that_cannot_be_compared() -> None:
    time = STEP * np.arange(11, dtype=float)
    baseline = Baseline("any", time, {"plant.y": time}, STEP)
    for recording, *facts in (
            (Recording(time, {"plant.x": time, "q": time}), "plant.y", "'plant.x'"),
            (Recording(time[:-1], {"plant.y": time}), "0.0045 s", "0.005 s"),
            (Recording(2.0 * time, {"plant.y": time}), "point 1", "0.001 s", "0.0005 s")):
        with raises(BaselineError, *facts):
            samples_of(baseline, recording)


def short(**changed: Any) -> RunPlan:
    """The first 1.5 s of the 2-DOF setpoints, in which both axes step once."""
    close = SignalTolerance.model_validate({"absolute": 1e-9})
    signals = dict.fromkeys(("plant.v.position", "plant.h.position"), close)
    settings = CheckSettings(interval=0.05, signals={**signals, "controller.saturated": SignalTolerance()})
    return load_plan("2dof-setpoints").model_copy(update={"stop_time": 1.5, "check": settings, **changed})


def checked(plan: RunPlan, fmus: Path, replaced: dict[str, Replacement], settings: list[str],
            baselines: Path, pictures: Path | None = None) -> CheckResult:
    return check_run(baselines, prepare(plan, fmus, replaced, start_values(settings)), {}, pictures=pictures)


def updated(plan: RunPlan, fmus: Path, replaced: dict[str, Replacement], settings: list[str],
            baselines: Path) -> UpdateResult:
    return write_updated(renewed(baselines, prepare(plan, fmus, replaced, start_values(settings)), {}), baselines)


@pytest.fixture(scope="module")
def fmus(fastest_fmus: Path) -> Path:
    """Those that are run here; a check does not ask for their kind."""
    return fastest_fmus


@pytest.fixture(scope="module")
def committed(fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the baseline of the short run."""
    folder = tmp_path_factory.mktemp("baselines")
    assert updated(short(), fmus, {}, [], folder).status == "new"
    return folder


@pytest.fixture
def baselines(committed: Path, tmp_path: Path) -> Path:
    """A copy of that folder to spoil."""
    return shutil.copytree(committed, tmp_path / "baselines")


def test_the_same_run_passes(fmus: Path, baselines: Path) -> None:
    picture = baselines.parent / "2dof-setpoints.check.png"
    picture.write_text("of an earlier check")
    result = checked(short(), fmus, {}, [], baselines, picture.parent)
    assert not picture.exists()
    digest = read_digests(baselines)["2dof-setpoints"]
    assert digest.samples == 3001 and digest.signals == 27
    assert describe(result) == (f"2dof-setpoints: passed, {digest.signals} signals at 3001 samples equal the baseline "
                                "bit for bit")
    assert (result.status, result.deviation, exit_code([result])) == ("passed", None, 0)
    assert set(result.worst) == set(short().check.signals)
    assert result.units == {"plant.v.position": "m", "plant.h.position": "m", "controller.saturated": ""}


def test_the_package_keeps_no_baseline_of_another_scenario(tmp_path: Path) -> None:
    """Neither next to those that it has, nor over one of the same name."""
    for name in ("mine", "2dof-setpoints"):
        path = tmp_path / f"{name}.toml"
        path.write_text(f'extends = "2dof-push.toml"\nname = "{name}"\n')
        with raises(ScenarioError, path, "baselines"):
            maglev.update(path)


def test_a_changed_parameter_deviates(fmus: Path, baselines: Path) -> None:
    result = checked(short(), fmus, {}, ["plant.C1=14.2142"], baselines, baselines.parent)
    assert (result.status, exit_code([result])) == ("deviated", 1)
    assert (baselines.parent / "2dof-setpoints.check.png").read_bytes().startswith(b"\x89PNG")
    found = result.deviation
    assert found is not None and found.signal == "plant.h.position" and found.allowed == 1e-9
    assert describe(result) == (
        f"2dof-setpoints: deviates first at t = {found.time:.9g} s: plant.h.position expected {found.expected!r} m, "
        f"got {found.got!r} m, allowed 1e-09 m")
    assert result.worst["plant.h.position"].difference >= abs(found.got - found.expected)


def test_the_tolerance_of_the_scenario_decides(fmus: Path, baselines: Path) -> None:
    wide = {name: SignalTolerance.model_validate({"absolute": 0.01 if allowed.absolute == 1e-9 else allowed.absolute})
            for name, allowed in short().check.signals.items()}
    plan = short(check=CheckSettings(interval=0.05, signals=wide))
    write_digests(baselines, {"2dof-setpoints": None})
    result = checked(plan, fmus, {}, ["plant.C1=14.2142"], baselines)
    off = result.worst["plant.h.position"].difference
    assert 1e-9 < off < 0.01
    assert result.message == ("passed, 3 signals at 31 samples to t = 1.5 s are within their tolerances, the closest "
                              f"is plant.h.position, off by {1e3 * off:.3g} of 10 mm; not bit for bit, for "
                              "2dof-setpoints is not in digests.txt")


def test_bits_decide_where_all_that_runs_is_of_this_project(fmus: Path, baselines: Path) -> None:
    """A thousandth of a tolerance is a deviation; the first sample that differs is named."""
    wide = {name: SignalTolerance.model_validate({"absolute": 0.01 if allowed.absolute == 1e-9 else allowed.absolute})
            for name, allowed in short().check.signals.items()}
    plan = short(check=CheckSettings(interval=0.05, signals=wide))
    result = checked(plan, fmus, {}, ["plant.C1=14.2000142"], baselines)
    assert result.status == "deviated" and result.worst["plant.h.position"].difference < 1e-5
    assert result.deviation is not None and result.deviation.allowed == 0.0
    assert result.message.startswith(f"deviates first at t = {result.deviation.time:.9g} s: {result.deviation.signal} ")
    assert result.message.endswith(", expected the same bits")


def test_a_difference_that_no_sample_of_the_table_shows(fmus: Path, baselines: Path) -> None:
    digest = read_digests(baselines)["2dof-setpoints"]
    write_digests(baselines, {"2dof-setpoints": digest._replace(sha256="0" * 64)})
    result = checked(short(), fmus, {}, [], baselines)
    assert (result.status, result.deviation) == ("deviated", None)
    assert result.message == (f"deviates: {digest.signals} signals at 3001 samples do not have the bits of the "
                              "baseline, though those of its table do")
    write_digests(baselines, {"2dof-setpoints": digest._replace(samples=2)})
    result = checked(short(), fmus, {}, [], baselines)
    assert result.status == "deviated" and result.message.endswith(f"; expected {digest.signals} signals at 2 samples")
    (baselines / "digests.txt").write_text("edited\n")
    error(checked(short(), fmus, {}, [], baselines), "digests.txt, line 1: 'edited': expected SHA-256, name, signals")


@pytest.mark.parametrize(("line", "exact"), [
    ("from math import pi, sqrt", True), ("from math import sin", False), ("import math", False),
    ("from statistics import mean", False), ("import numpy", False),
    ("from controller_fmu.safety_trip import exceeds", True)])
def test_whose_bits_every_machine_has(tmp_path: Path, line: str, exact: bool) -> None:
    """A user's file that calls a library's sine is compared within tolerances."""
    path = new_controller(tmp_path / "mine.py", "2dof")
    text = path.read_text()
    assert PythonFile(path).keeps_bits()
    path.write_text(text.replace("\nfrom ", f"\n{line}  # noqa\nfrom ", 1))
    assert PythonFile(path).keeps_bits() == exact


def test_a_baseline_ends_before_contact(fmus: Path, tmp_path: Path) -> None:
    """Without current the mover falls onto its stop."""
    arguments: tuple[Any, ...] = (fmus, {}, ["controller.current_limit=0.01"], tmp_path)
    plan = short(check=short().check.model_copy(update={"interval": 0.01}))
    assert updated(plan, *arguments).status == "new"
    assert 0.02 < read_baseline(tmp_path, plan).stop_time < 1.4
    assert checked(plan, *arguments).status == "passed"
    samples = baseline_file(tmp_path, "2dof-setpoints")
    samples.write_text("".join(samples.read_text().splitlines(keepends=True)[:-1]))
    error(checked(plan, *arguments), "for no stop is touched and nothing trips before")


def test_a_baseline_that_was_cut(fmus: Path, baselines: Path) -> None:
    """Two samples of a run that continues: nothing has deviated so far."""
    samples = baseline_file(baselines, "2dof-setpoints")
    lines = samples.read_text().splitlines(keepends=True)
    samples.write_text("".join(lines[:3]))
    last = lines[2].partition(",")[0]
    error(checked(short(), fmus, {}, [], baselines), f"ends at t = {last} s, expected samples to 1.5 s")


def error(result: CheckResult, message: str) -> None:
    """The run could not be checked, for this reason."""
    assert (result.status, result.deviation, result.worst, exit_code([result])) == ("error", None, {}, 2)
    assert message in result.message and "\n" not in result.message
    assert describe(result) == f"2dof-setpoints: error: {result.message}"


def test_errors_are_results(fmus: Path, baselines: Path, tmp_path: Path) -> None:
    # The FMUs are missing too: that the baseline is refused shows that it is read first.
    nowhere = tmp_path / "nowhere"
    error(checked(short(), nowhere, {}, [], nowhere), "2dof-setpoints_ref.csv: there is no such file")
    error(checked(short(), nowhere, {}, [], baselines), "there is no file")
    error(checked(short(), fmus, {}, ["plant.C9=1"], baselines), "C9")
    error(checked(short(step=0.0003), nowhere, {}, [], baselines), "expected a multiple of the communication step")
    error(checked(short(stop_time=1.0), nowhere, {}, [], baselines), "ends at t = 1.5 s, expected at most the stop")
    often = short().check.model_copy(update={"interval": 0.1})
    error(checked(short(check=often), nowhere, {}, [], baselines), "sample 2 is at t = 0.05 s, expected 0.1 s by")
    more = CheckSettings(interval=0.05, signals={"plant.motor.i_q": SignalTolerance()})
    error(checked(short(check=more), nowhere, {}, [], baselines), "there is no column plant.motor.i_q")
    fewer = CheckSettings(interval=0.05, signals={"plant.v.position": SignalTolerance()})
    error(checked(short(check=fewer), nowhere, {}, [], baselines), "there is a column plant.h.position, expected")
    samples = baseline_file(baselines, "2dof-setpoints")
    samples.unlink()
    samples.mkdir()
    error(checked(short(), fmus, {}, [], baselines), "there is no such file")


def test_a_run_that_ends_early(fmus: Path, baselines: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An FMU that refuses a step is an error."""
    def run(*_: object) -> Recording:
        raise RunFailed("at t = 0.3 s:\nrefused", Recording(np.zeros(1), {}))

    monkeypatch.setattr(Experiment, "run", run)
    error(checked(short(), fmus, {}, [], baselines), "at t = 0.3 s: refused")
    assert updated(short(), fmus, {}, [], baselines).message == "at t = 0.3 s: refused"


def test_update_lists_the_changes(fmus: Path, baselines: Path) -> None:
    old = read_baseline(baselines, short())
    assert describe(updated(short(), fmus, {}, [], baselines)) == (
        "2dof-setpoints: unchanged, 3 signals at 31 samples to t = 1.5 s")
    result = updated(short(stop_time=1.4), fmus, {}, ["plant.C1=14.2142"], baselines)
    assert result.status == "updated"
    difference, time = result.moved["plant.h.position"]
    new = read_baseline(baselines, short())
    changed = np.abs(new.columns["plant.h.position"] - old.columns["plant.h.position"][:len(new.time)])
    assert (difference, time) == (changed.max(), new.time[changed.argmax()])
    assert f"plant.h.position moved by at most {difference!r} m (t = {time:.9g} s)" in result.message
    assert "controller.saturated moved" not in result.message
    assert "it ended at t = 1.5 s" in result.message


def test_update_takes_the_signals_of_the_scenario(fmus: Path, baselines: Path) -> None:
    settings = CheckSettings(interval=0.05, signals={"plant.v.position": SignalTolerance(),
                                                     "plant.motor.i_q": SignalTolerance()})
    result = updated(short(check=settings), fmus, {}, [], baselines)
    for note in ("plant.motor.i_q added", "plant.h.position removed"):
        assert note in result.message
    assert {*read_baseline(baselines, short()).columns} == {"plant.v.position", "plant.motor.i_q"}


def test_update_replaces_unreadable_baselines(fmus: Path, baselines: Path) -> None:
    samples = baseline_file(baselines, "2dof-setpoints")
    intact = samples.read_text()
    samples.write_text(intact.replace("\n0.1,", "\nfast,"))
    result = updated(short(), fmus, {}, [], baselines)
    assert result.status == "replaced"
    assert "2dof-setpoints_ref.csv: row 4, column time is 'fast', expected a finite number" in result.message
    assert samples.read_text() == intact


def test_a_failed_update_leaves_the_old_baseline(fmus: Path, baselines: Path) -> None:
    samples = baseline_file(baselines, "2dof-setpoints")
    intact = samples.read_text()
    settings = CheckSettings(signals={"plant.v.positon": SignalTolerance()})
    result = updated(short(check=settings), fmus, {}, [], baselines)
    assert "nearest is 'v.position'" in describe(result)
    assert exit_code([result]) == 2
    assert samples.read_text() == intact


def test_a_controller_without_signals_of_the_scenario(fmus: Path, tmp_path: Path) -> None:
    """Its baseline lacks what it lacks, and holds it to the rest; one of `new_controller` has no flags at all."""
    mine = {"controller": Replacement(PythonFile(new_controller(tmp_path / "mine.py", "2dof")))}
    result = updated(short(), fmus, mine, [], tmp_path)
    assert result.status == "new", result.message
    assert {*read_baseline(tmp_path, short()).columns} == {"plant.v.position", "plant.h.position"}
    passed = checked(short(), fmus, mine, [], tmp_path)
    assert passed.status == "passed", passed.message
    assert passed.message.endswith("equal the baseline; not compared, for the FMU has no such signals: "
                                   "controller.saturated")
    assert checked(short(), fmus, mine, ["plant.C1=14.3"], tmp_path).status == "deviated"
    # This project's controller has what that baseline lacks.
    error(checked(short(), fmus, {}, [], tmp_path), "there is no column controller.saturated")


def test_exit_code() -> None:
    passed, deviated, failed = (CheckResult("any", status, "", None, {}, 0.0)
                                for status in ("passed", "deviated", "error"))
    assert exit_code([passed, passed]) == 0
    assert exit_code([deviated, passed]) == 1
    assert exit_code([deviated, failed]) == 2
    assert exit_code([]) == 2, "a check of nothing has shown nothing"
