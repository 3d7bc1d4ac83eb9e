"""A repository to begin with: its commands, run as its CI would run them, notice a controller that changed by 0.1 %."""

import re
import shlex
import tomllib
from pathlib import Path

import pytest
from command_line import error_line, maglev
from facts import raises, require_facts

import maglev as tool
from maglev.files.errors import StageError

FILES = (".github/workflows/maglev.yml", ".gitlab-ci.yml", "README.md")

pytestmark = pytest.mark.usefixtures("slow")


def commands(folder: Path, name: str) -> list[list[str]]:
    """Commands of this project that a file of a repository runs, without its name."""
    found = re.findall(r"^ +(?:- (?:run: )?)?maglev ((?:run|check) [^#|\n]*)", (folder / name).read_text("utf-8"),
                       re.MULTILINE)
    return [shlex.split(line) for line in found if "--update" not in line]


@pytest.mark.thorough
@pytest.mark.parametrize("stage", ["2dof", *(pytest.param(name, marks=pytest.mark.thorough)
                                                           for name in ("mine.toml", "3dof", "5dof"))])
def test_the_repository_of_a_user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stage: str) -> None:
    monkeypatch.chdir(tmp_path)
    if stage == "mine.toml":
        tool.new_stage("mine.toml", "2dof")
    made = maglev("new", "repository", "levitate", "--stage", stage)
    assert made.exit_code == 0, made.output
    folder = tmp_path / "levitate"
    assert {path.name for path in tmp_path.iterdir()} <= {"levitate", "mine.toml", "mine-setpoints.toml"}
    github, gitlab, text = (commands(folder, name) for name in FILES)
    assert github == gitlab == text and [command[0] for command in github] == ["run", "check"]
    run, check = github
    monkeypatch.chdir(folder)
    done = maglev(*run)
    assert (done.exit_code, done.stderr) == (0, ""), "a controller to begin with warns of nothing"
    assert Path("results/experiment.png").is_file()
    assert maglev(*check).exit_code == 0
    assert 'failures="0"' in Path("results/check.xml").read_text()
    assert not Path("results/experiment.check.png").exists()
    controller = Path("controller.py")
    before = controller.read_text("utf-8")
    number = re.search(r"Axis\([\d.]+, ([\d.]+)\)", before)
    assert number is not None
    changed = number[0].replace(f" {number[1]})", f" {1.001 * float(number[1])!r})")
    controller.write_text(before.replace(number[0], changed), "utf-8")
    done = maglev(*check)
    assert done.exit_code == 1
    assert re.search(r"experiment: deviates first at t = \S+ s: plant.\S+ expected \S+ m, got \S+ m, expected the same "
                     "bits", done.output), done.output
    assert 'failures="1"' in Path("results/check.xml").read_text()
    assert Path("results/experiment.check.png").stat().st_size > 10000
    done = maglev("check", "experiment.toml", "--baselines", "baselines", "--update")
    assert done.exit_code == 0 and "moved by at most" in done.output
    assert maglev(*check).exit_code == 0
    assert not Path("results/experiment.check.png").exists(), "that of an earlier check goes"


@pytest.mark.thorough
def test_a_specification_that_is_missed_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    folder = tool.new_repository("levitate", "2dof")
    run, _ = commands(folder, FILES[0])
    monkeypatch.chdir(folder)
    controller = Path("controller.py")
    controller.write_text(controller.read_text("utf-8").replace("Axis(0.02, 30.0)", "Axis(0.02, 3.0)"), "utf-8")
    assert maglev(*run).exit_code == 1
    assert tomllib.loads(Path("experiment.toml").read_text("utf-8"))["claims"][0]["target"] == "5 s"


def test_nothing_half_made_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    refused = error_line(maglev("new", "repository", "levitate", "--stage", "4dof"))
    require_facts(refused, "stage", "'4dof'", "2dof, 3dof, 5dof")
    with raises(StageError, "no/levitate", "no"):
        tool.new_repository("no/levitate")
    (tmp_path / "there").mkdir()
    with raises(StageError, "there"):
        tool.new_repository("there")
    tool.new_stage("mine.toml", "2dof")
    text = Path("mine.toml").read_text("utf-8")
    Path("mine.toml").write_text(text.replace("mass = 4.35 ", "mass = 435 "), "utf-8")
    with raises(StageError, "mine.toml", "-76.4 A", "7 A"):
        tool.new_repository("levitate", "mine.toml")
    assert {path.name for path in tmp_path.iterdir()} == {"there", "mine.toml", "mine-setpoints.toml"}
