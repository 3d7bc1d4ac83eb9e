"""A scenario put into an FMU: it repeats alone what it did there, next to what was in it, and nothing else changes."""

import shutil
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from carried_experiments import files_of
from command_line import error_line, maglev
from facts import raises, require_facts

from maglev.descriptions.own_fmus import built_here
from maglev.files.errors import FmuError, ScenarioError
from maglev.fmi.experiment_files import MANIFEST
from maglev.runs import experiment_pack as pack
from maglev.runs.experiment_pack import recorded_experiment

SHORT = """
extends = "{loop}"
name = "short"
title = "A short step"
stop_time = "50 ms"
fmus.controller.file = "{fmu}"
[[signals]]
to = "controller.v.reference"
kind = "steps"
unit = "mm"
times = [0, 0.02]
values = [20, 20.5]
[check]
interval = "5 ms"
[check.signals]
"controller.motor.i_q_cmd" = {{ absolute = "1 mA" }}
"plant.v.position" = {{ absolute = "1 um" }}
"""


@pytest.fixture
def mine(fmus: Path, tmp_path: Path) -> Path:
    """An FMU, and next to it short.toml, a scenario that names it."""
    copy = Path(shutil.copy(fmus / "Regulator2DOF.fmu", tmp_path / "mine.fmu"))
    loop = Path(__file__).parents[3] / "scenarios" / "loops" / "2dof.toml"
    (tmp_path / "short.toml").write_text(SHORT.format(loop=loop, fmu=copy))
    return copy


def contents(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_a_packed_scenario_is_repeated(fmus: Path, mine: Path, tmp_path: Path) -> None:
    before = contents(mine)
    done = maglev("pack", "ref", mine, tmp_path / "short.toml", "--fmus", fmus)
    assert done.exit_code == 0, done.output
    assert "mine.fmu: carries short; run alone, passed, 1 variable at 11 times to t = 0.05 s equal" in done.stdout
    after = contents(mine)
    assert {name: data for name, data in after.items() if name in before and name != MANIFEST} == {
        name: data for name, data in before.items() if name != MANIFEST}
    assert {name.rpartition("/")[2] for name in after.keys() - before.keys()} == {
        "short.exp", "short_in.csv", "short_ref.csv", "short_ref.opt"}
    assert built_here(mine)
    assert files_of(mine)["short_ref.csv"].startswith(b"time,motor.i_q_cmd\n")
    # Packed again, it takes its own place.
    assert maglev("pack", "ref", mine, tmp_path / "short.toml", "--fmus", fmus).exit_code == 0
    assert contents(mine) == after


def test_refuses_to_pack_such_runs(fmus: Path, mine: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = mine.read_bytes()
    line = error_line(maglev("pack", "ref", mine, "2dof-smooth-nonlinear", "--fmus", fmus))
    require_facts(line, "name", "controller", "plant")
    with raises(ScenarioError, "sensor", "2dof-smooth-nonlinear", "controller", "plant"):
        pack.pack_reference(mine, "2dof-smooth-nonlinear", name="sensor", fmus=fmus)
    monkeypatch.setattr(pack, "LARGEST", 1000)
    with raises(ScenarioError, "stop_time", "0.05 s", "MB"):
        pack.pack_reference(mine, tmp_path / "short.toml", fmus=fmus)
    monkeypatch.undo()

    def wrong(*arguments: Any) -> Any:
        found = recorded_experiment(*arguments)
        return replace(found, results={**found.results, "motor.i_q_cmd": [value + 0.1 for value in
                                                                          found.results["motor.i_q_cmd"]]})

    monkeypatch.setattr(pack, "recorded_experiment", wrong)
    with raises(FmuError, "0 s"):
        pack.pack_reference(mine, tmp_path / "short.toml", fmus=fmus)
    assert mine.read_bytes() == before
