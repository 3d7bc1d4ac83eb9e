"""Commands about several runs: run with comparisons, report, and check with its exit codes."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from command_line import error_line, maglev
from report_outcomes import outcome

pytestmark = pytest.mark.usefixtures("slow")

LOOPS = Path(__file__).parents[3] / "scenarios" / "loops"

PAIR = """
extends = "{loop}"
name = "hold"
title = "A short hold"
stop_time = "50 ms"
[metrics]
tracking_from = "10 ms"
[[signals]]
to = "controller.v.reference"
kind = "constant"
value = "20 mm"
[check]
interval = "5 ms"
[check.signals]
"plant.v.position" = {{ absolute = "1 nm" }}
[variants.ours]
[[variants.ours.claims]]
text = "Ours is better"
source = "p. 1"
metric = "mean_tracking_error"
relation = "<"
than = "hold-theirs"
[variants.theirs]
[variants.theirs.fmus.controller]
model = "PID2DOF"
"""


@pytest.fixture
def hold(tmp_path: Path) -> Path:
    """A scenario of two variants of 100 communication steps."""
    path = tmp_path / "hold.toml"
    path.write_text(PAIR.format(loop=LOOPS / "2dof.toml"))
    return path


def test_run_of_several_tells_of_each(fastest_fmus: Path, hold: Path, tmp_path: Path) -> None:
    result = maglev("run", hold, "--fmus", fastest_fmus, "--out", tmp_path, "--jobs", "2")
    assert result.exit_code == 0, result.output
    for words in ("Your runs", "hold-ours", "hold-theirs", "0 of 1", "no claims"):
        assert words in result.output
    for name in ("hold-ours.csv", "hold-ours.txt", "hold-theirs.csv", "hold-theirs.txt"):
        assert (tmp_path / name).is_file()
    claims = (tmp_path / "claims.md").read_text()
    assert "| `hold-ours` | Ours is better | p. 1 | mean tracking error < that of hold-theirs | " in claims


def test_a_failed_run_is_reported_and_the_others_complete(fastest_fmus: Path, hold: Path, tmp_path: Path) -> None:
    hold.write_text(hold.read_text() + '[variants.theirs.fmus.controller.start]\n"v.pole" = 5\n')
    result = maglev("run", hold, "--fmus", fastest_fmus, "--out", tmp_path)
    assert result.exit_code == 2
    assert "hold-theirs: " in result.stderr
    assert "v.pole = 5.0" in result.stderr
    assert "did not complete" in result.output
    assert "hold" in (tmp_path / "hold-ours.txt").read_text()
    assert "did not complete" in (tmp_path / "hold-theirs.txt").read_text()
    assert not (tmp_path / "hold-theirs.csv").exists()
    assert "not run" in (tmp_path / "claims.md").read_text()


def test_with_another_fmu_nothing_is_compared(fastest_fmus: Path, hold: Path, tmp_path: Path) -> None:
    result = maglev("run", "2dof-step-1-linear", "--fmus", fastest_fmus, "--out", tmp_path, "--controller",
                    fastest_fmus / "Regulator2DOF.fmu")
    assert result.exit_code == 0, result.output
    assert "controller (Regulator2DOF.fmu) has no setpoint" in result.stderr
    assert not (tmp_path / "2dof-step-1-nonlinear.csv").exists()
    assert not (tmp_path / "claims.md").exists()
    assert "Claims of the thesis" not in result.output
    assert maglev("run", "2dof-step-1-linear", "--fmus", fastest_fmus, "--out", tmp_path, "--controller",
                  fastest_fmus / "Regulator2DOF.fmu", "--claims", "thesis").output.count("Claims of the thesis") == 1
    assert "not run" in (tmp_path / "claims.md").read_text()


def test_a_scenario_of_ones_own_has_no_claims_of_the_thesis(fastest_fmus: Path, tmp_path: Path) -> None:
    """Unless it is asked for, not even the runs are made that these compare with."""
    path = tmp_path / "mine.toml"
    path.write_text('extends = "2dof-step-1.toml"\nname = "mine"\ntitle = "Mine"\n', encoding="utf-8")
    runs = {words: json.loads(maglev("run", path, "--fmus", fastest_fmus, "--out", tmp_path, "--json", *words).stdout)
            ["runs"] for words in ((), ("--claims", "thesis"))}
    assert not any(run["claims"] for run in runs[()].values())
    assert any(run["claims"] for run in runs["--claims", "thesis"].values())
    assert all(name.startswith("mine") for name in runs[()])


def test_a_run_ends_with_verdicts_and_files(fastest_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
                                            ) -> None:
    """Steps, then verdicts, then files; its page is opened, the bounds of figures are in its text."""
    opened: list[str] = []

    def browser(address: str) -> bool:
        opened.append(address)
        return True

    monkeypatch.setattr("webbrowser.open", browser)
    done = maglev("run", "3dof-setpoints", "--fmus", fastest_fmus, "--out", tmp_path, "--open")
    said, files = done.stdout.rsplit("\n", 2)[:2]
    assert max(map(len, said.splitlines())) <= 80
    places = [done.stdout.index(words) for words in (
        "Steps: settling", "Errors over", "Currents:", "Claims of the thesis", "* not independent: the claim was used")]
    assert places == sorted(places)
    assert done.stdout.count("not independent") == 1
    assert " ".join(said.split()).endswith(
        "completed: largest end error 34.6 µm on z; 5 of 5 claims hold; 9 of 12 axis-range checks met")
    assert files.startswith("results: ") and files.endswith(str(tmp_path / "3dof-setpoints.html"))
    assert opened == [(tmp_path / "3dof-setpoints.html").as_uri()]
    bound = "The data end between"
    assert bound not in done.stdout and bound in (tmp_path / "3dof-setpoints.txt").read_text()
    assert "maglev run" not in done.stderr


@pytest.mark.usefixtures("slow")
def test_a_study_without_a_file_shows_each_of_its_values(fastest_fmus: Path, hold: Path, tmp_path: Path) -> None:
    """By its name before no more, which says the one of now."""
    path = tmp_path / "short.toml"
    path.write_text(hold.read_text().partition("[variants.ours]")[0])
    places = ("--fmus", fastest_fmus, "--out", tmp_path, "--jobs", "1", "--set", "plant.h.mass=4.4")
    done = maglev("study", path, *places, "--vary", "plant.v.mass=4.3:4.4:2")
    assert done.exit_code == 0, done.output
    rows = [re.split(" {2,}", line.strip())[:2] for line in done.stdout.partition("───\n")[2].splitlines()[:2]]
    assert rows == [["0", "4.3 kg"], ["1", "4.4 kg"]]
    assert "samples: needs vary" in error_line(maglev("study", "payload-friction", "--samples", "3"))


def test_report(fastest_fmus: Path, hold: Path, tmp_path: Path) -> None:
    result = maglev("report", hold, "--fmus", fastest_fmus, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    page = (tmp_path / "report.html").read_text()
    assert "Ours is better" in page
    assert (tmp_path / "hold-ours.csv").is_file()


@pytest.fixture
def procedure(monkeypatch: pytest.MonkeyPatch) -> None:
    """A procedure that every run belongs to."""
    monkeypatch.setattr("maglev.api.running.evaluate_all", lambda *_: [outcome()])


def test_run_prints_the_results_of_a_procedure(fastest_fmus: Path, hold: Path, tmp_path: Path, procedure: None) -> None:
    result = maglev("run", hold, "--fmus", fastest_fmus, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    words = ("hold-ours", "1 procedure", "2dof-thrust: Thrust by parabolas", "Constants",
             "note: C3 is not excited.", "The cogging force is 2 N", "results: ")
    places = [result.output.index(text) for text in words]
    assert places == sorted(places)
    assert "2dof-thrust.curves.csv" in result.output.replace("\n", "")
    text = (tmp_path / "2dof-thrust.txt").read_text()
    assert text in result.output
    assert (tmp_path / "2dof-thrust.curves.csv").read_text().startswith("figure,panel,curve,x,y,margin\n4.9,")
    claims = (tmp_path / "claims.md").read_text()
    assert "\n1 claim on 0 runs and 1 procedure.\n" in claims
    assert "| `2dof-thrust` | The cogging force is 2 N | p. 34, Fig. 4.9 | " in claims


def test_a_single_run_prints_the_results_of_its_procedure(fastest_fmus: Path, hold: Path, tmp_path: Path,
                                                          procedure: None) -> None:
    hold.write_text(hold.read_text().partition("[variants.ours]")[0])
    result = maglev("run", hold, "--fmus", fastest_fmus, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert result.output.index("hold: A short hold") < result.output.index("2dof-thrust: Thrust by parabolas")


def test_report_shows_results_of_a_procedure(fastest_fmus: Path, hold: Path, tmp_path: Path, procedure: None) -> None:
    result = maglev("report", hold, "--fmus", fastest_fmus, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    page = (tmp_path / "report.html").read_text()
    for text in ('id="figure-4-9-2dof-thrust"', "C3 is not excited.", "The cogging force is 2 N"):
        assert text in page
    assert "\n1 claim on 0 runs and 1 procedure.\n" in (tmp_path / "claims.md").read_text()


def check(hold: Path, fmus: Path, *arguments: str | Path) -> list[str | Path]:
    return ["check", hold, "--fmus", fmus, "--baselines", hold.parent / "baselines", *arguments]


def test_check_update_pass_and_deviate(fastest_fmus: Path, hold: Path, tmp_path: Path) -> None:
    missing = maglev(*check(hold, fastest_fmus))
    assert missing.exit_code == 2
    assert "hold-ours_ref.csv: there is no such file" in missing.output
    new = maglev(*check(hold, fastest_fmus, "--update"))
    assert new.exit_code == 0
    assert "hold-ours: new, 2 signals at 11 samples to t = 0.05 s" in new.output
    junit = tmp_path / "check.xml"
    passed = maglev(*check(hold, fastest_fmus, "--junit", junit, "--jobs", "2"))
    assert passed.exit_code == 0
    assert passed.output.count(": passed, ") == 2
    assert ElementTree.parse(junit).getroot().attrib["failures"] == "0"
    deviated = maglev(*check(hold, fastest_fmus, "--junit", junit, "--set", "plant.v.mass=5"))
    assert deviated.exit_code == 1
    assert "hold-theirs: deviates first at t = 0.0" in deviated.output
    assert "plant.v.position expected 0.0" in deviated.output
    assert ElementTree.parse(junit).getroot().attrib["failures"] == "2"
    moved = maglev(*check(hold, fastest_fmus, "--update", "--set", "plant.v.mass=5"))
    assert moved.exit_code == 0
    assert "plant.v.position moved by at most" in moved.output


def test_check_of_another_controller(fastest_fmus: Path, hold: Path) -> None:
    assert maglev(*check(hold, fastest_fmus, "--update")).exit_code == 0
    result = maglev(*check(hold, fastest_fmus, "--controller", fastest_fmus / "PID2DOF.fmu"))
    assert result.exit_code == 1
    assert "hold-ours: deviates first" in result.output
    assert "hold-theirs: passed" in result.output


def test_check_refusals(fastest_fmus: Path, hold: Path) -> None:
    assert maglev(*check(hold, fastest_fmus, "--update")).exit_code == 0
    assert "--junit" in error_line(maglev(*check(hold, fastest_fmus, "--update", "--junit", "x.xml")))
    assert "there is no scenario 'hold'" in error_line(maglev("check", "hold", "--fmus", fastest_fmus))
    assert "there is no file missing.fmu" in error_line(maglev(*check(hold, fastest_fmus, "--plant", "missing.fmu")))
    wrong = maglev(*check(hold, fastest_fmus, "--plant", fastest_fmus / "Plant3DOF.fmu"))
    assert wrong.exit_code == 2
    assert wrong.output.count("error: ") == 2
    hold.write_text(hold.read_text().replace("[check.signals]", '[check.signals]\n"plant.v.positon" = {}'))
    misspelt = maglev(*check(hold, fastest_fmus, "--update"))
    assert misspelt.exit_code == 2
    assert "nearest is 'v.position'" in misspelt.output


@pytest.mark.parametrize(("text", "message"), [
    ("", "is empty, expected a CSV file"), ("time,plant.v.position\n0,x\n1,2\n", "expected a finite number"),
    ("\0", "hold-ours_ref.csv")])
def test_a_corrupt_baseline_is_an_error(fastest_fmus: Path, hold: Path, text: str, message: str) -> None:
    assert maglev(*check(hold, fastest_fmus, "--update")).exit_code == 0
    (hold.parent / "baselines" / "hold-ours_ref.csv").write_text(text)
    result = maglev(*check(hold, fastest_fmus))
    assert result.exit_code == 2
    assert message in result.output
    assert "hold-theirs: passed" in result.output


def test_a_model_goes_over_the_scenario_and_set_over_the_model(fastest_fmus: Path, hold: Path, tmp_path: Path) -> None:
    assert maglev(*check(hold, fastest_fmus, "--update")).exit_code == 0
    model = tmp_path / "model.toml"
    model.write_text('stage = "2dof"\n[plant]\nC1 = 14.2\nC2 = 800.0\n[controller]\nC1 = 14.2\n')
    deviated = maglev(*check(hold, fastest_fmus, "--model", model))
    assert deviated.exit_code == 1
    assert maglev(*check(hold, fastest_fmus, "--model", model, "--set", "plant.C2=791")).exit_code == 0
    assert "expected constants of the stage 3dof" in error_line(maglev("run", "3dof-setpoints", "--model", model))
    assert "expected runs of one stage" in error_line(maglev("run", "3dof-smooth", "2dof-smooth", "--model", model))
