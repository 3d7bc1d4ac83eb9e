"""Plants that are Python files: the first one of a stage, integrated apart, and what is wrong with one."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from command_line import error_line, maglev
from described_stages import written
from facts import raises, require_facts
from reference_5dof import DISPLACEMENTS, GAPS
from reference_stage import G, park_matrix, shape_functions
from scipy.integrate import solve_ivp
from written_controllers import line_of

import maglev as tool
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.fmi.documentation import breakable
from maglev.scenario.loading import load_plan
from maglev.user.new_controller import new_plant
from maglev.user.source import PythonFile
from pmlsm.stage_description import StageDescription

SHORT = 'extends = "{path}"\nname = "short"\nstop_time = "{time}"\n'


@pytest.mark.few(1)
@pytest.mark.parametrize("stage", PACKAGED_STAGES)
def test_the_first_plant_runs(fastest_fmus: Path, tmp_path: Path, stage: str) -> None:
    """From a new file, without a change and without a complaint, through the first step."""
    path = tmp_path / "mover.py"
    made = maglev("new", "plant", tmp_path / "mover", "--stage", stage)
    assert made.stdout.strip() == f"{path}: run it with `maglev run {stage}-setpoints --plant {path}`"
    assert len(path.read_text().splitlines()) < (170 if PACKAGED_STAGES[stage].rotations else 126)
    run = tmp_path / "short.toml"
    run.write_text(SHORT.format(path=load_plan(f"{stage}-setpoints").source, time="5.9 s"))
    result = maglev("run", run, "--fmus", fastest_fmus, "--out", tmp_path, "--plant", path)
    assert result.exit_code == 0, result.output
    note, = result.stderr.strip().splitlines()
    assert f"{PACKAGED_STAGES[stage].vertical.name}.position_start" in note
    metrics = json.loads((tmp_path / "short.json").read_text())["metrics"]
    assert not metrics["failed"]
    assert all(motor["peak_current"] > 1.0 for motor in metrics["motors"])
    # Nothing rubs and no encoder rounds: what is left is what has not yet died out.
    assert max(metrics["end_errors"].values()) < 1e-6
    assert "already exists" in error_line(maglev("new", "plant", path, "--stage", stage))


def rows(stage: StageDescription) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the gaps and of the displacements of the motors over the positions."""
    if stage.rotations:
        return GAPS, DISPLACEMENTS
    return np.tile(np.eye(len(stage.axes))[0], (len(stage.motors), 1)), np.eye(len(stage.axes))[[*stage.driven]]


def rates(stage: StageDescription, state: np.ndarray, phases: np.ndarray, pushed: np.ndarray) -> np.ndarray:
    """Rates of positions and velocities under held phase currents, shape (motors, 3), and forces from outside."""
    q, v = np.split(state, 2)
    masses = np.array([axis.mass for axis in stage.axes])
    gaps, displacements = rows(stage)
    forces = pushed + masses * G * np.eye(len(q))[0]
    for gap_row, row, currents, axis in zip(gaps, displacements, phases, stage.driven, strict=True):
        f1, f2, f3, f4 = shape_functions(gap_row @ q)
        i_d, i_q = park_matrix(row @ q) @ currents
        normal = masses[0] * (stage.plant.coils * f3 * i_d - stage.plant.iron * f4 * (i_d**2 + i_q**2)
                              - stage.plant.attraction * f2)
        thrust = -masses[axis] * stage.plant.thrust[stage.axes[axis].name] * f1 * i_q
        forces = forces + stage.sharing * (normal * gap_row + thrust * row)
    return np.concatenate([v, forces / masses])


@pytest.mark.parametrize("stage", PACKAGED_STAGES)
def test_it_moves_as_the_equations_say(tmp_path: Path, stage: str) -> None:
    """By scipy with tight tolerances, from the page; half the step has a quarter of the error."""
    description = PACKAGED_STAGES[stage]
    written_definition = PythonFile(new_plant(tmp_path / "mover.py", stage)).load().definition
    drawn = np.random.default_rng(7)
    phases = drawn.uniform(-3.0, 3.0, (len(description.motors), 3))
    pushed = np.array([0.3 if axis.rotation else 2.0 for axis in description.axes])
    time, errors = 0.05, []
    start = np.concatenate([[axis.start for axis in description.axes], np.zeros(len(description.axes))])
    exact = solve_ivp(lambda _, state: rates(description, state, phases, pushed), (0.0, time), start, method="DOP853",
                      rtol=1e-12, atol=1e-14).y[:len(description.axes), -1]
    assert np.abs(exact - start[:len(description.axes)]).min() > 1e-4, "something has to move for this to mean anything"
    for steps in (100, 200):
        law = written_definition.new_block().law
        for motor, currents in zip(description.motor_names, phases, strict=True):
            of = getattr(law, motor)
            of.i_a_cmd, of.i_b_cmd, of.i_c_cmd = (float(current) for current in currents)
        for axis, push in zip(description.axes, pushed, strict=True):
            setattr(getattr(law, axis.name), "torque" if axis.rotation else "force", float(push))
        law.start()
        for k in range(steps):
            law.step(k * time / steps, time / steps)
        errors.append(np.abs([getattr(law, axis.name).position for axis in description.axes] - exact))
    assert np.max(errors[0]) < 2e-6
    np.testing.assert_allclose(errors[0], 4.0 * errors[1], rtol=0.02)


@pytest.mark.filterwarnings("ignore:plant .* starts with")
@pytest.mark.usefixtures("slow")
def test_of_a_stage_of_the_user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Under a controller of its own, with no FMU but that of nothing: both are files."""
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "swan.toml", "2dof", {"pole_pitch = 0.05715": "pole_pitch = 0.05"})
    plant, controller = (make("swan.toml") for make in (
        lambda stage: tool.new_plant("mover.py", stage), lambda stage: tool.new_controller("lqi.py", stage)))
    assert "--plant mover.py" in plant.read_text() and "swan-setpoints.toml" in plant.read_text()
    run = tool.run("swan-setpoints.toml", plant=plant, controller=controller)
    assert not run["plant.at_stop"].any()
    assert max(run.metrics.end_errors.values()) < 1e-6


def test_its_fmu_has_a_page(slow: None, tmp_path: Path) -> None:
    """With its ports, and a sketch that knows no samples."""
    fmu, = tool.build(new_plant(tmp_path / "mover.py", "2dof"), fmus=tmp_path)
    with zipfile.ZipFile(fmu) as archive:
        page = archive.read("documentation/index.html").decode()
    assert all(f">{breakable(port)}</th>" in page for port in ("v.encoder", "motor.i_a_cmd", "h.force", "v.mass"))
    assert "every communication step" in page and "sample_time" not in page


WRONG: dict[str, tuple[tuple[str, str], str, *tuple[str, ...]]] = {
    "missing port": (('"h.encoder": "m",', ""), "outputs = {", "h.encoder", "port map"),
    "misspelt port": (('"h.encoder": "m"', '"h.encodr": "m"'), '"h.encodr"', "Mover", "outputs", "'h.encodr'"),
    "unit": (('"h.encoder": "m"', '"h.encoder": "m/s"'), '"h.encoder"', "m/s", "m", "h.encoder"),
    "unknown unit": (('"h.encoder": "m"', '"h.encoder": "mm"'), '"h.encoder"', "Mover", "'h.encoder'", "'mm'"),
    "type": (("self.encoder = start ", "self.encoder = False "), '"v.encoder": "m"', "Boolean", "Real", "v.encoder"),
    "start": (("self.mass = mass ", "self.mass = 'heavy' "), '"v.mass"', "Mover", "v.mass", "'heavy'")}
FAILING = {"nan": ("float('nan')", "v.encoder", "nan m", "Mover"), "text": ("'far'", "v.encoder", "'far' m", "Mover"),
           "exception": ("1.0 / 0.0", "line {line}", "ZeroDivisionError")}


@pytest.mark.parametrize("case", WRONG)
def test_an_error_has_its_line(fastest_fmus: Path, tmp_path: Path, case: str) -> None:
    change, part, *facts = WRONG[case]
    path = new_plant(tmp_path / "mover.py", "2dof")
    text = path.read_text()
    assert text.count(change[0]) == 1
    path.write_text(text.replace(*change))
    line = error_line(maglev("run", "2dof-setpoints", "--plant", path, "--fmus", fastest_fmus,
                             "--out", tmp_path / "out"))
    require_facts(line, "mover.py", f"line {line_of(path, part)}", *facts)
    assert not any((tmp_path / "out").glob("*"))


@pytest.mark.parametrize("case", FAILING)
@pytest.mark.filterwarnings("ignore:plant .* starts with")
def test_an_error_during_a_run_has_its_time(fastest_fmus: Path, tmp_path: Path, case: str) -> None:
    """Of the mass that begins to fall with the first step of the references."""
    value, *facts = FAILING[case]
    path = new_plant(tmp_path / "mover.py", "2dof")
    path.write_text(path.read_text().replace(
        "self.encoder = self.position", f"self.encoder = self.position if self.position < 0.021 else {value}"))
    facts = [fact.format(line=line_of(path, "self.position < 0.021")) for fact in facts]
    with raises(tool.RunFailed, "plant", "mover.py", *facts) as failure:
        tool.run("2dof-setpoints", plant=path, fmus=fastest_fmus)
    recorded = failure.value.recording
    assert recorded.time[-1] > 1.0 and recorded.columns["plant.v.position"][:-1].max() < 0.021
    require_facts(failure.value, f"{recorded.time[-1]} s")
