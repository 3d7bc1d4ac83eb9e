"""Controllers that are Python files or classes, run."""

import hashlib
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import error_line, maglev
from facts import raises
from numpy.testing import assert_array_equal
from written_controllers import controller, line_of, trial

import maglev as tool
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.scenario.loading import load_plan
from maglev.user.new_controller import new_controller
from maglev.user.source import PythonFile


def columns(run: tool.Run) -> dict[str, np.ndarray]:
    """What was recorded of the plant and of the commands."""
    return {name: values for name, values in run.columns.items() if name.startswith("plant.") or "_cmd" in name}


@pytest.fixture
def pythonfmu_controller(slow: None, tmp_path: Path) -> Path:
    """The example that the PD controller of these tests re-implements."""
    source = Path(__file__).parents[3] / "examples" / "pd_controller_python" / "pd_controller.py"
    subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", source, "-d", tmp_path], check=True,
                   capture_output=True)
    return tmp_path / "PDController.fmu"


@pytest.mark.filterwarnings("ignore:controller .* has no")
def test_a_file_runs_like_a_third_party_fmu(fastest_fmus: Path, pythonfmu_controller: Path, tmp_path: Path) -> None:
    """pythonfmu's own slave and wrapper, and a process of its own, around the same law."""
    plan = trial(tmp_path)
    ours = tool.run(plan, controller=controller(tmp_path), fmus=fastest_fmus, set={"controller.bandwidth": 50.0})
    theirs = tool.run(plan, controller=pythonfmu_controller, fmus=fastest_fmus, set={"controller.bandwidth": 50.0})
    assert ours["plant.v.position"][-1] == pytest.approx(21e-3, abs=0.3e-3)
    assert columns(ours).keys() == columns(theirs).keys()
    for name, values in columns(theirs).items():
        assert_array_equal(columns(ours)[name], values, err_msg=name)


@pytest.mark.filterwarnings("ignore:controller .* has no")
def test_a_class_may_close_over_numpy(fastest_fmus: Path, tmp_path: Path) -> None:
    """A class of no file, whose gains are an array outside, and whose output is a number of numpy's."""
    path = controller(tmp_path)
    namespace: dict[str, Any] = {}
    exec(compile(path.read_text(), "<cell>", "exec"), namespace)
    base: Any = namespace["PD"]
    gains = np.array([[60.0, 0.9]])

    class Closed(base):   # type: ignore[misc]
        """PD by a matrix."""

        def step(self, t: float) -> None:
            self.bandwidth, self.damping = gains[0]
            super().step(t)
            self.motor_i_a_cmd: float = np.float64(self.motor_i_a_cmd)

    plan = trial(tmp_path)
    of_class = tool.run(plan, controller=Closed, fmus=fastest_fmus)
    of_file = tool.run(plan, controller=path, fmus=fastest_fmus)
    for name, values in columns(of_file).items():
        assert_array_equal(columns(of_class)[name], values, err_msg=name)
    assert of_class.result.provenance and of_class.result.provenance.fmus[0].kind == "Python class"


@pytest.mark.filterwarnings("ignore:controller .* has no")
def test_the_sample_time_is_kept(fastest_fmus: Path, tmp_path: Path) -> None:
    """Of a controller with a sample time of four communication steps, every fourth computes, the others hold."""
    path = controller(tmp_path, ("self.sample_time = 0.5e-3", "self.sample_time = 2.0e-3"),
                      ("self.motor_i_a_cmd = cos(angle) * i_d - sin(angle) * i_q", "self.motor_i_a_cmd = t"))
    run = tool.run(trial(tmp_path), controller=path, fmus=fastest_fmus)
    # The command at a point is what the step before it has computed, from its sample's time on.
    held = run["controller.motor.i_a_cmd"][1:]
    expected = 2e-3 * np.floor((run.time[1:] - 0.25e-3) / 2e-3)
    assert held == pytest.approx(expected, abs=1e-12)


def test_where_it_crashes_is_said(fastest_fmus: Path, tmp_path: Path) -> None:
    """In one line, with what was recorded; the traceback with --debug."""
    path = controller(tmp_path, ("angle = pi / POLE_PITCH", "angle = {}['gain'] if t > 0.0501 else pi / POLE_PITCH"))
    arguments = ("run", trial(tmp_path), "--fmus", fastest_fmus, "--out", tmp_path, "--controller", path)
    result = maglev(*arguments)
    assert result.exit_code == 2
    last = result.stderr.strip().splitlines()[-1]
    place = f"pd.py, line {line_of(path, 'angle = {}')}: KeyError: 'gain'"
    assert last == (f"maglev: trial: at t = 0.0505 s: controller (pd.py): step failed at t = 0.0505 s: {place}; "
                    f"what was recorded until then is in {tmp_path / 'trial.partial.csv'}")
    assert "Traceback" not in result.output
    rows = (tmp_path / "trial.partial.csv").read_text().splitlines()
    assert rows[-1].startswith("0.0505,")
    assert 'angle = {}[' in maglev(*arguments, "--debug").output


@pytest.mark.parametrize(("value", "shown"), [
    ("float('nan')", "nan A"), ("float('inf')", "inf A"), ("'high'", "'high' A"), ("None", "None A")])
def test_refuses_outputs_that_are_not_numbers(fastest_fmus: Path, tmp_path: Path, value: str, shown: str) -> None:
    path = controller(tmp_path, ("self.motor_i_c_cmd = cos(angle - -2.0 * pi / 3.0) * i_d",
                                 f"self.motor_i_c_cmd = {value} if t > 0.02 else 0.0 * i_d"))
    path.write_text(path.read_text().replace(" - sin(angle - -2.0 * pi / 3.0) * i_q", ""))
    with pytest.raises(tool.RunFailed) as failure, pytest.warns(UserWarning):
        tool.run(trial(tmp_path), controller=path, fmus=fastest_fmus)
    assert f"controller (pd.py): motor.i_c_cmd = {shown} at t = 0.0205 s, expected a finite number from PD" in str(
        failure.value)
    assert len(failure.value.recording.time) == 42


@pytest.mark.filterwarnings("ignore:controller .* has no")
def test_a_boolean_of_numpy_is_one(fastest_fmus: Path, tmp_path: Path) -> None:
    """As `a < b` is of numbers of NumPy; something else is refused by its name."""
    def running(far: str) -> Path:
        return controller(tmp_path, ("from math", "import numpy as np\nfrom math"),
                          ('outputs = {"motor.i_a_cmd"', 'outputs = {"far": "", "motor.i_a_cmd"'),
                          ("self.known = False", "self.known = self.far = False"),
                          ("w = self.bandwidth", f"self.far = {far}; w = self.bandwidth"))

    of_numpy, plain = (tool.run(trial(tmp_path), fmus=fastest_fmus, controller=running(far))["controller.far"]
                       for far in ("np.float64(t) > 0.2", "t > 0.2"))
    assert_array_equal(of_numpy, plain)
    path = running("0.5 if t > 0.02 else t > 0.01")
    with raises(tool.RunFailed, "0.0205 s", "pd.py", "far", 0.5, "True", "False"):
        tool.run(trial(tmp_path), controller=path, fmus=fastest_fmus)


def test_provenance_names_the_file_that_ran(fastest_fmus: Path, tmp_path: Path) -> None:
    """The file and the module next to it by their digests; the run is a modified one."""
    (tmp_path / "numbers_of_mine.py").write_text("LARGEST = 6.0\n")
    path = controller(tmp_path, ("LARGEST = 6.0\n", "from numbers_of_mine import LARGEST\n"))
    result = maglev("run", trial(tmp_path), "--fmus", fastest_fmus, "--out", tmp_path, "--controller", path)
    assert result.exit_code == 0, result.output
    written = json.loads((tmp_path / "trial.json").read_text())["provenance"]
    digests = {file.name: hashlib.sha256(file.read_bytes()).hexdigest()
               for file in (path, tmp_path / "numbers_of_mine.py")}
    assert (written["fmus"][0]["kind"], written["fmus"][0]["sha256"]) == ("Python file", digests)
    assert written["modified"]
    assert f"controller is pd.py (Python file, sha256 {digests['pd.py'][:12]}…)" in " ".join(
        (tmp_path / "trial.txt").read_text().split())


def test_changes_of_a_file_and_of_its_modules_count_at_once(tmp_path: Path) -> None:
    """In one process: a notebook does not start again for every change."""

    beside = tmp_path / "numbers_of_mine.py"
    path = controller(tmp_path, ("self.bandwidth = 60.0", "self.bandwidth = BANDWIDTH"),
                      ("LARGEST = 6.0\n", "LARGEST = 6.0\nfrom numbers_of_mine import BANDWIDTH\n"))
    for bandwidth in (40.0, 41.0):
        beside.write_text(f"BANDWIDTH = {bandwidth}\n")
        assert PythonFile(path).load().definition.starts["bandwidth"] == bandwidth


@pytest.mark.few(1)
@pytest.mark.parametrize("stage", PACKAGED_STAGES)
def test_the_first_controller_runs(fastest_fmus: Path, tmp_path: Path, stage: str) -> None:
    """From a new file, without a change, and within the limit of 4 A: through the first step."""
    path = tmp_path / "lqi.py"
    assert maglev("new", "controller", path, "--stage", stage).exit_code == 0
    assert len(path.read_text().splitlines()) < (170 if PACKAGED_STAGES[stage].rotations else 100)
    run = tmp_path / "short.toml"
    run.write_text(f'extends = "{load_plan(f"{stage}-setpoints").source}"\nname = "short"\nstop_time = "5.9 s"\n')
    result = maglev("run", run, "--fmus", fastest_fmus, "--out", tmp_path, "--controller", path)
    assert result.exit_code == 0, result.output
    metrics = json.loads((tmp_path / "short.json").read_text())["metrics"]
    assert not metrics["failed"]
    assert max(metrics["end_errors"].values()) < 10e-6   # the encoder's resolution; a tilt by a fifth of it
    assert "class LQI:" in path.read_text()
    before = path.read_text()
    assert "already exists" in error_line(maglev("new", "controller", path, "--stage", stage))
    assert path.read_text() == before


@pytest.mark.parametrize(("name", "expected"), [
    ("my_regulator.py", "class MyRegulator:"), ("mpc.py", "class MPC:"), ("with-dash.py", "class WithDash:")])
def test_classes_are_named_after_files(tmp_path: Path, name: str, expected: str) -> None:
    assert expected in new_controller(tmp_path / name).read_text()
