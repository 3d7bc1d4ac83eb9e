"""The repository to copy: its commands, run as its CI would run them, notice a controller that changed."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
from command_line import maglev
from example_builds import EXAMPLES

REPOSITORY = EXAMPLES / "ci"
FILES = (".github/workflows/maglev.yml", ".gitlab-ci.yml", "README.md")


def commands(name: str) -> list[list[str]]:
    """Every command of this project in a file, without its name."""
    found = re.findall(r"^ +(?:- (?:run: )?)?maglev ((?:build|run|check) [^#|\n]*)",
                       (REPOSITORY / name).read_text(encoding="utf-8"), re.MULTILINE)
    return [shlex.split(line) for line in found]


def test_github_gitlab_and_the_text_have_the_same_commands() -> None:
    github, gitlab, text = map(commands, FILES)
    assert github == gitlab == text
    assert [command[0] for command in github] == ["build", "run", "check"]


@pytest.mark.usefixtures("slow")
def test_the_repository_of_a_user(fastest_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(REPOSITORY, tmp_path / "mine")
    monkeypatch.chdir(tmp_path / "mine")
    (tmp_path / "mine/fmus").symlink_to(fastest_fmus)   # what the first command builds
    _, run, check = commands(FILES[0])
    assert maglev(*run).exit_code == 0
    assert Path("results/hover.png").is_file()
    assert maglev(*check).exit_code == 0
    assert 'failures="0"' in Path("results/check.xml").read_text()
    controller = Path("controller.py")
    controller.write_text(controller.read_text().replace("Axis(0.02, 30.0)", "Axis(0.02, 33.0)"))
    done = maglev(*check)
    assert done.exit_code == 1
    assert "plant.v.position" in done.output
    assert 'failures="1"' in Path("results/check.xml").read_text()
    update = next(line for line in re.findall(r"`maglev (check [^`]*--update)`", Path("README.md").read_text()))
    done = maglev(*shlex.split(update))
    assert done.exit_code == 0
    assert "moved by at most" in done.output
    assert maglev(*check).exit_code == 0
    controller.write_text(controller.read_text().replace("Axis(0.02, 33.0)", "Axis(0.02, 3.0)"))
    assert maglev(*run).exit_code == 1   # so slow misses the specification
