"""A run that is complete ends, whatever a controller leaves in its process: results are there, and one line says so."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from left_processes import ended, require_none
from written_controllers import controller, trial

# What a controller leaves behind at its last step, by name; and what is said of it.
LEFT = {
    "a thread": "threading.Thread(target=time.sleep, args=(600,)).start()",
    "threads that start others": "more()",
    "a function at the exit": "atexit.register(time.sleep, 600)",
    "a copy of the process": "os.fork() or time.sleep(600)",
    "a copy that continues": "os.fork()",
    "a program": "subprocess.Popen(['sleep', '600'])",
    "a program that holds the pipe": "subprocess.Popen(['sleep', '600'], close_fds=False)",
    "a closed pipe": "[os.close(fd) for fd in pipes()]",
    "signals that are ignored": "[signal.signal(n, signal.SIG_IGN) for n in (1, 2, 3, 15)]"}
KEPT = "still ran 2 s after the run, and was ended with its child processes"
BEHIND = "left child processes, which were ended after the run"
SAID = {"a thread": KEPT, "threads that start others": KEPT, "a function at the exit": KEPT,
        "a copy of the process": BEHIND, "a copy that continues": "", "a program": BEHIND,
        "a program that holds the pipe": BEHIND, "signals that are ignored": ""}

HELP = '''
import atexit, os, signal, stat, subprocess, threading, time

def more():
    """A thread that starts another one before it ends, for ten minutes."""
    if time.monotonic() < END:
        time.sleep(0.05)
        threading.Thread(target=more).start()

def pipes():
    """Pipes of this process next to its standard ones."""
    return [fd for fd in range(3, 64) if os.path.exists(f"/proc/self/fd/{fd}") and stat.S_ISFIFO(os.fstat(fd).st_mode)]

END = time.monotonic() + 600.0
'''


def leaving(folder: Path, what: str) -> Path:
    """The PD controller, which leaves something at its last step."""
    return controller(folder, ("from math import", f"{HELP}\nfrom math import"),
                      ("        w = self.bandwidth\n",
                       f"        w = self.bandwidth\n        if abs(t - 0.3995) < 1e-6:\n            {LEFT[what]}\n"))


@pytest.fixture
def marked(tmp_path: Path) -> Iterator[dict[str, str]]:
    """Environment of a command, by which all that it has started is known: in the end nothing of it is there."""
    folder = tmp_path / "unpacked"
    folder.mkdir()
    yield {**os.environ, "TMPDIR": str(folder)}
    assert list(folder.iterdir()) == []
    require_none(folder)


def command(scenario: Path, fmus: Path, path: Path, out: Path, timeout: str) -> list[str]:
    return [sys.executable, "-m", "maglev", "run", str(scenario), "--fmus", str(fmus), "--controller", str(path),
            "--out", str(out), "--timeout", timeout]


@pytest.mark.few(1)
@pytest.mark.parametrize("what", [pytest.param(what, marks=pytest.mark.thorough) if what.startswith("threads") else what
                                  for what in SAID])
def test_a_complete_run_ends(fastest_fmus: Path, tmp_path: Path, marked: dict[str, str], what: str) -> None:
    path = leaving(tmp_path, what)
    done = subprocess.run(command(trial(tmp_path), fastest_fmus, path, tmp_path, "2 s"), capture_output=True,
                          text=True, timeout=120, env=marked)
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "trial.json").read_text())["failure"] is None
    assert (tmp_path / "trial.csv").read_text().splitlines()[-1].startswith("0.4,")
    assert "Traceback" not in done.stderr
    said = [line for line in done.stderr.splitlines() if "the process of " in line]
    line = f"maglev: trial: the process of controller (pd.py) {SAID[what]}"
    # A copy ends as it has something to say: sooner or later than the first one.
    assert said == [line] if SAID[what] else said in ([], [f"{line}{BEHIND}"])


@pytest.mark.thorough
def test_a_pipe_that_is_closed_ends_the_run(fastest_fmus: Path, tmp_path: Path, marked: dict[str, str]) -> None:
    """The other side cannot know more, not even in which step."""
    path = leaving(tmp_path, "a closed pipe")
    done = subprocess.run(command(trial(tmp_path), fastest_fmus, path, tmp_path, "2 s"), capture_output=True,
                          text=True, timeout=120, env=marked)
    assert (done.returncode, "Traceback" in done.stderr) == (2, False), done.stderr
    line = done.stderr.strip().splitlines()[-1]
    assert re.search(r"^maglev: trial: at t = [0-9.]+ s: controller \(pd.py\) has closed the pipe of its process; "
                     r"what was recorded until then is in ", line), line


@pytest.mark.few(1)
@pytest.mark.parametrize(("number", "word"), [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated")])
def test_one_signal_is_enough_after_the_end(fastest_fmus: Path, tmp_path: Path, marked: dict[str, str], number: int,
                                            word: str) -> None:
    """The results are there when the signal comes, as the process of the run does not end; it lets nobody wait."""
    path = leaving(tmp_path, "a thread")
    begun = time.monotonic()
    process = subprocess.Popen(command(trial(tmp_path), fastest_fmus, path, tmp_path, "10 min"), text=True, env=marked,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
    end = begun + 120.0
    while not (tmp_path / "trial.json").exists():
        assert process.poll() is None and time.monotonic() < end
        time.sleep(0.02)
    os.killpg(process.pid, number)
    errors = ended(process, begun)
    assert (process.returncode, errors.splitlines()[-1]) == (
        128 + number, f"maglev: {word} after the end of the run; its results are in {tmp_path / 'trial.csv'}")
    assert "Traceback" not in errors


