"""What `maglev list` says: few lines, none wider than the terminal, and whether an FMU is built, also in the cache."""

from pathlib import Path

import pytest
from command_line import error_line, maglev

import maglev as tool
from maglev.files.cache import PLACE, keep
from maglev.scenario.catalogue import HOST
from maglev.scenario.fmus_for_runs import fmu_key


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(PLACE, str(tmp_path / "cache"))
    monkeypatch.setenv("COLUMNS", "80")


def lines(*words: str) -> list[str]:
    done = maglev("list", *words)
    assert done.exit_code == 0, done.output
    return [line.rstrip() for line in done.stdout.splitlines()]


def test_list_is_short_and_names_every_kind_and_scenario() -> None:
    printed = lines()
    assert len(printed) < 130 and max(map(len, printed)) <= 80
    firsts = {line.split(" ")[0] for line in printed}
    assert {"Plant", "Regulator", "ClosedLoopPID", "Stage", "2dof-setpoints", "2dof-step-4-…"} <= firsts
    scenarios = {run.scenario for run in tool.scenarios()}
    assert all(any(first.startswith(name) for first in firsts) for name in scenarios)


def test_what_is_in_the_cache_is_built() -> None:
    assert [line.split()[1] for line in lines("Plant3DOF") if line.startswith("Plant3DOF")] == ["no"]
    keep(fmu_key("Plant3DOF", HOST), "Plant3DOF.fmu", b"FMU")
    assert any(line.startswith("Plant3DOF  native in the cache") for line in lines("Plant3DOF"))
    assert next(line for line in lines() if line.startswith("Plant ")).split()[-3:] == ["no", "yes", "no"]


def test_words_choose_and_say_more() -> None:
    printed = lines("2dof-step-4")
    assert [line.split(" ")[0] for line in printed if line.startswith("2dof")] == [
        "2dof-step-4-nonlinear", "2dof-step-4-linear", "2dof-step-4-fed-forward"]
    assert any("Fig. 4.25" in line for line in printed)
    assert "nope: no FMU and no run has this in its name" in error_line(maglev("list", "nope"))
