"""The wheel: what it installs, and the command from it, in the folder of a user who has modules of common names."""

import json
import re
import shlex
import zipfile
from pathlib import Path

import pytest
from native_builds import require_native_tools
from wheel import ROOT, ran, said

from maglev.files.packages import PACKAGES

# What users have in their folders; a name of ours that is one of these would run their code.
COMMON_NAMES = ("messages", "sampling", "scenarios", "identification", "build", "units", "errors", "report", "study")

EXCITED = """
extends = ["loops/2dof.toml", "references/2dof-excitation.toml"]
name = "excited"
title = "An excited stage"
stop_time = "2 s"
"""


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """Folder of a user with modules of common names, none of which may be imported."""
    folder = tmp_path / "home"
    folder.mkdir()
    for name in COMMON_NAMES:
        (folder / f"{name}.py").write_text(f"raise ImportError('{name}.py of the user, expected a module of ours')\n")
    (folder / "excited.toml").write_text(EXCITED)
    return folder


def command(installed: Path, home: Path, *arguments: str | Path) -> str:
    """What the command writes, run as a module: the interpreter then looks for every import in the folder first."""
    return said(installed, home, "python", "-m", "maglev", *arguments)


def test_contents(installed: Path) -> None:
    """Our packages and nothing next to them, and of these packages every file."""
    wheel, = installed.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if not name.endswith("/")}
        information, = {name.split("/")[0] for name in names if ".dist-info/" in name}
        top_level = archive.read(f"{information}/top_level.txt").decode().split()
    assert set(top_level) == {*PACKAGES}
    assert {name.split("/")[0] for name in names} == {*PACKAGES, information}
    source = installed / "source"
    expected = {path.relative_to(source).as_posix() for package in [*PACKAGES, "stages", "scenarios"]
                for path in (source / package).rglob("*") if path.is_file()}
    assert {name for name in names if not name.startswith(information)} == {
        f"maglev/{name}" if name.startswith(("stages/", "scenarios/")) else name for name in expected}


def test_it_is_the_installed_one_that_runs(installed: Path, home: Path) -> None:
    code = "import maglev, maglev.scenario.catalogue; print(maglev.__file__, *maglev.scenario.catalogue.project())"
    found = said(installed, home, "python", "-c", code)
    assert found.startswith(str(installed / "environment"))
    assert "Permission is hereby granted" in found, "the licence that goes into every FMU"


def test_entry_point(installed: Path, home: Path) -> None:
    found = said(installed, home, "maglev", "list")
    assert "Regulator" in found
    assert "3dof-setpoints-improved" in found


@pytest.fixture
def clash(home: Path) -> Path:
    """Folder of a user whose own packages have names of ours, as the layout of pythonfmu suggests."""
    (home / "plant_fmu").mkdir()
    for file in ("plant_fmu/__init__.py", "controller_fmu.py"):
        (home / file).write_text("raise ImportError('executed, expected to be refused before')\n", encoding="utf-8")
    return home


def test_the_command_runs_next_to_packages_with_the_same_names(installed: Path, clash: Path) -> None:
    """Its own folder comes first where Python imports, not the user's; so does what an FMU carries."""
    said(installed, clash, "maglev", "build", "Plant2DOF", "PID2DOF")
    (clash / "excited.toml").write_text(EXCITED.replace("2 s", "0.2 s"))
    said(installed, clash, "maglev", "run", "excited.toml", "--fmus", "fmus")
    assert (clash / "results" / "excited.csv").is_file()
    assert "Regulator" in said(installed, clash, "python", "-P", "-m", "maglev", "list")


@pytest.mark.parametrize("python", [["-m", "maglev", "run", "excited.toml"], ["-c", "import maglev; maglev.run('x')"],
                                    ["-c", "import maglev.gym"], ["-c", "from maglev import Run"]])
def test_packages_of_our_names_are_refused(installed: Path, clash: Path, python: list[str]) -> None:
    """By one line, before anything of theirs or ours is executed: it says which is in the way, and what to do."""
    done = ran(installed, clash, "python", *python)
    last = done.stderr.strip().splitlines()[-1]
    assert done.returncode == (2 if "-m" in python else 1)
    assert len(done.stderr.strip().splitlines()) == 1 or "-m" not in python
    packages, = (installed / "environment").glob("lib/python*/site-packages")
    assert f"import plant_fmu: finds {clash / 'plant_fmu' / '__init__.py'}, expected the package of maglev-fmus in " \
           f"{packages / 'plant_fmu'}: rename the other one" in last
    assert not (clash / "results").exists()


@pytest.mark.thorough
def test_build_run_report_identify(installed: Path, home: Path) -> None:
    command(installed, home, "build", "Plant2DOF", "PID2DOF")
    assert {path.name for path in (home / "fmus").iterdir()} == {"Plant2DOF.fmu", "PID2DOF.fmu"}
    built = ["--fmus", "fmus"]   # native ones would take their time; README.md's commands build such, from the wheel
    assert "An excited stage" in command(installed, home, "report", "excited.toml", *built)
    assert "An excited stage" in (home / "results" / "report.html").read_text(encoding="utf-8")
    command(installed, home, "run", "excited.toml", "--out", "again", *built)
    assert (home / "again" / "excited.csv").read_bytes() == (home / "results" / "excited.csv").read_bytes()
    assert "C1" in command(installed, home, "identify", "again/excited.csv")


@pytest.mark.thorough
def test_an_edited_installation_runs_no_run_of_the_package(installed: Path, home: Path, fastest_fmus: Path) -> None:
    """Whatever is edited is said, in files that make no part of an FMU, too."""
    packages, = (installed / "environment").glob("lib/python*/site-packages")
    found = []
    for file in (None, "maglev/runs/metrics.py", "maglev/scenarios/gains/2dof.toml"):
        before = (packages / file).read_bytes() if file else b""
        try:
            if file:
                (packages / file).write_bytes(before + b"\n# a comment\n")
            said = json.loads(command(installed, home, "run", "2dof-step-1-nonlinear", "--fmus", str(fastest_fmus),
                                      "--json", "--claims", "thesis"))
        finally:
            if file:
                (packages / file).write_bytes(before)
        run = said["runs"]["2dof-step-1-nonlinear"]
        found.append(run["provenance"])
        assert ("modified run" in {claim["verdict"] for claim in run["claims"]}) is (file is not None)
    assert [each["departures"] for each in found] == [
        [], ["maglev/runs/metrics.py is not as it was installed"],
        ["maglev/scenarios/gains/2dof.toml is not as it was installed"]]
    assert len({each["code"] for each in found}) == 2   # data are no code


@pytest.mark.thorough
def test_a_stage_of_ones_own(installed: Path, home: Path) -> None:
    """Its modules are written by the templates that are installed, and its FMUs are known as made here."""
    command(installed, home, "new", "stage", "mine.toml", "--like", "3dof")
    command(installed, home, "build", "--stage", "mine.toml", "PlantMine", "RegulatorMine")
    code = ("from pathlib import Path\nimport maglev\nfrom maglev.descriptions.own_fmus import built_here\n"
            "print([built_here(path) for path in sorted(Path('fmus').iterdir())])\nmaglev.know_stage('mine.toml')\n"
            "print([built_here(path) for path in sorted(Path('fmus').iterdir())])")
    assert said(installed, home, "python", "-c", code).splitlines() == ["[False, False]", "[True, True]"]
    command(installed, home, "new", "controller", "law.py", "--stage", "mine.toml")
    command(installed, home, "build", "law.py")


def tutorial_commands() -> list[str]:
    """The lines of the tutorial that a reader types; other indented lines are output."""
    text = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
    return re.findall(r"^    ((?:maglev|sed) .+)$", text, re.MULTILINE)


@pytest.mark.thorough
def test_the_ten_minutes_of_the_tutorial(installed: Path, home: Path) -> None:
    """Every line of the tutorial as it stands there, with the wheel, in a folder of somebody else."""
    require_native_tools()
    commands = tutorial_commands()
    assert len(commands) == 8
    for line in commands:
        program, *rest = shlex.split(line)
        if program == "sed":
            pattern, source, _, target = rest
            _, old, new, _ = pattern.split("/")
            text = (home / source).read_text(encoding="utf-8")
            assert text.count(old) == 1
            (home / target).write_text(text.replace(old, new), encoding="utf-8")
        else:
            said(installed, home, program, *rest)
    results = home / "results"
    compared = json.loads((results / "3dof-setpoints.compare.json").read_text(encoding="utf-8"))
    assert list(compared["runs"]) == ["Regulator3DOF", "mine", "stiffer"]
    settling = [row["values"] for row in compared["rows"]
                if (row["quantity"], row["of"]) == ("settling time to 10 µm", "y")]
    tutorial = " ".join((ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8").split())
    stated = re.search(r"`mine` needs ([\d.]+) s in its worst step, `stiffer` ([\d.]+) s and the regulator of the "
                       r"thesis ([\d.]+) s", tutorial)
    assert stated
    for name, seconds in zip(("mine", "stiffer", "Regulator3DOF"), stated.groups(), strict=True):
        assert max(values[name] for values in settling) == pytest.approx(float(seconds), abs=0.005), name
    assert {path.suffix for path in results.glob("*.compare.*")} == {".json", ".txt", ".png", ".html"}
    last = json.loads((results / "3dof-setpoints.json").read_text(encoding="utf-8"))
    assert last["metrics"]["stop_contact"] is not None
    assert (home / "fmus" / "native" / "MINE.fmu").is_file()


@pytest.mark.thorough
def test_check_against_a_baseline_of_the_package(installed: Path, home: Path, fmus: Path) -> None:
    assert "passed" in command(installed, home, "check", "2dof-smooth-nonlinear", "--fmus", fmus)
