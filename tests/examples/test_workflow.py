"""The workflow to copy: its commands, run as it would run them, notice a controller that changed."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
from command_line import maglev
from example_builds import EXAMPLES

WORKFLOW = EXAMPLES / "ci" / "check-my-fmu.yml"


def commands() -> list[list[str]]:
    """Every command of this project in the workflow, without its name."""
    return [shlex.split(line) for line in re.findall(r"run: maglev (.*)", WORKFLOW.read_text(encoding="utf-8"))]


@pytest.mark.usefixtures("slow")
def test_the_commands_of_the_workflow(fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    build, check, picture = commands()
    assert maglev(*build).exit_code == 0
    shutil.copy(fmus / "PID2DOF.fmu", "mine.fmu")
    baseline = re.search(r"maglev (check .* --update)", WORKFLOW.read_text(encoding="utf-8"))
    assert baseline
    assert maglev(*shlex.split(baseline[1])).exit_code == 0
    assert maglev(*check).exit_code == 0
    assert Path("results/check.xml").is_file()
    assert maglev(*picture).exit_code == 0
    assert list(Path("results").glob("*.png"))
    shutil.copy(fmus / "LinearRegulator2DOF.fmu", "mine.fmu")
    assert maglev(*check).exit_code == 1


@pytest.mark.usefixtures("slow")
def test_the_commands_of_the_workflow_with_a_controller_of_ones_own(fmus: Path, tmp_path: Path,
                                                                     monkeypatch: pytest.MonkeyPatch) -> None:
    """One of `maglev new controller` has no `tripped`, which the scenario watches."""
    monkeypatch.chdir(tmp_path)
    assert maglev("new", "controller", "mine.py", "--stage", "2dof").exit_code == 0
    _, check, _ = commands()
    baseline = re.search(r"maglev (check .* --update)", WORKFLOW.read_text(encoding="utf-8"))
    assert baseline
    for command in (shlex.split(baseline[1]), check):
        own = [word.replace("mine.fmu", "mine.py") for word in command]
        done = maglev(*own, "--fmus", str(fmus))
        assert done.exit_code == 0, done.output
