"""What a Python file does to the process that runs it: it ends it, hangs, prints. None of that is a result."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import error_line, maglev
from facts import raises
from written_controllers import PD, controller, line_of, trial

import maglev as tool
from maglev.cosim import helper_process as helper

PLACES = {"import": ("LARGEST = 6.0\n", "LARGEST = 6.0\n{}\n"),
          "__init__": ("        self.known = False\n", "        self.known = False\n        {}\n"),
          "step": ("        w = self.bandwidth\n",
                   "        w = self.bandwidth\n        if t > 0.1001:\n            {}\n")}


def misbehaving(folder: Path, place: str, statement: str) -> Path:
    """The PD controller with a statement where it is imported, made or stepped."""
    before, after = PLACES[place]
    return controller(folder, (before, after.format(statement)),
                      ("from math import", "import os\nimport sys\nfrom math import"))


def command(*arguments: str | Path) -> "subprocess.CompletedProcess[str]":
    """The command in a process of its own: what ends that would end these tests, too."""
    return subprocess.run([sys.executable, "-m", "maglev", *map(str, arguments)], capture_output=True, text=True,
                          timeout=300)


@pytest.mark.few(1)
@pytest.mark.parametrize(("place", "statement"), [("import", "os._exit(0)"), ("__init__", "sys.exit(0)"),
                                                  ("step", "sys.exit(0)"), ("step", "os._exit(0)")])
def test_a_file_that_ends_its_process_has_no_result(fastest_fmus: Path, tmp_path: Path, place: str,
                                                    statement: str) -> None:
    path = misbehaving(tmp_path, place, statement)
    done = command("run", trial(tmp_path), "--fmus", fastest_fmus, "--out", tmp_path, "--controller", path)
    assert done.returncode == 2, done.stderr
    last = done.stderr.strip().splitlines()[-1]
    if statement == "sys.exit(0)":
        assert f"pd.py, line {line_of(path, statement)}: SystemExit: 0" in last
    else:
        assert ("controller (pd.py) ended its process with exit code 0 in fmi2DoStep" if place == "step" else
                "maglev: pd.py: ended the process that reads it with exit code 0, expected an importable") in last
    assert (tmp_path / "trial.partial.csv").exists() == (place == "step")
    if place == "step":
        assert "at t = 0.1005 s: " in last
        assert (tmp_path / "trial.partial.csv").read_text().splitlines()[-1].startswith("0.1005,")


@pytest.mark.parametrize("statement", ["raise KeyboardInterrupt", "raise GeneratorExit"])
def test_any_error_of_a_step_is_reported_once(fastest_fmus: Path, tmp_path: Path, statement: str) -> None:
    """With file and line; nobody has pressed Ctrl-C."""
    path = misbehaving(tmp_path, "step", statement)
    done = command("run", trial(tmp_path), "--fmus", fastest_fmus, "--out", tmp_path, "--controller", path)
    assert done.returncode == 2, done.stderr
    said = f"pd.py, line {line_of(path, statement)}: {statement.split()[1]}"
    assert said in done.stderr.strip().splitlines()[-1] and "Traceback" not in done.stderr
    assert "did not complete" in done.stdout and said not in done.stdout
    assert said in " ".join((tmp_path / "trial.txt").read_text().split())


def test_compare_continues_without_it(fastest_fmus: Path, tmp_path: Path) -> None:
    path = misbehaving(tmp_path, "step", "os._exit(0)")
    done = command("compare", trial(tmp_path), "--fmus", fastest_fmus, "--out", tmp_path, "--controller",
                   "Regulator2DOF", "--controller", path)
    assert done.returncode == 2, done.stderr
    assert "maglev: pd: at t = 0.1005 s: controller (pd.py) ended its process with exit code 0" in done.stderr
    assert (tmp_path / "trial@Regulator2DOF.csv").exists()


@pytest.mark.few(1)
@pytest.mark.parametrize("words", [["study", "SCENARIO", "--vary", "plant.v.mass=4,5", "--jobs", "1"], ["build"]])
def test_what_builds_an_fmu_of_it(fastest_fmus: Path, tmp_path: Path, words: list[str]) -> None:
    path = misbehaving(tmp_path, "import", "os._exit(0)")
    given = ["--controller", path, "--out", tmp_path] if words[0] == "study" else [path]
    words = [str(trial(tmp_path)) if word == "SCENARIO" else word for word in words]
    done = command(*words, *given, "--fmus", fastest_fmus if words[0] == "study" else tmp_path)
    assert done.returncode == 2
    assert done.stderr.strip().splitlines()[-1].startswith("maglev: pd.py: ended the process that reads it with exit")


def test_a_step_that_hangs_ends_at_the_timeout(fastest_fmus: Path, tmp_path: Path) -> None:
    path = misbehaving(tmp_path, "step", "while True: pass")
    with raises(tool.RunFailed, "0.1005 s", "controller", "pd.py", "3 s", "fmi2DoStep") as failure, \
            pytest.warns(UserWarning):
        tool.run(trial(tmp_path), controller=path, fmus=fastest_fmus, timeout=3.0)
    whole = tool.run(trial(tmp_path), controller=controller(tmp_path, name="whole.py"), fmus=fastest_fmus)
    recorded = failure.value.recording
    assert len(recorded.time) == 202
    for name, values in recorded.columns.items():
        np.testing.assert_array_equal(values[::2], whole[name][:101], err_msg=name)   # results are every 1 ms


def test_an_import_that_hangs(fastest_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(helper, "STARTED_WITHIN", 3.0)
    path = misbehaving(tmp_path, "import", "import time\ntime.sleep(600)")
    line = error_line(maglev("run", trial(tmp_path), "--controller", path, "--fmus", fastest_fmus, "--out", tmp_path,
                             "--timeout", "2 s"))
    assert line.startswith("maglev: pd.py: was not read within 3 s, expected an importable file")


@pytest.mark.few(1)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_one_signal_ends_a_step_that_hangs(fastest_fmus: Path, tmp_path: Path, number: int) -> None:
    path = misbehaving(tmp_path, "step", "(open('hangs', 'w').close() or exec('while True: pass'))")
    process = subprocess.Popen([sys.executable, "-m", "maglev", "run", trial(tmp_path), "--controller", path, "--fmus",
                                fastest_fmus.absolute(), "--timeout", "10 min"], cwd=tmp_path, text=True,
                               stderr=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True,
                               env={**os.environ, "PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))})
    while not (tmp_path / "hangs").exists():
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.05)
    os.killpg(process.pid, number)
    _, errors = process.communicate(timeout=60)
    word = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}[signal.Signals(number)]
    assert process.returncode == 128 + number
    assert errors.splitlines()[-1].startswith(f"maglev: at t = 0.1005 s: {word}; what was recorded until then is in ")


def test_its_output_is_next_to_the_results(fastest_fmus: Path, tmp_path: Path) -> None:
    path = misbehaving(tmp_path, "step", "print('a step')")
    path.write_text("print('imported')\nimport os\nos.system('echo from another process')\n" + path.read_text())
    done = command("run", trial(tmp_path), "--json", "--fmus", fastest_fmus, "--out", tmp_path, "--controller", path)
    assert done.returncode == 0, done.stderr
    assert list(json.loads(done.stdout)["runs"]) == ["trial"]
    for text in ("imported", "from another process", "a step"):
        assert text in done.stderr.splitlines()


def test_a_class_runs_in_this_process(fastest_fmus: Path, tmp_path: Path) -> None:
    """So that a debugger reaches it; the file runs in another, with the same bits."""
    names: dict[str, Any] = {}
    exec(PD, names)
    base: Any = names["PD"]
    processes = []

    class Told(base):   # type: ignore[misc]
        """PD that tells where it is."""

        def start(self) -> None:
            processes.append(os.getpid())

    run = tool.run(trial(tmp_path), controller=Told, fmus=fastest_fmus)
    assert processes == [os.getpid()]
    of_file = tool.run(trial(tmp_path), controller=controller(tmp_path), fmus=fastest_fmus)
    np.testing.assert_array_equal(run["plant.v.position"], of_file["plant.v.position"])


AWAY = '''
class Away:
    """A plant that runs away."""

    inputs = {f"motor.i_{phase}_cmd": "A" for phase in "abc"}
    outputs = {f"{axis}.{what}": "m" for axis in "vh" for what in ("encoder", "position")}

    def __init__(self):
        self.sample_time = 0.5e-3
        self.motor_i_a_cmd = self.motor_i_b_cmd = self.motor_i_c_cmd = 0.0
        self.v_encoder = self.v_position = 20e-3
        self.h_encoder = self.h_position = 0.0

    def step(self, t):
        self.v_encoder = self.v_position = 20e-3 * 2.0 ** (t / 0.5e-3)
'''


@pytest.mark.filterwarnings("ignore:plant .* has no")
@pytest.mark.filterwarnings("ignore:plant .* starts with")
def test_who_left_the_range_first_is_said(fastest_fmus: Path, tmp_path: Path) -> None:
    """It is not the controller, which refuses such a measurement."""
    (tmp_path / "away.py").write_text(AWAY)
    with raises(tool.RunFailed, "0.005 s", "plant.v.encoder", "10.24 m", "-10…10 m", "controller.v.measured",
                "Regulator2DOF.fmu", "fmi2SetReal"):
        tool.run("2dof-step-1-nonlinear", plant=tmp_path / "away.py", fmus=fastest_fmus)
