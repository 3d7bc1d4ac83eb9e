"""What is edited or replaced while a run is under way changes nothing of the run, nor of what is known about it."""

import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import error_line
from command_line import maglev as command

import maglev
from maglev.files.copies import Copies, original
from maglev.files.scratch import PREFIX
from maglev.files.session import SESSION
from maglev.runs.preparation import prepare
from maglev.runs.replacement import Replacement
from maglev.scenario.loading import load_plan
from maglev.user.source import PythonFile

LAW = '''
from current import CURRENT

class Law:
    """Gives a current that a module next to it has, and one that it imports late."""

    inputs = {f"{axis}.{port}": "m" for axis in "vh" for port in ("measured", "reference")}
    outputs = {f"motor.i_{phase}_cmd": "A" for phase in "abc"}
    parameters = {}

    def __init__(self):
        from late import LATE
        self.late = LATE
        self.sample_time = 0.5e-3
        self.v_measured = self.v_reference = 20e-3
        self.h_measured = self.h_reference = 0.0
        self.motor_i_a_cmd = self.motor_i_b_cmd = self.motor_i_c_cmd = 0.0

    def step(self, t):
        self.motor_i_a_cmd = CURRENT
        self.motor_i_b_cmd = self.late
'''


@pytest.fixture
def fmus(fastest_fmus: Path) -> Path:
    """FMUs of either kind are run as copies."""
    return fastest_fmus


@pytest.fixture
def law(tmp_path: Path) -> Path:
    """A controller's file with two modules next to it."""
    (tmp_path / "current.py").write_text("CURRENT = 0.25\n")
    (tmp_path / "late.py").write_text("LATE = 0.5\n")
    path = tmp_path / "law.py"
    path.write_text(LAW)
    return path


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    """A short run with claims of its own."""
    path = tmp_path / "short.toml"
    path.write_text('extends = "2dof-setpoints.toml"\nname = "short"\nstop_time = "1 s"\nclaims = []\n')
    return path


def sha256(text: str | bytes) -> str:
    return hashlib.sha256(text.encode() if isinstance(text, str) else text).hexdigest()


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("text", ["class Law(:\n", LAW.replace("= CURRENT", "= 9.0")],
                         ids=["broken", "changed"])
def test_an_edit_in_mid_run_changes_nothing(fmus: Path, law: Path, scenario: Path, text: str) -> None:
    def edit(_done: int, _steps: int) -> None:
        law.write_text(text)
        (law.parent / "current.py").write_text("CURRENT = 9.0\n")
        (law.parent / "late.py").write_text("LATE = 9.0\n")

    run = maglev.run(scenario, controller=law, fmus=fmus, progress=edit)
    assert law.read_text() == text
    assert set(run["controller.motor.i_a_cmd"][1:]) == {0.25}
    assert run["controller.motor.i_b_cmd"][-1] == 0.5
    assert run.result.provenance is not None
    simulated = run.result.provenance.fmus[0]
    assert simulated.sha256 == {"law.py": sha256(LAW), "current.py": sha256("CURRENT = 0.25\n"),
                            "late.py": sha256("LATE = 0.5\n")}
    assert simulated.file == "law.py"


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_one_is_run_as_it_was_when_the_run_was_made_ready(fmus: Path, law: Path, scenario: Path) -> None:
    experiment = prepare(load_plan(scenario), fmus, {"controller": Replacement(PythonFile(law))}, {})
    law.write_text("class Law(:\n")
    (law.parent / "late.py").write_text("LATE = 9.0\n")
    assert experiment.run().columns["controller.motor.i_b_cmd"][-1] == 0.5
    assert experiment.provenance().fmus[0].sha256["law.py"] == sha256(LAW)


@pytest.mark.parametrize("name", ["controller", "plant"])
def test_an_fmu_that_is_replaced_in_mid_run_changes_nothing(fmus: Path, scenario: Path, tmp_path: Path,
                                                               name: str) -> None:
    folder, model = tmp_path / "fmus", {"controller": "Regulator2DOF.fmu", "plant": "Plant2DOF.fmu"}[name]
    folder.mkdir()
    for each in ("Regulator2DOF.fmu", "Plant2DOF.fmu"):
        shutil.copy(fmus / each, folder)
    before = (folder / model).read_bytes()

    def replace(_done: int, _all: int) -> None:
        (folder / model).write_bytes((fmus / "PID3DOF.fmu").read_bytes())

    run = maglev.run(scenario, fmus=folder, progress=replace)
    assert run.result.provenance is not None
    simulated = next(fmu for fmu in run.result.provenance.fmus if fmu.name == name)
    assert (folder / model).read_bytes() != before
    assert (simulated.model, simulated.sha256) == (model.removesuffix(".fmu"), {model: sha256(before)})
    assert np.array_equal(run["plant.v.position"], maglev.run(scenario, fmus=fmus)["plant.v.position"])


def test_it_is_in_the_record(fmus: Path, scenario: Path, tmp_path: Path) -> None:
    command("run", scenario, "--fmus", fmus, "--out", tmp_path)
    provenance = json.loads((tmp_path / "short.json").read_text())["provenance"]
    assert [fmu["sha256"] for fmu in provenance["fmus"]] == [
        {f"{name}.fmu": sha256((fmus / f"{name}.fmu").read_bytes())} for name in ("Regulator2DOF", "Plant2DOF")]


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_data_beside_the_file_are_found(fmus: Path, law: Path, scenario: Path, tmp_path: Path) -> None:
    (tmp_path / "gain.txt").write_text("0.75")
    (tmp_path / "named.py").write_text("GAIN = 2.0")
    law.write_text("from importlib import import_module\nfrom pathlib import Path\n"
                   "GAIN = float((Path(__file__).parent / 'gain.txt').read_text()) * import_module('named').GAIN\n"
                   + LAW.replace("= CURRENT", "= GAIN"))
    assert set(maglev.run(scenario, controller=law, fmus=fmus)["controller.motor.i_a_cmd"][1:]) == {1.5}


def test_refusals_name_the_file_itself(fmus: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.fmu").write_text("no FMU")
    done = command("run", "2dof-setpoints", "--controller", tmp_path / "mine.fmu", "--fmus", fmus, "--out", tmp_path)
    assert f"controller: {tmp_path / 'mine.fmu'} cannot be read as an FMU" in error_line(done)
    assert original(tmp_path / "mine.fmu") == tmp_path / "mine.fmu"


def test_copies_go_with_the_process(fmus: Path) -> None:
    code = ("from pathlib import Path; from maglev.files.copies import Copies; "
            "from maglev.files.session import SESSION; "
            "from maglev.runs.preparation import prepare; from maglev.scenario.loading import load_plan; "
            f"files = prepare(load_plan('2dof-setpoints'), Path({str(fmus)!r}), {{}}, {{}}).fmu_files; "
            "folder = SESSION.get(Copies).folder; "
            "assert all(folder in path.parents and path.is_file() for path in files.values()); print(folder)")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
    folder = Path(done.stdout.strip())
    assert folder.name.startswith(PREFIX)
    assert not folder.exists()
    assert folder != SESSION.get(Copies).folder
