"""Runs under several controllers, side by side, as data and as files."""

import json
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from command_line import error_line
from command_line import maglev as command
from example_builds import EXAMPLES
from facts import raises, warns
from faulty_fmus import faulty

import maglev
from maglev.api.comparing import labelled
from maglev.files.errors import FmuError, ScenarioError, UnknownName

NAME = "2dof-smooth-nonlinear"


@pytest.fixture(scope="module")
def comparison(fastest_fmus: Path) -> maglev.Comparison:
    with warns("start values"):
        return maglev.compare(NAME, ["Regulator2DOF", "PID2DOF"], fmus=fastest_fmus)


def test_each_is_the_run_with_that_controller(comparison: maglev.Comparison, fastest_fmus: Path) -> None:
    alone = maglev.run(NAME, fmus=fastest_fmus)
    with warns("left out"):
        pid = maglev.run(NAME, controller=fastest_fmus / "PID2DOF.fmu", fmus=fastest_fmus)
    for label, run in (("Regulator2DOF", alone), ("PID2DOF", pid)):
        assert all(np.array_equal(run[name], comparison.runs[label][name]) for name in run.columns)
    assert not comparison.runs["Regulator2DOF"].result.modified
    assert comparison.runs["PID2DOF"].result.modified


def test_its_repr_is_a_line(comparison: maglev.Comparison) -> None:
    assert repr(comparison) == "<Comparison 2dof-smooth-nonlinear: Regulator2DOF completed, PID2DOF completed>"


def test_the_best_has_the_least_error(comparison: maglev.Comparison) -> None:
    row = next(row for row in comparison.rows if (row.quantity, row.of) == ("rms error", "v"))
    measured = {}
    for label, run in comparison.runs.items():
        axis = run.plan.axes["v"]
        measured[label] = float(np.sqrt(np.mean((run[axis.position] - run[axis.reference]) ** 2)))
    assert row.best == (min(measured, key=measured.__getitem__),)


def test_files_have_names_of_their_own(comparison: maglev.Comparison, tmp_path: Path) -> None:
    (tmp_path / f"{NAME}.csv").write_text("of a run of mine\n")
    files = comparison.write(tmp_path)
    assert (tmp_path / f"{NAME}.csv").read_text() == "of a run of mine\n"
    assert {path.name for path in files} == {
        *(f"{NAME}@{label}.{ending}" for label in ("Regulator2DOF", "PID2DOF") for ending in ("csv", "json")),
        *(f"{NAME}.compare.{ending}" for ending in ("json", "txt", "png", "html"))}
    data = json.loads((tmp_path / f"{NAME}.compare.json").read_text())
    assert data == json.loads(json.dumps(comparison.as_data()))
    assert data["runs"]["PID2DOF"]["provenance"]["modified"]
    assert "Regulator2DOF" in (tmp_path / f"{NAME}.compare.txt").read_text()


def test_as_a_table(comparison: maglev.Comparison) -> None:
    frame = comparison.to_pandas()
    assert list(frame.columns) == ["Regulator2DOF", "PID2DOF"]
    assert len(frame) == len(comparison.rows)


def test_a_controller_that_is_not_there_is_refused_before_any_runs(fastest_fmus: Path, tmp_path: Path) -> None:
    broken = command("compare", NAME, "--controller", "Regulator2DOF", "--controller",
                     f"nothing={tmp_path / 'none.fmu'}", "--fmus", fastest_fmus, "--out", tmp_path / "out")
    assert "none.fmu" in error_line(broken)
    assert not (tmp_path / "out").exists()


def test_a_run_takes_a_packaged_controller_by_its_name(fastest_fmus: Path) -> None:
    named, pathed = (maglev.run(NAME, fmus=fastest_fmus, controller=given)
                     for given in ("PID2DOF", fastest_fmus / "PID2DOF.fmu"))
    assert named.metrics == pathed.metrics != maglev.run(NAME, fmus=fastest_fmus).metrics
    with raises(UnknownName, "controller", "PID9"):
        maglev.run(NAME, fmus=fastest_fmus, controller="PID9")


def test_names_the_nearest_name(fastest_fmus: Path, tmp_path: Path) -> None:
    with raises(UnknownName, "controller", "PIDDOF", "'PID2DOF'"):
        maglev.compare(NAME, ["Regulator2DOF", "PIDDOF"], fmus=fastest_fmus)
    Path(tmp_path / "mine.fmu").touch()
    with raises(FmuError, tmp_path / "min.fmu", "'mine.fmu'"):
        maglev.compare(NAME, [tmp_path / "min.fmu"], fmus=fastest_fmus)


def test_one_that_ends_early_leaves_the_other(fastest_fmus: Path, tmp_path: Path) -> None:
    """A controller that ends its run is told of with the time, and what was recorded until then is kept and drawn."""
    bad = faulty("crash", tmp_path)
    ports = EXAMPLES / "pd_controller_c" / "ports.toml"
    done = command("compare", "2dof-step-1-nonlinear", "--controller", "Regulator2DOF", "--controller", f"bad={bad}",
                   "--map", ports, "--fmus", fastest_fmus, "--out", tmp_path)
    assert done.exit_code == 2
    assert "bad: at t = 0.1 s: " in done.stderr
    assert (tmp_path / "2dof-step-1-nonlinear@Regulator2DOF.csv").is_file()
    kept = (tmp_path / "2dof-step-1-nonlinear@bad.partial.csv").read_text().splitlines()
    assert float(kept[-1].split(",")[0]) == pytest.approx(0.1)
    shown = json.loads((tmp_path / "2dof-step-1-nonlinear.compare.json").read_text())
    assert "0.1 s" in shown["runs"]["bad"]["failure"]
    assert list(shown["rows"][0]["values"]) == ["Regulator2DOF"]


def test_runs_that_were_run(comparison: maglev.Comparison, fastest_fmus: Path) -> None:
    heavy = maglev.run(NAME, fmus=fastest_fmus, set={"plant.v.mass": "7 kg"})
    found = maglev.compare({"as it is": comparison.runs["Regulator2DOF"], "heavy": heavy})
    assert list(found.runs) == ["as it is", "heavy"]
    assert list(maglev.compare(run for run in [heavy, heavy]).runs) == [NAME, f"{NAME}-2"]
    other = maglev.run("2dof-effects-encoder", fmus=fastest_fmus)
    with raises(ScenarioError, "references"):
        maglev.compare([heavy, other])


class Hold:
    """Gives no currents, so that the stage falls to its stop."""

    inputs = dict.fromkeys(("v.measured", "h.measured", "v.reference", "h.reference"), "m")
    outputs = dict.fromkeys(("motor.i_a_cmd", "motor.i_b_cmd", "motor.i_c_cmd"), "A")
    parameters: ClassVar[dict[str, str]] = {}

    def __init__(self) -> None:
        self.sample_time = 0.5e-3
        self.v_measured = self.v_reference = 20e-3
        self.h_measured = self.h_reference = 0.0
        self.motor_i_a_cmd = self.motor_i_b_cmd = self.motor_i_c_cmd = 0.0

    def step(self, t: float) -> None:
        """Do nothing."""


def test_compares_a_class_with_a_packaged_controller(fastest_fmus: Path) -> None:
    with warns("left out"):
        found = maglev.compare(NAME, ["Regulator2DOF", Hold], fmus=fastest_fmus)
    assert not found.runs["Regulator2DOF"].metrics.failed
    assert found.runs["Hold"].metrics.failed


@pytest.mark.parametrize("name", ["kp=3.py", "run=1/c.py", "run=1/c.fmu"])
def test_a_file_is_one_whatever_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """What stands before a = is a label only where there is no such file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).touch()
    assert labelled([name]) == {Path(name).stem: name}
    assert labelled([f"mine={name}"]) == {"mine": name}
    if name.endswith(".py"):
        assert labelled([f"{name}:LQI"]) == {"LQI": f"{name}:LQI"}


def test_labels() -> None:
    assert labelled(["PID2DOF", "a/lqi.fmu", "b/lqi.py", "mine=c.fmu", "d/two.py:LQI", Hold]) == {
        "PID2DOF": "PID2DOF", "lqi": "a/lqi.fmu", "lqi-2": "b/lqi.py", "mine": "c.fmu", "LQI": "d/two.py:LQI",
        "Hold": Hold}
    assert labelled(Hold) == {"Hold": Hold}   # type: ignore[arg-type]
    with raises(ScenarioError, "label", "'a/b'"):
        labelled({"a/b": "c.fmu"})


def test_a_comparison_of_nothing(fastest_fmus: Path) -> None:
    with raises(ScenarioError, "controllers"):
        maglev.compare(NAME, [], fmus=fastest_fmus)


def test_as_json(fastest_fmus: Path, tmp_path: Path) -> None:
    """Standard output is the JSON and nothing else; of the file, all but which columns it is of."""
    done = command("run", NAME, "--json", "--fmus", fastest_fmus, "--out", tmp_path)
    run = json.loads(done.stdout)["runs"][NAME]
    written = json.loads((tmp_path / f"{NAME}.json").read_text())
    assert list(written.pop("files")) == [f"{NAME}.csv"]
    assert run == written | {"claims": run["claims"]}
    rms = next(row for row in run["measures"] if row["quantity"] == "rms error")
    assert {"of": "v", "time": None, "unit": "m"}.items() <= rms.items()
