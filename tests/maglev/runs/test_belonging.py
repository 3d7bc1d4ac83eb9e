"""Columns and record of one run stay together: one writer at a time, and no reader takes those of two."""

import json
import shutil
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from command_line import error_line
from command_line import maglev as command
from facts import raises

import maglev
from maglev.api import running
from maglev.files.cache import digest_at
from maglev.files.errors import CsvError, ScenarioError
from maglev.runs import execution
from maglev.runs.results import alone
from maglev.scenario.loading import load_plan

EXCITED = """
extends = ["loops/2dof.toml", "references/2dof-excitation.toml"]
name = "excited"
title = "An excited stage"
stop_time = "1.2 s"
"""

FED = """
extends = ["loops/2dof.toml", "gains/2dof.toml"]
name = "fed"
title = "What another run recorded"
stop_time = "0.1 s"
[[signals]]
to = "controller.v.reference"
kind = "csv"
file = "results/excited.csv"
column = "plant.v.position"
"""


@pytest.fixture
def excited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user's folder with a scenario."""
    monkeypatch.chdir(tmp_path)
    Path("excited.toml").write_text(EXCITED, encoding="utf-8")
    Path("fed.toml").write_text(FED, encoding="utf-8")
    return tmp_path


def ran(fastest_fmus: Path, out: str, *more: str) -> dict[str, bytes]:
    """Files of a run, by ending."""
    assert command("run", "excited.toml", "--fmus", fastest_fmus, "--out", out, *more).exit_code == 0
    return {path.suffix: path.read_bytes() for path in Path(out).glob("excited.*")}


def test_readers_refuse_the_files_of_two_runs(fastest_fmus: Path, excited: Path) -> None:
    """All ways in which columns and record of two runs can lie next to each other: only those of one are read."""
    runs = {"light": ran(fastest_fmus, "results"), "heavy": ran(fastest_fmus, "heavy", "--set", "plant.v.mass=4.6")}
    assert runs["light"][".csv"] != runs["heavy"][".csv"]
    for columns, record in product(runs, runs):
        Path("results/excited.csv").write_bytes(runs[columns][".csv"])
        Path("results/excited.json").write_bytes(runs[record][".json"])
        if columns == record:
            assert maglev.identify("results/excited.csv").estimate.final["C1"] > 0.0
            assert load_plan("fed.toml").signals
            continue
        with raises(CsvError, "results/excited.csv", "excited.json") as refusal:
            maglev.identify("results/excited.csv")
        assert str(refusal.value) in error_line(command("identify", "results/excited.csv"))
        with raises(ScenarioError, "fed.toml", "signals[0].file", "'results/excited.csv'", "excited.json"):
            load_plan("fed.toml")
    Path("results/excited.json").unlink()   # columns alone are a recording as any
    assert maglev.identify("results/excited.csv").estimate.final["C1"] > 0.0


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_the_record_has_the_digest_of_its_columns(fastest_fmus: Path, excited: Path, form: str) -> None:
    ran(fastest_fmus, "results", "--format", form)
    record = json.loads(Path("results/excited.json").read_text(encoding="utf-8"))
    assert record["files"] == {f"excited.{form}": digest_at(Path(f"results/excited.{form}"))}


@pytest.mark.parametrize("where", ["run_experiments", "write_runs"])
def test_a_second_run_into_the_folder_is_refused_before_it_runs(fastest_fmus: Path, excited: Path, where: str,
                                                                 monkeypatch: pytest.MonkeyPatch) -> None:
    """While the first pauses, before its columns and after them; one that writes other files is not refused."""
    Path("other.toml").write_text(EXCITED.replace('"excited"', '"other"'), encoding="utf-8")
    plain = getattr(running, where)
    seen: list[str] = []

    def paused(*given: Any) -> Any:
        monkeypatch.setattr(running, where, plain)
        seen.extend(error_line(command(word, "excited.toml", "--fmus", fastest_fmus)) for word in ("run", "report"))
        assert command("run", "other.toml", "--fmus", fastest_fmus).exit_code == 0
        assert command("run", "excited.toml", "--fmus", fastest_fmus, "--out", "elsewhere").exit_code == 0
        return plain(*given)

    monkeypatch.setattr(running, where, paused)
    ran(fastest_fmus, "results")
    assert seen == ["maglev: results/excited: another process is writing the files of this run: wait for it, or give "
                    "another out"] * 2
    ran(fastest_fmus, "results")
    assert not list(Path("results").glob(".*"))
    assert maglev.identify("results/excited.csv").estimate.final["C1"] > 0.0


def test_a_run_that_ends_between_its_files_leaves_those_of_the_earlier_one(fastest_fmus: Path, excited: Path,
                                                                           monkeypatch: pytest.MonkeyPatch) -> None:
    before = ran(fastest_fmus, "results")

    def ends(*_: object) -> None:
        raise SystemExit(3)

    with monkeypatch.context() as patch, pytest.raises(SystemExit):
        patch.setattr(execution, "json_text", ends)
        maglev.run_all(["excited.toml"], fmus=fastest_fmus, set={"plant.v.mass": 4.6}, jobs=1)
    assert {path.suffix: path.read_bytes() for path in Path("results").glob("excited.*")} == before


def test_comparisons_of_one_name_wait_for_each_other(fastest_fmus: Path, excited: Path) -> None:
    comparison = maglev.compare("excited.toml", ["Regulator2DOF"], fmus=fastest_fmus)
    shutil.rmtree("results", ignore_errors=True)
    label = "excited@Regulator2DOF"
    with alone(Path("results"), [label]):   # the lock of a run is another one
        files = comparison.write(picture=False, page=False)
    assert all(path.is_file() for path in files)
    record = json.loads(Path(f"results/{label}.json").read_text(encoding="utf-8"))
    assert record["files"] == {f"{label}.csv": digest_at(Path(f"results/{label}.csv"))}
    assert not list(Path("results").glob(".*"))
