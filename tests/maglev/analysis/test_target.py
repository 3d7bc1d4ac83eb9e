"""Controllers on an emulated Cortex-M7: the bits of the native run, what they take, and what is refused."""

import json
import re
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from command_line import error_line, maglev
from facts import raises, require_facts
from native_builds import require_native_tools
from written_controllers import LOOPS, PD, TRIAL

import maglev as front_door
from maglev.analysis.target import (
    MISSING,
    OPTIONS,
    PROGRAM,
    Emulated,
    Emulator,
    EmulatorError,
    Measured,
    equal_columns,
    generated,
    in_the_loop,
    linked,
    on_target,
)
from maglev.api.comparing import put_in
from maglev.api.target import usual_run
from maglev.cosim.master import Recording, RunFailed
from maglev.descriptions.own_fmus import definition
from maglev.files.errors import FmuError, installing
from maglev.runs.preparation import Experiment
from maglev.scenario.loading import load_plan


@pytest.fixture(autouse=True)
def tools(slow: None) -> None:
    """Skip without a compiler or the emulator."""
    require_native_tools()
    if shutil.which(PROGRAM) is None:
        pytest.skip(MISSING)


def short(run: str, controller: str, fmus: Path, stop_time: float,
          changes: dict[str, float | bool] | None = None) -> Experiment:
    """The beginning of a run with a controller."""
    plan = load_plan(run).model_copy(update={"stop_time": stop_time})
    return put_in(plan, controller, controller, {"kind": "native", "fmus": fmus, "set": changes or {}})


@pytest.fixture
def fmus(native_fmus: Path, tmp_path: Path) -> Path:
    """Folder with a folder of native FMUs, as commands take it."""
    (tmp_path / "fmus").mkdir()
    (tmp_path / "fmus" / "native").symlink_to(native_fmus)
    return tmp_path / "fmus"


@pytest.mark.thorough
@pytest.mark.parametrize(("controller", "run"), [
    ("Regulator3DOF", "3dof-setpoints-improved"), ("ScheduledRegulator3DOF", "3dof-setpoints"),
    ("LinearRegulator5DOF", "5dof-setpoints"), ("PID2DOF", "2dof-setpoints")])
def test_bits_in_the_loop(fmus: Path, tmp_path: Path, controller: str, run: str) -> None:
    """Of all signals of controller and plant; a sample takes about as long as the one before."""
    found = on_target(*generated(controller), short(run, controller, fmus, 0.2), "controller", tmp_path, 216e6, 1.5,
                      60.0)
    assert found.columns > 25 and found.samples == round(0.2 / found.sample_time)
    assert 100 < found.least <= found.mean <= found.most < 1e4
    assert found.most < 3 * found.least
    assert 4e3 < found.flash < 5e4 and 300 < found.ram < 4e3 and 100 < found.stack < 4e3
    assert found.time == pytest.approx(found.most * 1.5 / 216e6)


def test_settings_reach_the_processor(fmus: Path, tmp_path: Path) -> None:
    """Parameters and Booleans of the controller, with which the run has other currents, and the same bits again."""
    plain = short("3dof-setpoints", "Regulator3DOF", fmus, 0.1)
    changed = short("3dof-setpoints", "Regulator3DOF", fmus, 0.1,
                    {"controller.current_limit": 0.6, "controller.antiwindup": False, "controller.y.k1": -1500.0})
    names = [f"controller.alpha.i_{phase}_cmd" for phase in "abc"]
    one, other = (each.run().columns for each in (plain, changed))
    assert not any(np.array_equal(one[name], other[name]) for name in names)
    assert on_target(*generated("Regulator3DOF"), changed, "controller", tmp_path, 216e6, 1.5, 60.0).columns == len(one)


ELEMENTARY = """\
from math import pi

from pmlsm.sine_cosine import sine_cosine


def sine(angle: float) -> float:
    s, c = sine_cosine(angle)
    return s


def cosine(angle: float) -> float:
    s, c = sine_cosine(angle)
    return c
"""


def counted_in_a_log(image: Path, values: np.ndarray, samples: int, log: Path) -> list[int]:
    """Instructions between the two looks at the timer of each sample, of a log of every instruction."""
    options: list[str | Path] = [*OPTIONS[:-1], "-singlestep", "-d", "exec,nochain", "-D", log, OPTIONS[-1]]
    subprocess.run([PROGRAM, *options, image], input=values.astype("<f8").tobytes() * (1 + samples), check=True,
                   stdout=subprocess.DEVNULL, timeout=120)
    symbols = subprocess.run(["nm", image], capture_output=True, text=True, check=True).stdout
    around = next(int(line.split()[0], 16) for line in symbols.splitlines() if "__wrap_" in line and "_sample" in line)
    counts: list[int] = []
    begun = None
    places = [int(place, 16) & ~1 for place in re.findall(r"\[[0-9a-f]+/([0-9a-f]+)/", log.read_text())]
    for k, place in enumerate(places):
        inside = around & ~1 <= place < (around & ~1) + 200
        if place == around & ~1:
            begun = k
        elif begun is not None and inside and not around & ~1 <= places[k - 1] < (around & ~1) + 200:
            counts.append(k - begun)
            begun = None
    return counts


def test_instructions_are_those_of_a_log(tmp_path: Path) -> None:
    """Of every instruction that the emulator carries out, within those around a sample that the log has as well."""
    described, files = generated("PID2DOF")
    image = linked("PID2DOF", files, tmp_path)
    with Emulator(image.path, 10, 60.0) as emulator:
        emulated = Emulated(described, emulator)
        emulated.exit_initialization_mode()
        for k in range(3):
            emulated.do_step(k * emulated.sample_time, emulated.sample_time)
    logged = counted_in_a_log(image.path, emulated.values, 3, tmp_path / "log")
    told = [answer.instructions for answer in emulated.answers[1:]]
    assert len(set(told)) > 1 and len(logged) == 3
    assert all(0 <= one - other <= 12 for one, other in zip(logged, told, strict=True))


def test_a_controller_of_a_python_file(fmus: Path, tmp_path: Path) -> None:
    """Its native FMU has a mathematical library, a microcontroller none: it is told what there is."""
    (tmp_path / "pd.py").write_text(PD)
    (tmp_path / "trial.toml").write_text(TRIAL.format(loop=LOOPS / "2dof.toml"))
    said = error_line(maglev("target", tmp_path / "pd.py", "--run", tmp_path / "trial.toml", "--fmus", fmus))
    assert "calls cos and sin" in said and "expected functions of pmlsm" in said
    (tmp_path / "pd.py").write_text(PD.replace("from math import cos, pi, sin", ELEMENTARY).replace(
        " cos(", " cosine(").replace(" sin(", " sine("))
    done = maglev("target", tmp_path / "pd.py", "--run", tmp_path / "trial.toml", "--fmus", fmus, "--out", tmp_path)
    assert done.exit_code == 0, done.output


@pytest.mark.thorough
def test_a_stage_of_the_users(tmp_path: Path) -> None:
    description, scenario = front_door.new_stage(tmp_path / "mine.toml")
    front_door.build(["PlantMine", "RegulatorMine"], stage=description, fmus=tmp_path / "fmus", kind="native",
                     target="host")
    scenario.write_text(re.sub(r"stop_time = .*", "stop_time = 0.1", scenario.read_text()))
    made = front_door.target("RegulatorMine", scenario, stage=description, out=tmp_path / "out", fmus=tmp_path / "fmus")
    assert made.report is not None and made.report.run.startswith("mine-setpoints")
    assert json.loads((made.folder / "report.json").read_text())["most"] == made.report.most


def test_the_usual_run_of_a_stage_of_the_users(tmp_path: Path) -> None:
    """Its own setpoints, though it has the ports of a stage of ours."""
    described = definition("Regulator3DOF")
    assert usual_run(described, tmp_path / "mine.toml") == tmp_path / "mine-setpoints.toml"
    assert usual_run(described, None) == "3dof-setpoints"


def test_the_command(fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the report and, where the emulator is not installed, without it and with what would install it."""
    loop = LOOPS / "2dof.toml"
    (tmp_path / "short.toml").write_text(f'extends = "{loop}"\nname = "short"\ntitle = "Short"\nstop_time = 0.05\n')
    common: list[str | Path] = ["target", "Regulator2DOF", "--run", tmp_path / "short.toml", "--fmus", fmus, "--out",
                                tmp_path / "out"]
    done = maglev(*common, "--clock", "400 MHz", "--cycles", "2")
    assert done.exit_code == 0, done.output
    words = " ".join(done.stdout.split())
    assert "Regulator2DOF on a Cortex-M7 (QEMU" in words and "at 400 MHz and 2 cycles an instruction" in words
    assert "signals at 101 times of short@Regulator2DOF are those of this machine" in words
    assert (tmp_path / "out" / "Regulator2DOF" / "report.txt").read_text().splitlines()[0] in done.stdout
    assert max(map(len, done.stdout.splitlines()[:6])) <= 100
    monkeypatch.setenv("PATH", "")
    done = maglev(*common[:-1], tmp_path / "other")
    assert done.exit_code == 0 and MISSING in done.stdout
    assert {path.name for path in (tmp_path / "other" / "Regulator2DOF").iterdir()} == {
        "Regulator2DOF.c", "Regulator2DOF.h", "main.c", "board.h", "CMakeLists.txt", "qemu"}


@pytest.mark.parametrize(("arguments", "facts"), [
    (["Plant2DOF"], ["Plant2DOF", "sample_time"]), (["Regulator9DOF"], ["Regulator9DOF", "'Regulator5DOF'"]),
    (["Regulator2DOF", "--clock", "fast"], ["clock", "'fast'"]),
    (["Regulator2DOF", "--clock", "3 m"], ["clock", "'3 m'", "Hz"]),
    (["Regulator2DOF", "--cycles", "0"], ["cycles", "0"]), (["Measurement2DOF"], ["Measurement2DOF", "stage"]),
    (["Regulator2DOF", "--run", "2dof-setpoint"], ["'2dof-setpoint'", "'2dof-setpoints'"])])
def test_what_is_refused(fmus: Path, tmp_path: Path, arguments: list[str], facts: list[str]) -> None:
    require_facts(error_line(maglev("target", *arguments, "--fmus", fmus, "--out", tmp_path / "out")), *facts)
    assert not (tmp_path / "out").exists()


def test_refusals_of_the_processor(fmus: Path, tmp_path: Path) -> None:
    """Of a parameter, as it is set; of a step that is not the sample time."""
    described, files = generated("Regulator2DOF")
    image = linked("Regulator2DOF", files, tmp_path)
    for changes, *facts in (({"controller.omega0": -1.0}, "omega0", "-1.0 rad/s"),
                            ({"controller.sample_time": 1e-3}, "sample_time", "0.001 s")):
        experiment = short("2dof-setpoints", "Regulator2DOF", fmus, 0.02, changes)
        with Emulator(image.path, 10, 60.0) as emulator, pytest.raises((RunFailed, FmuError)) as failure:
            in_the_loop(experiment, "controller", Emulated(described, emulator))
        require_facts(failure.value, *facts)


def test_an_emulator_that_ends_or_hangs(tmp_path: Path) -> None:
    described, files = generated("PID2DOF")
    image = linked("PID2DOF", files, tmp_path)
    values = np.zeros(len(described.variables))
    with Emulator(image.path, 10, 0.3) as emulator, raises(EmulatorError, "0.3 s"):
        emulator.exchange(values[:3])
    with Emulator(tmp_path / "none", 10, 60.0) as emulator, raises(EmulatorError, 1, "none"):
        emulator.exchange(values)
    assert emulator.process.poll() is not None


def test_other_bits_are_named(fmus: Path) -> None:
    experiment = short("2dof-setpoints", "PID2DOF", fmus, 0.01)
    here = experiment.run()
    name = "plant.v.position"
    there = Recording(here.time, {**here.columns, name: here.columns[name].copy()})
    assert equal_columns(experiment, here, there) == len(here.columns)
    there.columns[name][7] = np.nextafter(there.columns[name][7], 1.0)
    with raises(FmuError, name, "0.0035 s"):
        equal_columns(experiment, here, there)


@pytest.mark.thorough
def test_a_whole_run(fmus: Path, tmp_path: Path) -> None:
    """Of the package, of 26 s."""
    experiment = put_in(load_plan("3dof-setpoints"), "Regulator3DOF", "Regulator3DOF", {"kind": "native", "fmus": fmus})
    found: Measured = on_target(*generated("Regulator3DOF"), experiment, "controller", tmp_path, 216e6, 1.5, 60.0)
    assert found.samples == 130000 and found.columns > 40


def test_without_a_compiler_it_is_not_run(fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("maglev.files.errors.find_spec", lambda name: None if name == "ziglang" else find_spec(name))
    done = maglev("target", "PID2DOF", "--out", tmp_path, "--fmus", fmus)
    said = f"a native FMU needs ziglang; install it with the Python that runs maglev: {installing('native')}"
    assert done.exit_code == 0
    assert f"PID2DOF: it is not run: {said}" in done.output
    assert (tmp_path / "PID2DOF" / "PID2DOF.c").is_file()
