"""Every command that a page prints, as a reader types it: in the order of the page, in his folder, from the wheel."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
from native_builds import require_native_tools
from wheel import ROOT

from maglev.files.errors import installing

TYPED = re.compile(r"^    ((?:maglev|python3?|pip|make|sed|git|dask|cp|mkdir) \S.*)$", re.MULTILINE)
PAGES = {str(path.relative_to(ROOT)): TYPED.findall(path.read_text(encoding="utf-8"))
         for path in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))}
IN_EVERY_RUN = ("README.md",)   # of the suite; the others belong to `make thorough`
ELSEWHERE = ("docs/index.md", "docs/tutorial.md")   # below, and in tests/test_wheel.py, which reads what comes out

# Commands, by how they begin, that are not typed here, and why.
NOT_TYPED = {
    "python3 -m venv .venv": "a clone, and what PyPI has; docs/index.md has the same with the wheel",
    "pip install -e": "the same",
    "make ": "a clone; CI makes them",
    "maglev run --all": "minutes; `make claims-check`",
    "maglev report  ": "minutes; the same runs, and tests/maglev/pages/report has its page",
    "maglev check --junit": "minutes; `make check-built`",
    "maglev check --update": "minutes, and baselines that are written; tests/maglev/runs",
    "maglev build --kind native  ": "minutes for all platforms; tests/fmi_export has each",
    "maglev build --kind native --fmi 3": "the same",
    "maglev build --kind native --target wasm": "the same",
    "maglev build --kind native --target host  ": "minutes; the FMUs of all other tests",
    "maglev build --kind native --from": "the archive of a release; tests/test_release.py has one",
    "maglev run 3dof-setpoints --fmus fmus --kind native": "what one of the lines before it would have built",
    "maglev build  ": "minutes; the FMUs of all other tests",
    "maglev live --out page": "minutes; tests/maglev/pages/live",
    "maglev study ": "the same, or a cluster",
    "maglev tune ": "the same",
    "dask ": "a cluster; tests/maglev/many/test_cluster.py",
    "python -m studies": "a clone, and hours",
    "python tools/published_poles": "a clone, and minutes",
    "maglev region 5dof": "minutes; tests/maglev/analysis",
    "maglev region 3dof x --gap 25mm --synthesise": "the same",
    "maglev report 3dof-parabolas": "minutes; tests/maglev/runs",
    "maglev run 2dof-parabolas": "the same",
    "maglev target": "QEMU; tests/maglev/analysis",
    "python examples/optimal_motion": "CasADi; tests/examples",
    "maglev run examples/optimal_motion": "the same",
    "python examples/gym_levitate.py": "learns; tests/examples",
    "maglev compare 2dof-setpoints --controller Regulator2DOF --controller learned.py": "the same",
}
# A reader's files that a line has to find: FMUs of other tools, their maps, parameter sets.
OF_THE_READER = re.compile(r"(?<![\w./-])(?:mine|theirs|my)\.(?:fmu|ssv)\b|\bports\.toml|\blogged\.txt|\b"
                           r"my_(?:scenario|tuning)\.toml|…")


# What the reader of a page has typed before, on another one.
BEFORE = {"docs/linear_models.md": "maglev new controller mine.py --stage 3dof",
          "docs/live.md": "maglev new stage mine.toml --like 3dof",
          "docs/studies.md": "maglev new scenario mine.toml --stage 3dof"}


def reason(line: str) -> str | None:
    """Why a command is not typed here; None if it is."""
    if found := OF_THE_READER.search(line.partition("#")[0]):
        return f"{found[0]}, which only the reader has; tests/maglev/runs has such"
    return next((why for beginning, why in NOT_TYPED.items() if line.startswith(beginning)), None)


def home_of(page: str, folder: Path) -> Path:
    """Folder of somebody who reads a page: with the files that it prints whole, and those that a clone has."""
    folder.mkdir()
    text = (ROOT / page).read_text(encoding="utf-8")
    for block in re.findall(r"((?:^    .*\n|^\n)+)", text, re.MULTILINE):
        lines = [line[4:] for line in block.splitlines()]
        names = [line for line in lines if line.startswith("name = ")]
        if names and lines[next(k for k, line in enumerate(lines) if line)].startswith("extends"):
            kept = [line for line in lines if not TYPED.match(f"    {line}")]
            name = names[0].split('"')[1]
            (folder / f"{name}.toml").write_text("\n".join(kept) + "\n", encoding="utf-8")
    shutil.copytree(ROOT / "examples", folder / "examples", ignore=shutil.ignore_patterns("__pycache__", "*.fmu"))
    return folder


def typed(line: str, home: Path, programs: Path) -> None:
    """Type a line in a shell that finds these programs first; it has to end well."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment = {**kept, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}", "PIP_NO_INDEX": "1",
                   "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
    done = subprocess.run(["sh", "-c", line], cwd=home, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, f"{line}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"


def test_every_command_is_typed_or_has_a_reason() -> None:
    """And no reason stands for what no page prints."""
    lines = [line for found in PAGES.values() for line in found]
    assert len([line for line in lines if reason(line) is None]) > 40
    assert [beginning for beginning in NOT_TYPED if not any(line.startswith(beginning) for line in lines)] == []


@pytest.mark.parametrize("page", [pytest.param(page, marks=() if page in IN_EVERY_RUN else pytest.mark.thorough)
                                  for page, lines in PAGES.items()
                                  if page not in ELSEWHERE and any(reason(line) is None for line in lines)])
def test_commands_of_a_page_run_as_typed(installed: Path, tmp_path: Path, page: str) -> None:
    require_native_tools()
    home = home_of(page, tmp_path / "home")
    for line in (BEFORE.get(page, "true"), *(line for line in PAGES[page] if reason(line) is None)):
        typed(line, home, installed / "environment" / "bin")


@pytest.mark.thorough
def test_commands_of_the_installation_run_as_typed(installed: Path, tmp_path: Path) -> None:
    """In the folder with the wheel, into an environment in which the dependencies are, and nothing of ours."""
    require_native_tools()
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "new"], check=True)
    programs, others = tmp_path / "new" / "bin", tmp_path / "others"
    others.mkdir()
    for entry in Path(sysconfig.get_path("purelib")).iterdir():
        if "maglev" not in entry.name:
            (others / entry.name).symlink_to(entry)
    packages, = (tmp_path / "new").glob("lib/python*/site-packages")
    (packages / "others.pth").write_text(f"{others}\n", encoding="utf-8")
    (programs / "pip").write_text(f"#!/bin/sh\nexec {programs / 'python'} -m pip \"$@\"\n", encoding="utf-8")
    (programs / "pip").chmod(0o755)
    home = tmp_path / "home"
    home.mkdir()
    wheel, = installed.glob("*.whl")
    shutil.copy(wheel, home)
    lines = [line for line in PAGES["docs/index.md"] if reason(line) is None]
    assert [line.split()[0] for line in lines] == ["pip", "python"]
    assert lines[1] == installing("study"), "as messages say it"
    for line in (*lines, "maglev list"):
        typed(line, home, programs)
    assert (packages / "maglev" / "__init__.py").is_file()
