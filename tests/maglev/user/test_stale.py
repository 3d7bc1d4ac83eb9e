"""After an edit of a stage's description, whoever runs FMUs of a folder says that they are of before."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from command_line import maglev as command
from facts import raises, warns
from typer.testing import Result

import maglev
from maglev.cli.app import app
from maglev.descriptions.own_fmus import stale
from maglev.descriptions.registry import known_stages
from maglev.files.errors import FmuError
from maglev.user.adoption import know_stage

pytestmark = pytest.mark.usefixtures("slow")

SHORT = """
extends = "mine-setpoints.toml"
name = "short"
stop_time = "0.1 s"

[check]
interval = "10 ms"
"""

STUDY = """
name = "masses"
scenario = "short.toml"
[[vary]]
set = "plant.v.mass"
kind = "list"
values = [4.4]
"""

TUNING = """
name = "searched"
scenario = "short.toml"
minimise = ["rms error of h"]
generations = 1
population = 5
[[search]]
set = ["controller.h.k1"]
low = -1300
high = -1200
"""

# How each command that has FMUs of a folder is called, what it exits with where they are stale, and where it says so.
COMMANDS: dict[str, tuple[list[str], int]] = {
    "list": (["--stage", "mine.toml"], 0),
    "run": (["short.toml"], 0),
    "report": (["short.toml"], 0),
    "check": (["short.toml", "--baselines", "."], 2),
    "compare": (["short.toml", "--controller", "RegulatorMine"], 0),
    "study": (["study.toml"], 0),
    "tune": (["tuning.toml"], 2),   # refused, as soon as it has said it
    "linearise": (["PlantMine", "law.py", "--stage", "mine.toml", "--at", "v=20mm"], 2),
    "region": (["mine.toml", "h", "--gap", "20mm"], 2),
    "live": (["mine.toml"], 2),
    "pack ref": (["fmus/RegulatorMine.fmu", "short.toml", "--as", "controller", "--out", "packed.fmu"], 2)}
BUILDS = {"build"}   # what makes them again
EMULATED = {"target"}   # what compares a native controller with its C as it is now: a stale one has other bits


@pytest.fixture(scope="module")
def folder(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A user's folder with a stage whose FMUs were built, and then its description edited."""
    place = tmp_path_factory.mktemp("stale")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        maglev.new_stage("mine.toml", "2dof")
        for name, text in (("short", SHORT), ("study", STUDY), ("tuning", TUNING)):
            Path(f"{name}.toml").write_text(text, encoding="utf-8")
        maglev.build(["PlantMine", "RegulatorMine", "StageMine"], stage="mine.toml")
        maglev.new_controller("law.py", stage="mine.toml")
        (place / "fmus" / "wasm").mkdir()
        for file in ("PlantMine.wasm", "PlantMine.xml"):
            (place / "fmus" / "wasm" / file).write_bytes(b"<fmiModelDescription/>\n<!-- made of something -->\n")
        (place / "results" / "searched.parts").mkdir(parents=True)
        assert not command("check", "short.toml", "--baselines", ".", "--update", "--fmus", "fmus").exit_code
        assert not said(command("list", "--stage", "mine.toml"))
        assert not said(command("check", "short.toml", "--baselines", ".", "--fmus", "fmus"))
        text = Path("mine.toml").read_text(encoding="utf-8")
        Path("mine.toml").write_text(text.replace("mass = 4.35 ", "mass = 4.4 "), encoding="utf-8")
    yield place
    known_stages().forget(*known_stages().own)


def said(result: Result) -> list[str]:
    """FMUs of which a command says that they are stale."""
    lines = [line for line in (result.stdout + result.stderr).splitlines() if "stale" in line or "rebuilds it" in line]
    return [name for name in ("PlantMine", "RegulatorMine", "StageMine") if any(name in line for line in lines)]


def with_fmus(group: Any, above: str = "") -> Iterator[str]:
    """Commands that have an option --fmus."""
    for name, each in group.commands.items():
        if hasattr(each, "commands"):
            yield from with_fmus(each, f"{above}{name} ")
        elif any(option.name == "fmus" for option in each.params):
            yield f"{above}{name}"


def test_no_command_is_left_out() -> None:
    assert set(with_fmus(typer.main.get_command(app))) == {*COMMANDS, *BUILDS, *EMULATED}


@pytest.mark.few(1)
@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_says_it(folder: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.chdir(folder)
    arguments, code = COMMANDS[name]
    result = command(*name.split(), *arguments, "--fmus", "fmus")
    assert result.exit_code == code, result.output
    assert {"PlantMine", "RegulatorMine"} & {*said(result)}
    if name == "list":
        assert said(result) == ["PlantMine", "RegulatorMine", "StageMine"]
    elif name != "live":
        assert "`maglev build --stage mine.toml` rebuilds it" in " ".join(result.output.split())


def test_results_are_modified(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    assert command("run", "short.toml", "--fmus", "fmus").exit_code == 0
    record = json.loads((folder / "results" / "short.json").read_text(encoding="utf-8"))["provenance"]
    assert record["modified"]
    assert record["departures"] == [f"{role} is a {model}.fmu that this installation did not build"
                                    for role, model in (("controller", "RegulatorMine"), ("plant", "PlantMine"))]


def test_an_environment_and_the_functions_say_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import gymnasium

    monkeypatch.chdir(folder)
    with warns("PlantMine"):
        maglev.run("short.toml", fmus="fmus")
    (folder / "fmus" / "native").mkdir(exist_ok=True)
    (folder / "fmus" / "native" / "PlantMine.fmu").write_bytes((folder / "fmus" / "PlantMine.fmu").read_bytes())
    with raises(FmuError, "PlantMine"):
        gymnasium.make("maglev.gym:maglev/Stage-v0", stage="mine.toml", fmus="fmus")


@pytest.mark.thorough
def test_a_build_makes_it_current(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Last: the folder is then as a user has it."""
    monkeypatch.chdir(folder)
    know_stage("mine.toml")
    names = ("PlantMine.fmu", "RegulatorMine.fmu", "StageMine.ssp", "StageMineNoPorts.ssp")
    files = [Path("fmus") / name for name in names]
    assert all(stale(path.stem.removesuffix("NoPorts"), path) for path in files)
    maglev.build(["PlantMine", "RegulatorMine", "StageMine"], stage="mine.toml")
    assert not any(stale(path.stem.removesuffix("NoPorts"), path) for path in files)
    assert stale("RegulatorMine", files[0])   # another of ours under its name
    assert "error" not in command("check", "short.toml", "--baselines", ".", "--update", "--fmus", "fmus").output
