"""Ctrl-C and SIGTERM: one line, exit code 130 or 143, recordings kept, no folder for temporary files left behind."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest
from facts import raises
from faulty_fmus import faulty
from left_processes import AT_ONCE, ended, processes_with, require_none
from native_builds import require_native_tools
from psutil import NoSuchProcess, Process

from maglev.files.errors import Interrupted
from maglev.runs.baseline_check import update_all
from maglev.runs.chain import prepare_all
from maglev.scenario.loading import load_plan

LONG = '\nextends = "{base}"\nname = "{name}"\ntitle = "A long hold"\nstop_time = "{seconds} s"\n'
CODES = [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")]


class Command:
    """`maglev` in a process group of its own, as a shell starts it."""

    def __init__(self, folder: Path, *arguments: str | Path, **environment: str):
        self.unpacked = folder / "unpacked"
        self.unpacked.mkdir()
        self.begun = time.monotonic()
        self.process = subprocess.Popen([sys.executable, "-m", "maglev", *arguments], text=True, stderr=subprocess.PIPE,
                                        stdout=subprocess.PIPE, cwd=folder, start_new_session=True,
                                        env={**os.environ, "TMPDIR": str(self.unpacked), "PYTHONUNBUFFERED": "1",
                                             **environment})

    def wait_until(self, condition: Callable[[], object]) -> None:
        """Wait for a condition, two minutes at most."""
        end = time.monotonic() + 120.0
        while not condition():
            assert self.process.poll() is None, self.process.communicate()
            assert time.monotonic() < end
            time.sleep(0.02)

    def busy(self, seconds: float) -> int:
        """How many of its processes have used a processor for so long (s)."""
        used = 0
        for process in Process(self.process.pid).children(recursive=True):
            with suppress(NoSuchProcess):
                used += process.cpu_times().user > seconds
        return used

    def ended(self, number: int) -> tuple[int, list[str]]:
        """Exit code and lines of standard error after a signal, which it obeys at once, whatever still continues.

        Ctrl-C goes to every process of a terminal.
        """
        if number == signal.SIGINT:
            os.killpg(self.process.pid, number)
        else:
            self.process.send_signal(number)
        errors = ended(self.process, self.begun)
        assert list(self.unpacked.iterdir()) == []
        require_none(self.unpacked, AT_ONCE)
        return self.process.returncode, errors.splitlines()


# Ctrl-C when the command line imports its first library.
IMPORTING = """
import os, runpy, signal, sys

class Interrupt:
    def find_spec(self, name, *_):
        if name == "typer":
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupt())
sys.argv = ["maglev", "list"]
runpy.run_module("maglev", run_name="__main__")
"""


def scenario(folder: Path, name: str, seconds: float) -> Path:
    path = folder / f"{name}.toml"
    path.write_text(LONG.format(base=load_plan("2dof-setpoints").source, name=name, seconds=seconds))
    return path


@pytest.fixture
def long(tmp_path: Path) -> Callable[[str], Path]:
    """Function that makes a scenario of a quarter of an hour."""
    return lambda name: scenario(tmp_path, name, 900)


def test_while_the_command_itself_is_imported() -> None:
    done = subprocess.run([sys.executable, "-c", IMPORTING], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "maglev: interrupted\n")


@pytest.mark.thorough
@pytest.mark.parametrize(("number", "code", "word"), CODES)
def test_a_run_of_python_fmus(fmus: Path, tmp_path: Path, long: Callable[[str], Path], number: int, code: int,
                              word: str) -> None:
    """The FMUs run in the Python that gets the signal, and are not blamed for it."""
    command = Command(tmp_path, "run", long("hold"), "--fmus", fmus)
    command.wait_until(lambda: len(list(command.unpacked.glob("maglev_*/resources"))) == 2)
    time.sleep(1.0)   # wherever the run is then
    found, lines = command.ended(number)
    assert (found, len(lines)) == (code, 1), lines
    partial = Path("results") / "hold.partial.csv"
    if "at t" in lines[0]:
        assert lines[0].startswith("maglev: at t = ")
        assert lines[0].endswith(f" s: {word}; what was recorded until then is in {partial}")
        assert len((tmp_path / partial).read_text().splitlines()) > 1
    else:
        assert lines[0] == f"maglev: {word}"


@pytest.mark.few(1)
@pytest.mark.parametrize(("number", "code", "word"), CODES)
def test_runs_side_by_side(fmus: Path, tmp_path: Path, long: Callable[[str], Path], number: int, code: int,
                           word: str) -> None:
    names = ["one", "two", "three"]
    command = Command(tmp_path, "run", *map(long, names), "--jobs", "2", "--fmus", fmus)
    command.wait_until(lambda: command.busy(4.0) == 2)   # of which importing takes one
    found, lines = command.ended(number)
    assert (found, len(lines)) == (code, 1), lines
    assert lines[0].startswith(f"maglev: {word}: 0 of 3 runs were done; ")
    for name in names[:2]:
        partial = Path("results") / f"{name}.partial.csv"
        assert f"{name} at t = " in lines[0]
        assert f"what was recorded until then is in {partial}" in lines[0]
        assert len((tmp_path / partial).read_text().splitlines()) > 1
    assert "three" not in lines[0]


@pytest.mark.few(1)
@pytest.mark.parametrize(("number", "code", "word"), CODES)
def test_a_foreign_fmu_that_hangs(fastest_fmus: Path, tmp_path: Path, number: int, code: int, word: str) -> None:
    ports = faulty("hang", tmp_path).with_name("sources") / "ports.toml"
    command = Command(tmp_path, "run", "2dof-step-1-nonlinear", "--controller", "pd_controller.fmu", "--map", ports,
                      "--fmus", fastest_fmus, "--timeout", "10 min")
    command.wait_until(lambda: [path for path in command.unpacked.glob("*/calls")
                                if int.from_bytes(path.read_bytes(), "little") > 1000])
    time.sleep(1.0)   # for the rest of the 0.1 s
    found, lines = command.ended(number)
    assert found == code
    assert lines[-1] == (f"maglev: at t = 0.1 s: {word}; what was recorded until then is in "
                         f"{Path('results') / '2dof-step-1-nonlinear.partial.csv'}")
    assert not [line for line in lines if not line.startswith("maglev: ")]


# A compiler that takes ten minutes in a program of its own, as zig's does.
COMPILER = """
import subprocess, sys
open(sys.argv[sys.argv.index("-o") + 1] + ".begun", "w").close()
subprocess.run(["sleep", "600"])
"""


@pytest.mark.few(1)
@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize(("number", "code", "word"), CODES)
def test_compilers(tmp_path: Path, number: int, code: int, word: str) -> None:
    """Two at a time, with others that wait."""
    require_native_tools()
    (tmp_path / "ziglang").mkdir()
    (tmp_path / "ziglang" / "__main__.py").write_text(COMPILER)
    (tmp_path / "ziglang" / "__init__.py").touch()
    command = Command(tmp_path, "build", "Commutation2DOF", "Measurement2DOF", "--kind", "native",
                      PYTHONPATH=str(tmp_path))
    command.wait_until(lambda: [name for *_, names in os.walk(command.unpacked) for name in names   # which come and go
                                if name.endswith(".begun")])
    assert command.ended(number) == (code, [f"maglev: {word}"])
    assert not list((tmp_path / "fmus" / "native").iterdir())


@pytest.mark.few(1)
@pytest.mark.parametrize("delay", [0.0, 0.06, 0.14])
def test_while_a_foreign_fmu_starts(fastest_fmus: Path, tmp_path: Path, delay: float) -> None:
    """Ctrl-C to all processes, when the other one has just been started, or does not yet ignore it."""
    ports = faulty("hang", tmp_path).with_name("sources") / "ports.toml"
    command = Command(tmp_path, "run", "2dof-step-1-nonlinear", "--controller", "pd_controller.fmu", "--map", ports,
                      "--fmus", fastest_fmus)
    command.wait_until(lambda: list(command.unpacked.glob("*/calls")))
    time.sleep(delay)   # wherever the start is then
    found, lines = command.ended(signal.SIGINT)
    assert found == 130
    assert lines[-1] == "maglev: interrupted" or lines[-1].startswith("maglev: at t = "), lines


def kept_more_than(number: int, parts: Path) -> bool:
    """Whether a study has kept more parts than that."""
    return len(list(parts.glob("samples-*.parquet"))) > number


@pytest.mark.thorough
def test_a_study_continues_with_resume(fastest_fmus: Path, tmp_path: Path) -> None:
    """Interrupted twice, whenever that is, its results are those, byte for byte, of one that was not.

    How many processes run each part makes no difference.
    """
    file = tmp_path / "payload.toml"
    file.write_text(f'name = "payload"\nscenario = "{scenario(tmp_path, "hold", 4.0)}"\nmetrics = ["rms error"]\n'
                    'keep = ["plant.v.position"]\nkeep_interval = "1 s"\n[[vary]]\nset = "plant.v.mass"\n'
                    'kind = "grid"\nfrom = 4\nto = 5\nnumber = 64\n')
    folders = [tmp_path / name for name in ("whole", "parts")]
    for folder in folders:
        folder.mkdir()
    arguments: list[str | Path] = ["study", file, "--fmus", fastest_fmus, "--jobs"]
    parts, before = folders[1] / "results" / "payload.parts", 0
    for (number, code, word), more in zip(CODES, (["2"], ["1", "--resume"]), strict=True):
        command = Command(folders[1], *arguments, *more)
        command.wait_until(partial(kept_more_than, before, parts))
        found, lines = command.ended(number)
        done = 8 * len(list(parts.glob("samples-*.parquet")))
        assert 8 * before < done < 64
        assert (found, lines) == (code, [f"maglev: {word}: {done} of 64 samples are kept in "
                                         f"{parts.relative_to(folders[1])}, resume continues with them"])
        command.unpacked.rmdir()
        before = done // 8
    for folder, more in zip(folders, (["1"], ["1", "--resume"]), strict=True):
        command = Command(folder, *arguments, *more)
        _, errors = command.process.communicate(timeout=300.0)
        assert command.process.returncode == 0, errors
        assert list(command.unpacked.iterdir()) == []
    whole, resumed = ({path.name: path.read_bytes() for path in (folder / "results").iterdir()} for folder in folders)
    assert set(whole) == {"payload.parquet", "payload.trajectories.parquet", "payload.html", "index.html"}
    assert resumed == whole


@pytest.mark.parametrize("delay", [
    0.6, *(pytest.param(each, marks=pytest.mark.thorough) for each in (0.0, 0.2, 1.2))])
@pytest.mark.parametrize(("number", "code", "word"), CODES)
def test_while_the_processes_of_a_study_start(fastest_fmus: Path, tmp_path: Path, number: int, code: int, word: str,
                                              delay: float) -> None:
    """When the first of them is there, and while they import what they need."""
    file = tmp_path / "payload.toml"
    file.write_text('name = "payload"\nscenario = "2dof-setpoints"\nmetrics = ["rms error"]\n[[vary]]\n'
                    'set = "plant.v.mass"\nkind = "grid"\nfrom = 4\nto = 5\nnumber = 64\n')
    # Threads, where a loop of another test was kept, are no processes.
    command = Command(tmp_path, "study", file, "--fmus", fastest_fmus, "--jobs", "2",
                      MAGLEV_CACHE=str(tmp_path / "cache"))
    command.wait_until(lambda: [line for line in processes_with(command.unpacked) if "files.worker_process" in line])
    time.sleep(delay)   # wherever their start is then
    found, lines = command.ended(number)
    assert (found, len(lines)) == (code, 1), lines
    assert lines[0].startswith(f"maglev: {word}: ") and "of 64 samples are kept in " in lines[0]


def test_an_interrupted_update_leaves_every_baseline(fastest_fmus: Path, tmp_path: Path) -> None:
    """Ctrl-C when the first of two runs is done."""
    plans = prepare_all([load_plan(scenario(tmp_path, name, 0.5)) for name in ("a", "b")], fastest_fmus, {}, {})

    def interrupt(_name: str, done: int, steps: int) -> None:
        if done == steps:
            raise KeyboardInterrupt

    with raises(Interrupted, "1 of 2"):
        update_all(plans, tmp_path / "baselines", 1, interrupt)
    assert not (tmp_path / "baselines").exists()
    assert {result.status for result in update_all(plans, tmp_path / "baselines", 1, lambda *_: None)} == {"new"}
    shutil.rmtree(tmp_path / "baselines")
