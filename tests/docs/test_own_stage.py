"""The tutorial on a stage of one's own: its commands as they stand, from an empty folder to a picture."""

import re
import shlex
import subprocess
from pathlib import Path

import pytest
from command_line import maglev

from maglev.descriptions.registry import known_stages

PAGE = Path(__file__).parents[2] / "docs" / "own_stage.md"


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("names", [("PlantMine", "RegulatorMine"), pytest.param((), marks=pytest.mark.thorough)],
                         ids=["what runs", "all"])
def test_commands_lead_to_a_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, names: tuple[str, ...]) -> None:
    """In this process, which has translated the parts of the blocks; the wheel's test types some of them.

    The page builds all FMUs of the stage, `make test` those that its scenario runs.
    """
    monkeypatch.chdir(tmp_path)
    said: list[str] = []
    commands = re.findall(r"^    ((?:maglev|sed) .*)$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert [command.split()[1] for command in commands if command.startswith("maglev")] == [
        "new", "stage", "run", "build"]
    for command in commands:
        if command.startswith("sed"):
            before = Path("mine.toml").read_text(encoding="utf-8")
            subprocess.run(command, shell=True, check=True)
            after = Path("mine.toml").read_text(encoding="utf-8")
            changed = sum(one != other for one, other in zip(before.split("\n"), after.split("\n"), strict=True))
            assert changed >= command.count("s/")   # every substitution finds its line
        else:
            done = maglev(*shlex.split(command, comments=True)[1:], *(names if command.split()[1] == "build" else ()))
            assert done.exit_code == 0, done.output
            said.append(done.stdout)
    known_stages().forget("mine")
    assert Path("results/mine-setpoints.png").stat().st_size > 10_000
    assert "completed: largest end error" in said[2]
