"""The tutorial on a stage of one's own: its commands as they stand, from an empty folder to a picture."""

import os
import re
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "own_stage.md"


def test_commands_lead_to_a_picture(tmp_path: Path) -> None:
    commands = re.findall(r"^    ((?:maglev|sed) .*)$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert [command.split()[1] for command in commands if command.startswith("maglev")] == ["new", "build", "run"]
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    for command in commands:
        if command.startswith("sed"):
            before = (tmp_path / "mine.toml").read_text(encoding="utf-8")
        done = subprocess.run(command, shell=True, cwd=tmp_path, env=environment, capture_output=True, text=True,
                              timeout=300)
        assert done.returncode == 0, done.stderr
        if command.startswith("sed"):
            after = (tmp_path / "mine.toml").read_text(encoding="utf-8")
            changed = sum(one != other for one, other in zip(before.split("\n"), after.split("\n"), strict=True))
            assert changed >= command.count("s/")   # every substitution finds its line
    assert (tmp_path / "results" / "mine-setpoints.png").stat().st_size > 10_000
    assert "held: largest end error" in done.stdout
