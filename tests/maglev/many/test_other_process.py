"""Samples that are run next to a worker: one that hangs is ended, and the others are what they are in any process."""

import os
import pickle
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from command_line import maglev as command
from facts import raises
from faulty_fmus import faulty, faulty_run
from tiny_study import UNCHANGED, planned, simulate_samples, tiny
from written_controllers import controller, trial

import maglev
from maglev.files.errors import MaglevError
from maglev.many import batches
from maglev.many import study_plan as planning
from maglev.many.samples import gathered, run_samples_apart
from maglev.many.study_plan import PlannedStudy, plan_study

pytestmark = pytest.mark.usefixtures("slow")

HANGS = (("        w = self.bandwidth\n", "        while self.bandwidth > 65.0:\n            PyDLL(None).pause()\n"
          "        w = self.bandwidth\n"), ("from math import", "from ctypes import PyDLL\nfrom math import"))


@pytest.fixture(autouse=True)
def one_batch(monkeypatch: pytest.MonkeyPatch) -> None:
    """Samples run next to their worker, those of each batch in a process of its own."""
    monkeypatch.setattr(batches, "FEWEST_BATCHES", 1)


def of_a_fault(fault: str, fmus: Path, folder: Path) -> PlannedStudy:
    table = tiny(vary=[{"set": "plant.v.mass", "kind": "list", "values": [4.0, 4.1]}])
    return plan_study(table, faulty_run(faulty(fault, folder), fmus), "study.toml", folder, UNCHANGED)


def test_the_same_samples_as_in_this_process(fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, keep=["plant.v.position"])
    expected = simulate_samples(study.job, 0, study.values)
    found = gathered(study.job, 0, run_samples_apart(study.job, study.values, 60.0))
    assert np.array_equal(found.values, expected.values, equal_nan=True)
    assert found.trajectories is not None and expected.trajectories is not None
    assert np.array_equal(found.trajectories, expected.trajectories)
    assert found.failures == expected.failures == (None,) * 20


def test_a_foreign_fmu_that_hangs(fastest_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It has a limit without being asked for one; what was unpacked is removed."""
    monkeypatch.setattr(planning, "LIMIT_OF_FOREIGN", 1.0)
    study = of_a_fault("hang", fastest_fmus, tmp_path)
    unpacked = tmp_path / "unpacked"
    unpacked.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(unpacked))
    assert study.job.limit == 1.0
    found = list(run_samples_apart(study.job, study.values, study.job.limit))
    assert [sample.failure for sample in found] == ["took longer than 1 s"] * 2
    assert all(np.isnan(sample.values).all() for sample in found)
    assert list(unpacked.iterdir()) == []


def test_fmus_that_cannot_be_loaded_are_no_sample_s_fault(fastest_fmus: Path, tmp_path: Path) -> None:
    study = of_a_fault("crash when loaded", fastest_fmus, tmp_path)
    with raises(MaglevError, "SIGSEGV"):
        list(run_samples_apart(study.job, study.values, 60.0))


def test_a_sample_that_hangs_costs_none_of_the_others(fastest_fmus: Path, tmp_path: Path) -> None:
    """From the command line: a user's controller holds Python's lock for ever, without the use of a processor."""
    path, scenario = controller(tmp_path, *HANGS), trial(tmp_path)
    result = command("study", scenario, "--vary", "controller.bandwidth=60,70,61", "--controller", path, "--fmus",
                     fastest_fmus, "--out", tmp_path, "--jobs", "1", "--sample-timeout", "5 s")
    assert result.exit_code == 0, result.output
    rows = maglev.Study(tmp_path / "trial.study.parquet").to_arrow().to_pylist()
    assert [row["failure"] for row in rows] == [None, "took longer than 5 s", None]
    for row in (rows[0], rows[2]):
        run = maglev.run(scenario, fmus=fastest_fmus, controller=path,
                         set={"controller.bandwidth": row["controller.bandwidth"]})
        assert run.metrics.rms_errors["v"] == row["rms error of v"]


@pytest.mark.parametrize(("values", "code"), [("0.7 ms,0.9 ms", 2), ("0.5 ms,0.7 ms", 0)])
def test_a_study_without_a_completed_sample(values: str, code: int, fastest_fmus: Path,
                                            tmp_path: Path) -> None:
    """It says so in its last line and in its exit code; its results are there."""
    result = command("study", trial(tmp_path), "--vary", f"controller.sample_time={values}", "--fmus", fastest_fmus,
                     "--out", tmp_path, "--jobs", "1")
    assert result.exit_code == code, result.output
    assert ("trial.study: no sample of 2 completed; the first failed: " in result.stderr) == (code == 2)
    assert maglev.Study(tmp_path / "trial.study.parquet").to_arrow().num_rows == 2


def test_a_controller_that_ends_its_process_costs_its_sample_and_no_worker(fastest_fmus: Path,
                                                                           tmp_path: Path) -> None:
    """Without being asked for a limit."""
    exits = ("        w = self.bandwidth\n", "        if self.bandwidth > 65.0:\n            os._exit(0)\n"
                                              "        w = self.bandwidth\n")
    path = controller(tmp_path, exits, ("from math import", "import os\nfrom math import"))
    result = command("study", trial(tmp_path), "--vary", "controller.bandwidth=60,70", "--controller", path,
                     "--fmus", fastest_fmus, "--out", tmp_path, "--jobs", "1")
    rows = maglev.Study(tmp_path / "trial.study.parquet").to_arrow().to_pylist()
    assert (result.exit_code, [row["failure"] for row in rows]) == (
        0, [None, "the process that ran it ended (exit code 0)"])


WORKER = """
import sys
sys.path[:] = {path!r}
import pickle
from functools import partial
from maglev.cosim.helper_process import other_process
from maglev.many.samples import send_samples
job, values = pickle.loads(open({job!r}, "rb").read())
with other_process() as (worker, _):
    worker.ask(partial(send_samples, job, values))
    worker.next(600.0)
    print(worker.process.pid, flush=True)
    worker.next(600.0)
"""


def test_it_ends_with_its_worker(fastest_fmus: Path, tmp_path: Path) -> None:
    study = of_a_fault("hang", fastest_fmus, tmp_path)
    (tmp_path / "job").write_bytes(pickle.dumps((study.job, study.values)))
    worker = subprocess.Popen([sys.executable, "-c", WORKER.format(path=sys.path, job=str(tmp_path / "job"))],
                              stdout=subprocess.PIPE, text=True)
    assert worker.stdout is not None
    process = int(worker.stdout.readline())
    os.kill(process, 0)   # it is there
    worker.kill()
    worker.communicate()
    end = time.monotonic() + 30.0
    while time.monotonic() < end:
        try:
            if Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
                break
        except OSError:
            break
        time.sleep(0.1)
    else:
        pytest.fail("it lives on")
