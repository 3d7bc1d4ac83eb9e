"""What makes many runs, draws them or keeps them takes a stage of one's own by its scenario."""

from pathlib import Path

import pytest
from command_line import maglev as command
from facts import raises

import maglev
from maglev.descriptions.registry import known_stages
from maglev.user.new_stage import new_stage

pytestmark = pytest.mark.usefixtures("slow")

# With gains that leave a tuning something to find: those designed for the stage do not.
SHORT = """extends = ["kite-setpoints.toml", "gains/2dof.toml"]
name = "short"
stop_time = "2.5 s"
"""

BRIEF = 'extends = "short.toml"\nname = "brief"\nstop_time = "0.5 s"\n'

STUDY = """name = "payload"
scenario = "short.toml"
[[vary]]
set = ["plant.v.mass"]
mode = "offset"
kind = "list"
values = [0, 0.2]
"""

TUNING = """name = "quicker"
scenario = "short.toml"
minimise = ["settling time to 100 um of h"]
population = 5
generations = 2
fresh = 1
[[poles]]
of = ["controller.h"]
rate = { low = 5, high = 20 }
damping = { low = 0.5, high = 1.2 }
[[vary]]
set = "plant.h.mass"
kind = "percent"
percent = "5 %"
[design]
kind = "latin hypercube"
samples = 2
"""


@pytest.fixture(scope="module")
def folder(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a user with a stage of a shorter pole pitch."""
    folder = tmp_path_factory.mktemp("kite")
    path, _ = new_stage(folder / "kite.toml", like="2dof")
    path.write_text(path.read_text(encoding="utf-8").replace("pole_pitch = 0.05715", "pole_pitch = 0.05"),
                    encoding="utf-8")
    for name, text in (("short", SHORT), ("brief", BRIEF), ("payload", STUDY), ("quicker", TUNING)):
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture(autouse=True)
def here(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)


@pytest.mark.thorough
def test_study() -> None:
    """A sample is the run with its values."""
    frame = maglev.study("payload.toml", jobs=1).to_pandas()
    run = maglev.run("short.toml", set={"plant.v.mass": 4.55})
    assert frame["failed"].tolist() == [False, False]
    assert frame["overshoot of v"][1] == max(step.overshoot for step in run.metrics.steps if step.axis == "v")
    assert frame["overshoot of v"][0] != frame["overshoot of v"][1]


@pytest.mark.thorough
def test_tune() -> None:
    found = maglev.tune("quicker.toml", jobs=1)
    tuned = 'extends = ["short.toml", "results/quicker.toml"]\nname = "tuned"\n'
    Path("tuned.toml").write_text(tuned, encoding="utf-8")
    before, after = maglev.run("short.toml"), maglev.run("tuned.toml")
    assert after.plan.fmus["controller"].start["h.k1"].value == found.parameters["controller.h.k1"]
    assert settling(after) < settling(before)


def settling(run: maglev.Run) -> float:
    """Time (s) at which h is within 0.1 mm of its reference for good."""
    error = abs(run["plant.h.position"] - run["controller.h.reference"])
    return float(run.time[error > 1e-4].max())


def test_baselines() -> None:
    """What the stage does is kept, and another guide is noticed."""
    maglev.update(["brief.toml"], baselines="baselines", kind="python")
    same, = maglev.check(["brief.toml"], baselines="baselines", kind="python")
    assert same.status == "passed"
    other, = maglev.check(["brief.toml"], baselines="baselines", kind="python", set={"plant.h.friction.coulomb": 1.0})
    assert other.status == "deviated"


def test_report() -> None:
    assert command("report", "brief.toml", "--kind", "python").exit_code == 0
    assert "stage kite" in Path("results/report.html").read_text(encoding="utf-8")


def test_list() -> None:
    """What is built of it in a folder, and what is not."""
    maglev.build(["PlantKite", "RegulatorKite"], stage="kite.toml")
    said = command("list", "--stage", "kite.toml").output
    lines = [line for line in said.splitlines() if not line.startswith(" ")]   # the others go on with a text
    built = {row[0]: row[1] for line in lines if len(row := line.split()) > 1}
    assert built["PlantKite"] == built["RegulatorKite"] == "Python"
    assert built["PIDKite"] == built["StageKite"] == "no"
    assert not any("3DOF" in name for name in built)


def test_without_its_description_its_fmus_are_not_known() -> None:
    known_stages().forget("kite")
    with raises(maglev.BuildError, "PlantKite", "stage", "mine.toml"):
        maglev.build("PlantKite")
    with raises(maglev.LinearModelError, "'PlantKite'", "stage", "mine.toml"):
        maglev.linearise("PlantKite", {"v": 0.02})


@pytest.mark.thorough
def test_online_estimator() -> None:
    """It stands next to the loop as ours do, and moves the attraction from half of it to what it is."""
    axes = "".join(f'"{axis}.measured" = "plant.{axis}.encoder"\n' for axis in "vh")
    currents = "".join(f'"motor.i_{part}" = "plant.motor.i_{part}"\n' for part in "dq")
    text = 'extends = "short.toml"\nname = "estimated"\n[fmus.estimator]\nmodel = "EstimatorKite"\n'
    Path("estimated.toml").write_text(f"{text}[fmus.estimator.inputs]\n{axes}{currents}", encoding="utf-8")
    run = maglev.run("estimated.toml")
    plant = maglev.know_stage("kite.toml").plant.attraction
    assert run["estimator.C2"][0] == pytest.approx(0.5 * plant)
    assert run["estimator.C2"][-1] == pytest.approx(plant, rel=0.1)
