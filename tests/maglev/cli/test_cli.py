"""The command line as a user types it: results, one-line errors with exit code 2, and scripts."""

import csv
import json
import os
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from command_line import SCRIPTS, error_line, maglev, run_script
from estimator_run import PLACES
from facts import raises, require_facts
from named_controllers import Estimator2DOF, Estimator3DOF

import maglev as tool
from maglev.fmi.definition import reader

SHORT = """
extends = "{loop}"
name = "short"
title = "A short hold"
stop_time = "20 ms"
[[signals]]
to = "controller.y.reference"
kind = "constant"
value = "25 mm"
"""


@pytest.fixture
def short(tmp_path: Path) -> Path:
    """A scenario of 100 communication steps."""
    path = tmp_path / "short.toml"
    loop = Path(__file__).parents[3] / "scenarios" / "loops" / "3dof.toml"
    path.write_text(SHORT.format(loop=os.path.relpath(loop, tmp_path)))
    return path


def test_run_writes_csv_text_and_picture(fmus: Path, short: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / "out"
    result = maglev("run", short, "--fmus", fmus, "--out", out, "--plot")
    assert result.exit_code == 0, result.output
    with (out / "short.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[0][0] == "time"
    assert {"plant.y.position", "controller.alpha.i_d_cmd", "controller.y.reference"} <= set(rows[0])
    assert all(len(row) == len(rows[0]) for row in rows)
    assert float(rows[1][0]) == 0.0
    assert float(rows[-1][0]) == pytest.approx(0.02)
    assert float(rows[-1][rows[0].index("plant.y.position")]) == pytest.approx(0.025, abs=1e-4)
    assert "completed" in (out / "short.txt").read_text()
    assert (out / "short.png").read_bytes().startswith(b"\x89PNG")


def test_every_so_many_steps_are_written(fastest_fmus: Path, short: Path, tmp_path: Path) -> None:
    """The rows are those of the run with all, and the last one; what is measured is the same."""
    with short.open("a") as file:
        file.write('[metrics]\nbands = ["0.1 mm"]\n')
    short.write_text(short.read_text().replace('stop_time', 'output_interval = "0.2 ms"\nstop_time'))
    found = {}
    for every in (None, 7):
        out = tmp_path / str(every)
        result = maglev("run", short, "--fmus", fastest_fmus, "--out", out, *(["--every", str(every)] if every else []))
        assert result.exit_code == 0, result.output
        found[every] = (out / "short.csv").read_text().splitlines(), json.loads((out / "short.json").read_text())
    rows, thinned = found[None][0], found[7][0]
    assert len(rows) == 102 and thinned == [rows[0], *rows[1::7], rows[-1]]
    assert found[7][1]["metrics"] == found[None][1]["metrics"]
    assert tool.run(short, fmus=fastest_fmus, every=50).time.tolist() == pytest.approx([0.0, 0.01, 0.02])


@pytest.mark.parametrize("every", ["0", "-3", "101"])
def test_no_number_of_steps_is_refused(fastest_fmus: Path, short: Path, tmp_path: Path, every: str) -> None:
    line = error_line(maglev("run", short, "--fmus", fastest_fmus, "--out", tmp_path / "out", "--every", every))
    require_facts(line, "every", every, 1, 100, "short")
    assert not (tmp_path / "out").exists()


def test_half_a_step_is_refused(fastest_fmus: Path, short: Path) -> None:
    with raises(tool.ScenarioError, "every", 2.5, 1, 100):
        tool.run(short, fmus=fastest_fmus, every=2.5)   # type: ignore[arg-type]


def test_order_reaches_the_master(fastest_fmus: Path, short: Path, tmp_path: Path) -> None:
    """In Jacobi order the stage's first step is one without current."""
    first = {}
    for order in ("sequential", "jacobi"):
        result = maglev("run", short, "--fmus", fastest_fmus, "--out", tmp_path / order, "--order", order)
        assert result.exit_code == 0, result.output
        with (tmp_path / order / "short.csv").open() as file:
            first[order] = float(list(csv.DictReader(file))[1]["plant.y.velocity"])
    assert first["jacobi"] > first["sequential"] + 1e-4   # m/s, downwards
    assert maglev("run", short, "--fmus", fastest_fmus, "--order", "parallel").exit_code == 2


def test_set_reaches_the_fmu(fmus: Path, short: Path, tmp_path: Path) -> None:
    for mass, folder in (("6.9", "a"), ("9 kg", "b")):
        result = maglev("run", short, "--fmus", fmus, "--out", tmp_path / folder, "--set", f"plant.y.mass={mass}",
                        "--set", "plant.y.friction.coulomb=50", "--set", "controller.antiwindup=False")
        assert result.exit_code == 0, result.output
    assert (tmp_path / "a" / "short.csv").read_text() != (tmp_path / "b" / "short.csv").read_text()


@pytest.mark.parametrize(("arguments", "message"), [
    (["--set", "plant.y.mas=1"], "y.mass"),
    (["--set", "plnt.y.mass=1"], "nearest is 'plant'"),
    (["--set", "plant.y.mass"], "expected FMU.variable=value"),
    (["--set", "plant.y.mass=2 m"], "kg"),
    (["--set", "plant.y.mass=heavy"], "heavy"),
    (["--set", "plant.y.mass=-1"], "y.mass = -1.0 kg, expected a number from 0.001"),
    (["--set", "plant.y.position_start=40 mm"], "y.position_start = 0.04 m, expected a place between the stops"),
    (["--step", "0.15 ms"], "short.toml: stop_time = 0.02 s with step = 0.00015: expected a whole number"),
    (["--step", "1 ms"], "sample_time = 0.0002 s"),
    (["--step", "-1"], "step = -1: expected a time above 0 s"),
    (["--step", "abc"], "step = abc: 'abc' is not a quantity"),
    (["--set", "controller.antiwindup=7"], "expected true or false"),
    (["--set", "plant.y.mass=nan"], "expected a finite number"),
    (["--set", "plant.y.encoder=1"], "expected parameter or input"),
    (["--set", "controller.y.reference=26 mm"], "'y.reference' is fed by signals[0].to from the start"),
    (["--plant", "."], "there is no file ."),
    (["--plant", "missing.fmu"], "there is no file missing.fmu"),
    (["--fmus", "nowhere"], "`maglev build`")])
def test_user_errors(fmus: Path, short: Path, tmp_path: Path, arguments: list[str], message: str) -> None:
    places: list[str | Path] = [] if "--fmus" in arguments else ["--fmus", fmus]
    assert message in error_line(maglev("run", short, *places, "--out", tmp_path, *arguments))


def test_controller_without_a_needed_port(fmus: Path, short: Path, tmp_path: Path) -> None:
    line = error_line(maglev("run", short, "--fmus", fmus, "--out", tmp_path,
                             "--controller", fmus / "Regulator2DOF.fmu"))
    assert "controller" in line
    assert "nearest" in line


def test_failed_run_leaves_earlier_results_and_a_partial_one(fmus: Path, short: Path, tmp_path: Path) -> None:
    assert maglev("run", short, "--fmus", fmus, "--out", tmp_path).exit_code == 0
    before = (tmp_path / "short.csv").read_bytes()
    record = (tmp_path / "short.json").read_bytes()
    # The stops off and a blow to the side: the mover leaves the range that the controller can be given.
    line = error_line(maglev("run", short, "--fmus", fmus, "--out", tmp_path, "--set", "plant.x.stop.stiffness=0",
                             "--set", "plant.x.stop.damping=0", "--set", "plant.x.mass=0.001", "--set",
                             "plant.x.force=1e5", "--set", "plant.x.friction.viscous=0"))
    assert "x.measured = " in line
    assert "expected a number from -10.0 to 10.0 m" in line
    assert "Fatal py exception" not in line
    assert "short.partial.csv" in line
    # What an earlier run has left does not pass for what this one gave.
    assert not (tmp_path / "short.csv").exists()
    assert not (tmp_path / "short.json").exists()
    assert (tmp_path / "short.previous.csv").read_bytes() == before
    assert (tmp_path / "short.previous.json").read_bytes() == record
    assert "did not complete" in (tmp_path / "short.txt").read_text()
    partial = (tmp_path / "short.partial.csv").read_text().splitlines()
    assert partial[0].startswith("time,")
    assert len(partial) > 2
    assert maglev("run", short, "--fmus", fmus, "--out", tmp_path).exit_code == 0
    assert (tmp_path / "short.csv").read_bytes() == before
    assert not list(tmp_path.glob("*.partial.csv")) + list(tmp_path.glob("*.previous.*"))


def test_unknown_scenario_and_key(short: Path) -> None:
    assert "3dof-setpoints" in error_line(maglev("run", "3dof-setpoint"))
    short.write_text(short.read_text().replace("title =", "tittle ="))
    line = error_line(maglev("run", short))
    assert "tittle" in line
    assert "title" in line
    assert short.name in line


def test_unknown_fmu(tmp_path: Path) -> None:
    assert "nearest is 'Plant3DOF'" in error_line(maglev("build", "Plant3DOFF", "--fmus", tmp_path))
    assert not list(tmp_path.iterdir())


def test_folder_that_cannot_be_written_is_refused_before_the_run(fmus: Path, short: Path, tmp_path: Path,
                                                                  monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setattr("maglev.api.running.run_experiments", lambda *_: pytest.fail("it ran"))
    assert "file" in error_line(maglev("run", short, "--fmus", fmus, "--out", tmp_path / "file"))


def test_plot_without_matplotlib_is_refused_before_the_run(fmus: Path, short: Path, tmp_path: Path,
                                                            monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("maglev.files.errors.find_spec", lambda _: None)
    monkeypatch.setattr("maglev.api.running.run_experiments", lambda *_: pytest.fail("it ran"))
    assert "needs matplotlib" in error_line(maglev("run", short, "--fmus", fmus, "--out", tmp_path, "--plot"))


def test_debug_shows_the_traceback(short: Path) -> None:
    with raises(tool.FmuError, "nowhere/Regulator3DOF.fmu"):
        maglev("run", short, "--fmus", "nowhere", "--debug")


@pytest.mark.usefixtures("slow")
def test_build_and_list(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MAGLEV_CACHE", str(tmp_path / "cache"))   # one without FMUs that other tests left
    result = maglev("build", "Plant2DOF", "--fmus", tmp_path)
    assert result.exit_code == 0
    assert (tmp_path / "Plant2DOF.fmu").is_file()
    (tmp_path / "clocked").mkdir()
    (tmp_path / "clocked" / "Regulator3DOF.fmu").touch()
    listed = maglev("list", "--fmus", tmp_path)
    assert listed.exit_code == 0
    for name, built in (("Plant", "yes +no +no"), ("Regulator", "no +stale +no")):
        assert re.search(rf"(?m)^{name}  +.*  {built} *$", listed.output)
    assert "3dof-setpoints-improved" in listed.output
    for name, built in (("Plant2DOF", "Python in"), ("Regulator3DOF", "clocked in"), ("Plant3DOF", "no  ")):
        told = maglev("list", name, "--fmus", tmp_path).output
        assert re.search(rf"(?m)^{name}  +{built}", told)
        assert (name == "Regulator3DOF") == ("(stale)" in " ".join(told.split()))


@pytest.mark.parametrize("stage", ["2dof", "3dof"])
def test_scripts_reproduce_the_recorded_run(fmus: Path, tmp_path: Path, stage: str) -> None:
    """Each FMU alone gives what the other one was recorded to get from it."""
    results, given = {}, {}
    for fmu in ("plant", "controller"):
        out = tmp_path / f"{fmu}.csv"
        run_script(f"{fmu}_{stage}.sh", fmus, out)
        results[fmu] = np.genfromtxt(out, delimiter=",", names=True, dtype=float, deletechars="", usecols=range(9))
        given[fmu] = np.genfromtxt(SCRIPTS / f"{fmu}_{stage}_inputs.csv", delimiter=",", names=True, deletechars="")
    motor, axis = ("motor", "v") if stage == "2dof" else ("alpha", "y")
    n = len(results["controller"]) - 1
    assert n == round(0.25 / (0.5e-3 if stage == "2dof" else 0.2e-3))
    commanded = results["controller"][f"{motor}.i_a_cmd"][1:]
    assert np.array_equal(commanded, given["plant"][f"{motor}.i_a_cmd"][:n])
    assert np.ptp(commanded) > 0.1
    plant = np.genfromtxt(tmp_path / "plant.csv", delimiter=",", names=True, dtype=float, deletechars="")
    # One encoder count: the replayed plant is open loop, so that a rounding error in fmpy's interpolation grows.
    assert np.abs(plant[f"{axis}.encoder"][:n] - given["controller"][f"{axis}.measured"][:n]).max() < 1.01e-5


@pytest.mark.parametrize("name", sorted(path.name for path in SCRIPTS.glob("*_?dof.sh")))
def test_scripts_say_in_a_line_what_builds_a_missing_fmu(tmp_path: Path, name: str) -> None:
    done = subprocess.run(["sh", str(SCRIPTS / name)], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and done.stdout == ""
    assert re.fullmatch(r"(\w+)\.fmu is neither in fmus/native nor in fmus: `maglev build \1 --fmus fmus` builds it, "
                        r".*\n", done.stderr)
    assert not [*tmp_path.iterdir()]


def test_scripts_take_native_fmus_first(tmp_path: Path) -> None:
    (tmp_path / "fmus" / "native").mkdir(parents=True)
    for folder in ("fmus", "fmus/native"):
        (tmp_path / folder / "Plant2DOF.fmu").touch()
    (tmp_path / "fmpy").write_text("#!/bin/sh\necho $2\n", encoding="utf-8")
    (tmp_path / "fmpy").chmod(0o700)
    done = subprocess.run(["sh", str(SCRIPTS / "plant_2dof.sh")], cwd=tmp_path, capture_output=True, text=True,
                          check=True, env={**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"})
    assert done.stdout == "fmus/native/Plant2DOF.fmu\nresults: plant_2dof.csv\n"


@pytest.mark.parametrize(("stage", "block", "stop_time"), [("2dof", Estimator2DOF, 1.0), ("3dof", Estimator3DOF, 0.5)])
def test_scripts_of_the_estimators(fmus: Path, tmp_path: Path, stage: str,
                                   block: type[Estimator2DOF] | type[Estimator3DOF], stop_time: float) -> None:
    """The FMU alone estimates what the block does from the same recording, and leaves its first guesses."""
    run_script(f"estimator_{stage}.sh", fmus, tmp_path / "out.csv")
    result = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True, dtype=None, deletechars="")
    given = np.genfromtxt(SCRIPTS / f"estimator_{stage}_inputs.csv", delimiter=",", names=True, deletechars="")
    estimator = block()
    step = estimator.sample_time
    assert len(result) - 1 == len(given) == round(stop_time / step)
    estimator.start()
    names = [name for name in result.dtype.names or () if name in ("C1", "C2", "C3", "C4", "C5")]
    estimates = reader([PLACES[int(stage[0])][name] for name in names])
    guesses = estimates(estimator)
    for row, estimated in zip(given, result[1:], strict=True):
        for name in (given.dtype.names or ())[1:]:
            part, _, variable = name.partition(".")
            setattr(getattr(estimator, part), variable, float(row[name]))
        estimator.step(float(row["time"]), step)
        assert [estimated[name] for name in names] == pytest.approx(estimates(estimator))
    assert all(abs(estimated[name] / guess - 1.0) > 0.1 for name, guess in zip(names, guesses, strict=True))


def test_lists_scenarios_to_run() -> None:
    assert "expected the name of a scenario, or --all" in error_line(maglev("run"))
    assert "--all and 3dof-setpoints: expected one of them" in error_line(maglev("run", "3dof-setpoints", "--all"))


def test_version_and_short_help() -> None:
    assert maglev("--version").output == f"maglev {version('maglev-fmus')}\n"
    assert maglev("-h").output == maglev("--help").output
    assert maglev("run", "-h").exit_code == 0


@pytest.mark.parametrize(("words", "expected"), [("ru", "run"), ("run 2dof-step-4-l", "2dof-step-4-linear"),
                                                 ("run 3dof-setpoints-i", "3dof-setpoints-improved")])
@pytest.mark.usefixtures("slow")
def test_shell_completion(words: str, expected: str) -> None:
    """What the shell asks the command when a person presses the tabulator."""
    words = f"maglev {words}"
    done = subprocess.run([sys.executable, "-c", "from maglev.cli.app import app; app(prog_name='maglev')"],
                          capture_output=True, text=True, check=True,
                          env={**os.environ, "_MAGLEV_COMPLETE": "complete_bash", "COMP_WORDS": words,
                               "COMP_CWORD": str(words.count(" "))})
    assert done.stdout.split() == [expected]
