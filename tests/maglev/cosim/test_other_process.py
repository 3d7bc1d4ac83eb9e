"""FMUs of others run in a process of their own: what one of them does there is named, and takes nothing with it."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from math import inf
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from facts import raises, require_facts
from faulty_fmus import AT, claiming, faulty, faulty_run
from left_processes import require_none
from psutil import Process
from small_fmus import small_fmu

from maglev.cosim.fmi_versions import OWN_TOOL
from maglev.cosim.fmu import FATAL, Fmu, read_description
from maglev.cosim.isolated_run import (
    COUNTER,
    Failed,
    Finished,
    Follower,
    IsolatedRun,
    Stepped,
    Wired,
    Work,
    run_apart,
)
from maglev.cosim.master import FmuSetup, Recording, RunFailed, RunInterrupted
from maglev.files.errors import FmuError
from maglev.files.json_lines import line_of
from maglev.files.scratch import remove_leftovers
from maglev.files.worker_process import Said, WorkerProcess, said_in
from maglev.runs.execution import execute
from maglev.user.source import FmuFile

ROWS = round(AT / 5e-4) + 1   # until the fault, with the first one


@pytest.fixture(scope="module")
def fmus(fastest_fmus: Path) -> Path:
    """The plant next to what is at fault is of either kind."""
    return fastest_fmus


@pytest.fixture
def unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder for temporary files, which has to be empty in the end, as has the list of processes."""
    folder = tmp_path / "unpacked"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    before = set(Process().children())   # one may wait for a run
    yield folder
    assert list(folder.iterdir()) == []
    assert set(Process().children()) <= before


@pytest.fixture(scope="module")
def healthy(fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """The run under the same controller without a fault."""
    return faulty_run(faulty("none", tmp_path_factory.mktemp("none")), fmus).run()


def require_beginning(recording: Recording, healthy: Recording, rows: int) -> None:
    assert len(recording.time) == rows
    assert list(recording.columns) == list(healthy.columns)
    for name, values in recording.columns.items():
        assert np.array_equal(values, healthy.columns[name][:rows]), name


def test_a_run_apart_is_the_run_here(fmus: Path, healthy: Recording, tmp_path: Path,
                                     monkeypatch: pytest.MonkeyPatch) -> None:
    """Bit for bit, with the same columns in the same order."""
    monkeypatch.setattr(FmuFile, "foreign", False)
    require_beginning(healthy, faulty_run(faulty("none", tmp_path), fmus).run(), 601)
    assert np.ptp(healthy.columns["plant.v.position"]) > 0.0


@pytest.mark.few(2)
@pytest.mark.parametrize(("fault", "fact"), [
    ("crash", "SIGSEGV"), ("exit", "exit code 0"), ("hang", "5 s"), ("negative", "status -1")])
def test_a_fault_in_a_step_is_named_and_keeps_the_recording(fmus: Path, healthy: Recording, tmp_path: Path,
                                                            unpacked: Path, fault: str, fact: str) -> None:
    experiment = faulty_run(faulty(fault, tmp_path), fmus, timeout=5.0)
    with raises(RunFailed, "0.1 s", "controller", "pd_controller.fmu", "fmi2DoStep", fact) as failure:
        experiment.run()
    require_beginning(failure.value.recording, healthy, ROWS)


@pytest.mark.few(1)
@pytest.mark.parametrize(("fault", "message"), [
    ("crash", "ended its process with SIGSEGV"), ("exit", "ended its process with exit code 0"),
    ("hang", "has been silent for 5 s")])
def test_an_fmu_that_claims_to_be_ours_is_not_trusted(fmus: Path, tmp_path: Path, unpacked: Path, fault: str,
                                                      message: str) -> None:
    """In a process of its own: what it does would otherwise be done to the one that runs it."""
    fmu = claiming(faulty(fault, tmp_path))
    assert read_description("controller", fmu).generationTool.startswith(OWN_TOOL)
    found = subprocess.run([sys.executable, "-c", ALONE, fmu, fmus, "5"], capture_output=True, text=True, timeout=120,
                           env={**os.environ, "TMPDIR": str(unpacked), "PYTHONPATH": os.pathsep.join(
                               path for path in sys.path if path)})
    assert found.returncode == 1
    assert f"RunFailed: at t = 0.1 s: controller ({fmu.name}) {message} in fmi2DoStep" in found.stderr


def test_an_fmu_that_claims_to_be_ours_is_not_freed_after_a_fatal_status(fmus: Path, tmp_path: Path,
                                                                         unpacked: Path) -> None:
    """FMI forbids every call after it; that FMU's would crash. Ours can be freed, and are."""
    fmu = claiming(faulty("fatal", tmp_path))
    with Fmu("controller", FmuFile(fmu), read_description("controller", fmu)) as loaded:
        loaded.failed("fmi2DoStep", FATAL)
    with Fmu("plant", FmuFile(ours := fmus / "Plant2DOF.fmu"), read_description("plant", ours)) as loaded:
        freed = []
        assert loaded.instance is not None
        loaded.instance.freeInstance, free = lambda: freed.append("ours"), loaded.instance.freeInstance
        loaded.failed("fmi2DoStep", FATAL)
    assert freed == ["ours"]
    free()


@pytest.mark.parametrize(("fault", "end"), [("crash when freed", "SIGSEGV"), ("exit when freed", "exit code 0")])
def test_a_fault_after_the_end_loses_nothing(fmus: Path, healthy: Recording, tmp_path: Path, unpacked: Path,
                                             fault: str, end: str) -> None:
    recording = faulty_run(faulty(fault, tmp_path), fmus).run()
    require_beginning(recording, healthy, 601)
    assert recording.notes == (f"controller (pd_controller.fmu) ended its process with {end} in fmi2FreeInstance, "
                               "after the end of the run",)


def small_run(folder: Path, hole: str) -> Recording:
    """A run of the small FMU of FMI 3.0 apart, which aborts in a hole."""
    fmu = small_fmu(folder, {hole: "if (late(f)) abort();" if hole == "IN_STEP" else "abort();"})
    return run_apart(IsolatedRun([FmuSetup("small", fmu)], [], 0.05, "sequential", 0.3, {"small.u": np.zeros(7)}))


@pytest.mark.usefixtures("slow", "unpacked")
@pytest.mark.parametrize(("hole", "call", "time", "points"), [
    ("IN_STEP", "fmi3DoStep", "0.1", 3), ("IN_TERMINATE", "fmi3Terminate", "0.3", 7)])
def test_a_fault_of_fmi_3_is_named_as_it_is_called_there(tmp_path: Path, hole: str, call: str, time: str,
                                                         points: int) -> None:
    with raises(RunFailed, f"{time} s", "small.fmu", "SIGABRT", call) as failure:
        small_run(tmp_path, hole)
    assert len(failure.value.recording.time) == points


@pytest.mark.usefixtures("slow", "unpacked")
def test_a_fault_of_fmi_3_after_the_end_is_named_as_it_is_called_there(tmp_path: Path) -> None:
    """Not fmi2FreeInstance; and nothing of the run is lost."""
    recording = small_run(tmp_path, "IN_FREE")
    assert recording.notes == ("small (small.fmu) ended its process with SIGABRT in fmi3FreeInstance, after the end of "
                               "the run",)
    np.testing.assert_allclose(recording.columns["small.y"], np.exp(-recording.time), rtol=1e-12)
    assert len(recording.time) == 7


@pytest.mark.few(3)
@pytest.mark.parametrize(("fault", "facts"), [
    ("cut the recording", ["0.1 s", "SIGBUS"]), ("cut the counter", ["SIGBUS", "count of calls"]),
    ("cut the recording in the end", ["0.3 s", "truncated", "recording"]), ("write into pipes", ["written", "pipe"]),
    ("close pipes", ["closed", "pipe"]), ("error in the end", ["0.3 s", "fmi2Terminate"]),
    ("crash in the end", ["0.3 s", "SIGSEGV", "fmi2Terminate"])])
def test_what_ends_nothing_but_the_run(fmus: Path, healthy: Recording, tmp_path: Path, unpacked: Path, fault: str,
                                       facts: list[str]) -> None:
    """Whatever an FMU does to what it shares with this process, that continues and has a name for it."""
    experiment = faulty_run(faulty(fault, tmp_path), fmus)
    with pytest.raises((RunFailed, FmuError)) as failure:
        experiment.run()
    require_facts(failure.value, "controller", "pd_controller.fmu", *facts)
    if fault == "cut the counter" and not isinstance(failure.value, RunFailed):   # nobody had read it before
        return
    assert isinstance(failure.value, RunFailed)
    assert str(failure.value).startswith("at t = ")
    recorded = failure.value.recording
    if not fault.startswith("cut"):
        require_beginning(recorded, healthy, len(recorded.time))
        assert len(recorded.time) >= ROWS


def test_a_fault_in_loading_is_refused(fmus: Path, tmp_path: Path, unpacked: Path) -> None:
    with raises(FmuError, "controller", "pd_controller.fmu", "SIGSEGV", "loading"):
        faulty_run(faulty("crash when loaded", tmp_path), fmus).run()


@pytest.mark.parametrize("fault", ["warn", "warn without a name", "warn in another name"])
def test_warnings_are_counted_and_said_once(fmus: Path, healthy: Recording, tmp_path: Path, unpacked: Path,
                                            fault: str) -> None:
    """Whatever name the FMU gives itself: the plant next to it, of this project, has said nothing."""
    result = execute(faulty_run(faulty(fault, tmp_path), fmus), tmp_path / "out")
    (note,) = result.recording.notes
    assert note.startswith("controller (pd_controller.fmu) says: gap is odd at t = 0 s; gap is odd at t = 0.0005 s; ")
    assert note.endswith("gap is odd at t = 0.0095 s; and 580 more messages")
    assert np.array_equal(result.columns["plant.v.position"], healthy.columns["plant.v.position"][::2])


def test_interrupt_keeps_the_recording(fmus: Path, healthy: Recording, tmp_path: Path, unpacked: Path,
                                       monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C when the FMU has come to its fault, or is not far from it."""
    look = Follower.calls

    def calls(self: Follower) -> int:
        found = look(self)
        if found > 3 * ROWS and interrupts:
            os.kill(os.getpid(), interrupts.pop())
        return found

    interrupts = [signal.SIGINT]
    monkeypatch.setattr(Follower, "calls", calls)
    with raises(RunInterrupted) as failure:
        faulty_run(faulty("hang", tmp_path), fmus).run()
    require_beginning(failure.value.recording, healthy, len(failure.value.recording.time))
    assert failure.value.number == signal.SIGINT


def test_interrupt_before_it_is_read_what_runs(fmus: Path, healthy: Recording, tmp_path: Path, unpacked: Path,
                                               monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C on a machine that is so busy that what the process has told is still in the pipe."""
    read, interrupts = WorkerProcess.next, [signal.SIGINT]

    def late(self: WorkerProcess, limit: float = inf, sign: Callable[[], object] = lambda: None) -> Said:
        if interrupts:
            interrupts.pop()
            until(lambda: int(str(sign())) > 3 * ROWS)
            raise KeyboardInterrupt
        return read(self, limit, sign)

    monkeypatch.setattr(WorkerProcess, "next", late)
    with raises(RunInterrupted) as failure:
        faulty_run(faulty("hang", tmp_path), fmus).run()
    require_beginning(failure.value.recording, healthy, len(failure.value.recording.time))


CALL = Work("theirs", "fmi2DoStep")
WIRED = Wired([CALL], [[CALL]], [CALL], [["theirs.y"]])


class Liar:
    """A process that says what it was told to say; it has done what makes a run and recorded it all."""

    left = False

    def __init__(self, *said: object):
        self.said = [Said("report", what) for what in said]

    def next(self, limit: float = inf, sign: Callable[[], object] = lambda: None) -> Said:
        return said_in(line_of(self.said.pop(0)))

    def end(self) -> None:
        self.said.clear()


@pytest.mark.parametrize("reports", [
    [7], ["Finished"], [Finished(())], [Stepped(1, 6)], [WIRED, WIRED], [WIRED, Stepped(7, 6)], [WIRED, Stepped(-1, 6)],
    [Wired([], [[]], [CALL], [["theirs.y"]])], [Wired([], [], [CALL], [["theirs.y"]])],
    [Wired([], [[CALL]], [], [["theirs.y"]])], [Wired([CALL], [[CALL]], [CALL], [["theirs.z"]])]], ids=range(11))
def test_reports_that_no_run_sends_end_it(reports: list[object], tmp_path: Path) -> None:
    with pytest.raises((FmuError, RunFailed)) as failure:
        told(tmp_path, *reports)
    require_facts(failure.value, "theirs.fmu", "written", "pipe")


@pytest.mark.parametrize("rows", [99999999999999, 7, 3, -1])
def test_a_failure_after_rows_that_are_not_there_has_those_that_are(rows: int, tmp_path: Path) -> None:
    with raises(RunFailed, "boom") as failure:
        told(tmp_path, WIRED, Failed("boom", rows, ""))
    assert len(failure.value.recording.time) == max(0, min(rows, 5))


@pytest.mark.parametrize("name", ["track0.object", "track0.nonsense", "track1.float64"])
def test_names_a_recording_without_a_file(name: str, tmp_path: Path) -> None:
    (tmp_path / "track0.float64").write_bytes(bytes(40))
    (tmp_path / "track0.float64").rename(tmp_path / name)
    with raises(RunFailed, "theirs.fmu", "recording"):
        told(tmp_path, WIRED, Finished(()), track=None)


def told(folder: Path, *reports: object, track: str | None = "track0.float64") -> Recording:
    """What becomes of a run of six steps of which a process has recorded five points, and says this."""
    if track:
        (folder / track).write_bytes(np.arange(5.0).tobytes())
    (folder / COUNTER).write_bytes(int.to_bytes(2**62, 8, "little"))
    run = IsolatedRun([FmuSetup("theirs", folder / "theirs.fmu")], [], 0.05, "sequential", 0.3, {}, None,
                      frozenset(["theirs.y"]))
    return Follower(run, folder, cast(WorkerProcess, Liar(*reports)), 1.0).follow(None, lambda _: None)


STARTED = """
from pathlib import Path
from maglev.files.worker_process import WorkerProcess
worker = WorkerProcess()
print(Path(f"/proc/{worker.process.pid}/status").read_text())
worker.end()
"""


def test_a_process_is_started_with_interrupts_blocked() -> None:
    found = subprocess.run([sys.executable, "-c", STARTED], capture_output=True, text=True, check=True,
                           env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)})
    blocked, = (line.split()[1] for line in found.stdout.splitlines() if line.startswith("SigBlk:"))
    assert int(blocked, 16) & 1 << signal.SIGINT - 1


DEAD = """
import sys
from pathlib import Path
from faulty_fmus import faulty_run
sys.executable = "/bin/false"
faulty_run(Path(sys.argv[1]), Path(sys.argv[2]), stop_time=60.0).run()
"""


def test_a_process_that_dies_at_its_start_is_named(fmus: Path, tmp_path: Path, unpacked: Path) -> None:
    """Whoever wrote it a run of several megabytes would wait for ever."""
    found = subprocess.run([sys.executable, "-c", DEAD, faulty("none", tmp_path), fmus], capture_output=True, text=True,
                           timeout=120, env={**os.environ, "TMPDIR": str(unpacked), "PYTHONPATH": os.pathsep.join(
                               path for path in sys.path if path)})
    assert "FmuError: the process of the run ended its process with exit code 1 in its start" in found.stderr


ALONE = """
import sys
from pathlib import Path
from faulty_fmus import faulty_run
faulty_run(Path(sys.argv[1]), Path(sys.argv[2]), timeout=float(sys.argv[3])).run()
"""


def test_nothing_survives_the_death_of_the_parent(fmus: Path, tmp_path: Path, unpacked: Path) -> None:
    """A script without a guard for child processes; it is killed while its FMU hangs."""
    folders = os.pathsep.join(path for path in sys.path if path)
    script = tmp_path / "script.py"
    script.write_text(ALONE)
    parent = subprocess.Popen([sys.executable, script, faulty("hang", tmp_path), fmus, "60"],
                              env={**os.environ, "TMPDIR": str(unpacked), "PYTHONPATH": folders})
    until(lambda: [path for path in unpacked.glob("*/calls") if int.from_bytes(path.read_bytes(), "little") > ROWS])
    assert parent.poll() is None
    parent.kill()
    parent.wait()
    until(lambda: not list(unpacked.glob("*/calls")))
    require_none(unpacked)
    remove_leftovers(unpacked)   # the copies of what ran, as the next command does


def until(condition: object) -> None:
    """Wait for a condition, a minute at most."""
    assert callable(condition)
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)
