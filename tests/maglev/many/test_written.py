"""A user's controller, a Python file, in studies: its FMU is built for the workers, and runs what the file runs."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from command_line import error_line
from command_line import maglev as command
from facts import raises, require_facts
from written_controllers import PD, blocks, controller, trial

import maglev
from maglev.files.errors import ControllerError
from maglev.many import batches

pytestmark = pytest.mark.usefixtures("slow")


@pytest.fixture(autouse=True)
def one_batch(monkeypatch: pytest.MonkeyPatch) -> None:
    """Samples of a controller in Python run next to their worker, those of each batch in a process of its own."""
    monkeypatch.setattr(batches, "FEWEST_BATCHES", 1)


RANGES = {"plant.v.friction.coulomb,plant.h.friction.coulomb": "±20 %", "controller.bandwidth": "50:70"}


def simulated(folder: Path, fmus: Path, path: Path, **options: Any) -> maglev.Study:
    return maglev.study(trial(folder), vary=RANGES, samples=3, seed=2, controller=path, fmus=fmus, out=folder / "out",
                        say=lambda _: None, jobs=1, **options)


def test_samples_are_what_the_file_runs(fastest_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = controller(tmp_path)
    study = simulated(tmp_path, fastest_fmus, path)
    frame = study.to_pandas()
    assert len(frame) == 3 and frame["failure"].isna().all()
    nominal = maglev.run(trial(tmp_path), fmus=fastest_fmus, controller=path)
    assert frame["controller.bandwidth"].between(50.0, 70.0).all()
    assert frame["plant.h.friction.coulomb"].nunique() == 3
    words = study.command(2).split()
    assert str(path) in words
    settings = [setting for flag, setting in pairwise(words) if flag == "--set"]
    run = maglev.run(trial(tmp_path), fmus=fastest_fmus, controller=path, set=settings)
    assert run.metrics.rms_errors["v"] == frame["rms error of v"][2] != nominal.metrics.rms_errors["v"]
    assert study.run(2).metrics == run.metrics


def test_what_cannot_be_native_runs_as_python(fastest_fmus: Path, tmp_path: Path) -> None:
    path = controller(tmp_path, ("        self.known = True\n", "        self.known = len([1]) == 1\n"))
    said: list[str] = []
    (tmp_path / "fmus").mkdir()
    (tmp_path / "fmus" / "native").symlink_to(fastest_fmus)
    study = maglev.study(trial(tmp_path), vary={"plant.v.mass": [4.0, 4.5]}, controller=path, kind="native",
                         out=tmp_path, fmus=tmp_path / "fmus", say=said.append, jobs=1)
    assert any("runs in Python" in each and "pd.py, line" in each for each in said)
    assert study.to_pandas()["failure"].isna().all()
    kinds = {fmu["name"]: fmu["kind"] for fmu in study.about["provenance"]["fmus"]}
    assert kinds == {"plant": "native", "controller": "foreign"}   # a user's controller is not ours


@pytest.mark.parametrize("ends", [True, False])
def test_what_is_translated_runs_in_the_loop(native_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                              ends: bool) -> None:
    """But for a step of which nobody knows whether it ends: such a sample can be ended in a process of its own."""
    path = controller(tmp_path, *([] if ends else [(
        "    if current > LARGEST:\n", "    while current > 2.0 * LARGEST:\n        current = 0.5 * current\n"
        "    if current > LARGEST:\n")]))
    (tmp_path / "fmus").mkdir()
    (tmp_path / "fmus" / "native").symlink_to(native_fmus)
    monkeypatch.setattr(batches, "WORTH_COMPILING", 1)
    monkeypatch.setattr(batches, "side_by_side" if ends else "run_in_threads", None)
    found = maglev.batch(trial(tmp_path), {"controller.bandwidth": [50.0, 60.0]}, controller=path, kind="native",
                         fmus=tmp_path / "fmus", jobs=1, say=lambda _: None)
    assert found.failures == (None, None)
    for sample in range(2):
        assert found["rms error of v"][sample] == found.run(sample).metrics.rms_errors["v"]


@pytest.mark.thorough
def test_names_of_ours_are_a_users_to_have(native_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A class Axis and a function saturate: the plant in the same loop has such, too."""
    path = tmp_path / "named.py"
    path.write_text(PD.replace("Rate", "Axis").replace("limited", "saturate"))
    (tmp_path / "fmus").mkdir()
    (tmp_path / "fmus" / "native").symlink_to(native_fmus)
    monkeypatch.setattr(batches, "WORTH_COMPILING", 1)
    monkeypatch.setattr(batches, "side_by_side", None)
    found = maglev.batch(trial(tmp_path), {"controller.bandwidth": [50.0]}, controller=path, kind="native",
                         fmus=tmp_path / "fmus", jobs=1, say=lambda _: None)
    assert found["rms error of v"][0] == found.run(0).metrics.rms_errors["v"]


def test_two_classes_run_in_one_loop(native_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A user's sensor between our plant and a user's controller."""
    (tmp_path / "fmus").mkdir()
    (tmp_path / "fmus" / "native").symlink_to(native_fmus)
    monkeypatch.setattr(batches, "WORTH_COMPILING", 1)
    monkeypatch.setattr(batches, "side_by_side", None)
    found = maglev.batch(blocks(tmp_path) / "sensor.toml", {"sensor.resolution": [0.0, 20e-6]}, jobs=1, kind="native",
                         controller=controller(tmp_path), fmus=tmp_path / "fmus", say=lambda _: None)
    assert found.failures == (None, None)
    assert len({*found["rms error of v"].tolist()}) == 2
    for sample in range(2):
        assert found["rms error of v"][sample] == found.run(sample).metrics.rms_errors["v"]


def test_a_study_file_names_its_controller(fastest_fmus: Path, tmp_path: Path) -> None:
    controller(tmp_path)
    trial(tmp_path)
    (tmp_path / "mine.toml").write_text('name = "mine"\nscenario = "trial.toml"\ncontroller = "pd.py"\n[[vary]]\n'
                                        'set = "controller.damping"\nkind = "list"\nvalues = [0.8, 0.9]\n')
    result = command("study", tmp_path / "mine.toml", "--fmus", fastest_fmus, "--out", tmp_path, "--jobs", "1")
    assert result.exit_code == 0, result.output
    assert "2 of 2 samples pass" in result.output
    assert "--controller" in maglev.Study(tmp_path / "mine.parquet").command(0)


def test_refused(fastest_fmus: Path, tmp_path: Path) -> None:
    path = controller(tmp_path)
    line = error_line(command("study", trial(tmp_path), "--vary", "plant.v.mass=±20%", "--controller", path))
    require_facts(line, "plant.v.mass=±20%", "samples")
    line = error_line(command("study", trial(tmp_path), "--vary", "plant.v.mass=4..5", "--controller", path))
    require_facts(line, "plant.v.mass=4..5", "FROM:TO", "FROM:TO:NUMBER")
    line = error_line(command("study", trial(tmp_path), "--vary", "plant.v.mass=4,5", "--controller",
                              tmp_path / "pid.py"))
    require_facts(line, tmp_path / "pid.py", "'pd.py'")
    names: dict[str, type] = {}
    exec(PD, names)
    with raises(ControllerError, "PD", "file"):
        simulated(tmp_path, fastest_fmus, names["PD"])   # type: ignore[arg-type]
