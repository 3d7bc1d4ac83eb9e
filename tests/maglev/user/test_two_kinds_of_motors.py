"""A stage with two motors that are not alike: each with a drawing, a data sheet and a field of its own."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from described_stages import written
from facts import raises
from named_blocks import named_block
from reference_pair import ReferenceMotor, lagrangian_motion, sheet_forces
from reference_stage import G
from unlike_motors import THOROUGH, first_files, given_separately, simulated, tables

import maglev
from maglev.files.errors import StageError
from maglev.identification.regressors import accelerations as identified
from maglev.identification.regressors import estimated_stage
from maglev.linear.linearise import linearise
from maglev.user.adoption import know_stage
from maglev.user.reading import read_own
from maglev.user.scenario_loop import setpoints
from pmlsm.stage_description import StageDescription

pytestmark = pytest.mark.usefixtures("slow")

LIKE = "side-by-side"
DRAWINGS = {"left": {"pole_pitch": 0.05715, "slot_pitch": 0.01905, "slot_width": 0.0127, "magnet_height": 0.005},
            "right": {"pole_pitch": 0.048, "slot_pitch": 0.016, "slot_width": 0.008, "magnet_height": 0.006}}
SHEETS: dict[str, dict[str, float]] = {
    "left": {"force_constant": 10.65, "at": 0.02, "attraction": 38.95, "attraction_gap": 0.02, "peak": 9.0,
             "direct_constant": 14.65, "iron_attraction": 0.5481},
    "right": {"force_constant": 7.0, "at": 0.019, "attraction": 52.0, "attraction_gap": 0.018, "peak": 12.0}}
FIELDS = {"left": (0.42, 0.0128), "right": (0.4, 0.015)}   # T at the magnets, and m by which it decays
PLACES = {"left": -0.11, "right": 0.17}                    # m; the centre of mass is not between them


def own(motor: str) -> str:
    """What a description says of a motor of its own."""
    return tables(DRAWINGS[motor], SHEETS[motor], FIELDS[motor])


def described(path: Path, left: str = "left", right: str = "right", changes: dict[str, str] | None = None) -> Path:
    """A pair of motors that both have all for themselves."""
    written(path, LIKE, {"z = -0.15 ": f"z = {PLACES['left']}\n{own(left)}# ",
                         "z = 0.15 ": f"z = {PLACES['right']}\n{own(right)}# ",
                         "height = 0.0 ": "height = -0.04 ", "mass = 0.196": "mass = 0.23",
                         "\ncurrent_limit =": "\n# current_limit =", **(changes or {})})
    text = path.read_text(encoding="utf-8")
    start, end = text.index("\n[geometry]"), text.index("\n[design]")
    path.write_text(text[:start] + text[end:], encoding="utf-8")   # nothing is in common
    return path


def free(plant: Any, stage: StageDescription, start: list[float]) -> Any:
    """A plant without what is not of the motors, at a place."""
    plant.encoder.resolution = 0.0
    for axis, position in zip(stage.axis_names, start, strict=True):
        of = getattr(plant, axis)
        of.bias = of.friction.coulomb = of.friction.viscous = of.ripple.amplitude = 0.0
        of.position_start = position
    for motor in stage.motor_names:
        getattr(plant, motor).amplifier.lag = 0.0
    assert plant.start() == 0
    return plant


def moved(plant: Any, stage: StageDescription, currents: np.ndarray, steps: int = 30) -> np.ndarray:
    """Positions at every millisecond under constant phase currents."""
    for motor, phases in zip(stage.motor_names, currents.tolist(), strict=True):
        supply = getattr(plant, motor)
        supply.i_a_cmd, supply.i_b_cmd, supply.i_c_cmd = phases
    rows = []
    for k in range(steps):
        rows.append([getattr(plant, axis).position for axis in stage.axis_names])
        assert plant.step(1e-3 * k, 1e-3) == 0
    return np.array(rows)


CURRENTS = np.array([[1.0, -0.3, -0.7], [-0.4, 0.9, -0.5]])
START = [0.0195, 1.5e-3, 4e-3]


def references(modulation: float) -> list[ReferenceMotor]:
    """Both motors by their drawings and data sheets."""
    return [ReferenceMotor(PLACES[motor], DRAWINGS[motor]["pole_pitch"], sheet_forces(
        DRAWINGS[motor], FIELDS[motor], SHEETS[motor], modulation)) for motor in PLACES]


def accelerations(stage: StageDescription, q: np.ndarray, dq: np.ndarray, modulation: float = 0.0) -> np.ndarray:
    """Of v, h, roll at these and i_d, i_q of each motor, (motors, 2), by the references; no bias, no friction."""
    found = np.zeros(3)
    for motor, (i_d, i_q) in zip(references(modulation), dq.tolist(), strict=True):
        normal, thrust = motor.forces(float(q[0] - motor.z * q[2]), float(q[1]), i_d, i_q)
        found += [normal, thrust, -motor.z * normal]
    return np.array([G, 0.0, 0.0]) + found / [axis.mass for axis in stage.axes]


def test_linear_model_and_rows_are_those_of_its_data_sheets(tmp_path: Path) -> None:
    """Plant linearised, rows of the identification, and columns of the estimator, against differences of the forces."""
    stage = know_stage(described(tmp_path / "unlike.toml"))
    at = np.array([0.019, 2e-3, 1e-3])
    model = linearise("PlantUnlike", dict(zip(stage.axis_names, at.tolist(), strict=True)), amplifier=False,
                      parameters={f"{axis}.bias": 0.0 for axis in stage.axis_names})
    dq = model.equilibrium.dq.reshape(2, 2)
    assert np.abs(accelerations(stage, at, dq, stage.modulation)).max() < 1e-7
    slopes = [(accelerations(stage, at + step, dq, stage.modulation) - accelerations(stage, at - step, dq,
                                                                                     stage.modulation))
              / 2e-7 for step in 1e-7 * np.eye(3)]
    assert model.A[3:6, :3] == pytest.approx(np.column_stack(slopes), rel=1e-5, abs=1e-3)

    dq = np.array([[0.7, -0.4], [-0.3, 0.9]])
    constants = {each.name: each.plant for each in stage.constants}
    rows = identified(estimated_stage(stage), at[None], dq[None, :, 0], dq[None, :, 1], constants)
    assert rows[0] == pytest.approx(accelerations(stage, at, dq), abs=1e-7)

    estimator: Any = named_block("EstimatorUnlike")
    assert estimator.start() == 0
    for motor, (i_d, i_q) in zip(stage.motor_names, dq.tolist(), strict=True):
        part = getattr(estimator, motor)
        part.i_d, part.i_q = i_d, i_q
        getattr(estimator, f"{motor}_place").gap_measured = float(at[0] - PLACES[motor] * at[2])
    estimator.h.measured = float(at[1])
    estimator.sample()
    columns = [estimator.rows.attraction, estimator.rows.coils, estimator.rows.iron]
    assert G + np.dot(columns, [constants[name] for name in stage.constants_of("v")]) == pytest.approx(rows[0, 0])


def test_it_moves_by_its_data_sheets(tmp_path: Path) -> None:
    """The plant's block, without friction, bias and lag, against an integration that knows drawings and data sheets."""
    stage = know_stage(described(tmp_path / "unlike.toml"))
    motors = references(stage.modulation)
    found = moved(free(named_block("PlantUnlike"), stage, START), stage, CURRENTS)
    expected = lagrangian_motion([axis.mass for axis in stage.axes], stage.height, (0.0, 0.0), motors, np.array(START),
                                 CURRENTS, 1e-3 * np.arange(30))
    assert (np.ptp(expected, axis=0) > 1.5e-4).all()   # it goes somewhere along all of them
    assert np.abs(found - expected).max(axis=0) == pytest.approx(np.zeros(3), abs=1e-11)


@pytest.mark.parametrize("law", ["", *THOROUGH])
def test_it_runs(tmp_path: Path, law: str) -> None:
    """By its designed gains: motors of different strengths make one thrust and no torque."""
    stage = know_stage(described(tmp_path / "unlike.toml"))
    rows, loop = simulated(stage, law, 72)
    target = [1e-3 * values[2] for values in setpoints(stage).values()]
    assert rows[-1] == pytest.approx(target, abs=3e-5)
    assert np.abs(rows[:8] - rows[0]).max() < 4e-4   # it is held as it begins, which asks for a current of each motor
    left, right = loop.plant.left_mount, loop.plant.right_mount
    assert left.thrust == pytest.approx(right.thrust, rel=0.02, abs=0.02)   # no yaw
    assert abs(loop.plant.left.i_d - loop.plant.right.i_d) > 0.3


@pytest.mark.parametrize("law", ["", *THOROUGH])
def test_equal_motors_given_separately_are_those_given_once(tmp_path: Path, law: str) -> None:
    """Bit for bit."""
    common = written(tmp_path / "once.toml", LIKE, {})
    twice = know_stage(given_separately(common, tmp_path / "twice.toml", ("left", "right")))
    once = know_stage(common)
    assert [motor.kind is None for motor in twice.motors] == [False, False]
    assert [axis.design for axis in twice.axes] == [axis.design for axis in once.axes]
    assert simulated(twice, law, 20)[0].tolist() == simulated(once, law, 20)[0].tolist()


def test_swapped_motors_tilt_to_the_other_side(tmp_path: Path) -> None:
    level = {"z = -0.11": "z = -0.15", "z = 0.17": "z = 0.15"}
    stage = know_stage(described(tmp_path / "unlike.toml", changes=level))
    other = know_stage(described(tmp_path / "swapped.toml", "right", "left", level))
    found = moved(free(named_block("PlantUnlike"), stage, START), stage, CURRENTS)
    mirrored = moved(free(named_block("PlantSwapped"), other, [*START[:2], -START[2]]), other,
                     CURRENTS[::-1])
    assert mirrored * [1.0, 1.0, -1.0] == pytest.approx(found, abs=1e-13)
    assert simulated(other, "", 10, -1.0)[0] * [1.0, 1.0, -1.0] == pytest.approx(simulated(stage, "", 10)[0], abs=1e-9)


def test_the_first_files_know_both_motors(tmp_path: Path) -> None:
    """A controller to begin with gets the accelerations that it demands, and a plant to begin with has them."""
    path, at = described(tmp_path / "unlike.toml"), [0.0195, 4e-3, 0.0]
    stage = know_stage(path)
    demands, currents, of_plant = first_files(path, stage, at, [1e-4, -5e-4, 3e-4])
    assert accelerations(stage, np.array(at), currents) == pytest.approx(demands, rel=1e-5)
    assert of_plant == pytest.approx(demands, rel=1e-4)


@pytest.mark.thorough
def test_native_fmus_have_the_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    described(tmp_path / "unlike.toml")
    (tmp_path / "short.toml").write_text('extends = "unlike-setpoints.toml"\nname = "short"\nstop_time = "1.1 s"\n')
    native, python = (maglev.run("short.toml", kind=kind) for kind in ("native", "python"))
    for axis in ("v", "h", "roll"):
        assert (native[f"plant.{axis}.position"] == python[f"plant.{axis}.position"]).all()
        assert np.ptp(native[f"plant.{axis}.position"]) > 1e-5


@pytest.mark.parametrize(("old", "new", "facts"), [
    ("force_constant = 7.0", "force = 7.0", ["motors.right.catalogue.force", "'force_constant'"]),
    ("at = 0.019", "at = 0.001", ["motors.right.catalogue.at", "1 mm", "7…40 mm"]),
    ("slot_width = 0.008", "slots = 0.008", ["motors.right.geometry.slots", "'slot_width'"]),
    ("pole_pitch = 0.048", "pole_pitch = 3.0", ["motors.right.geometry.pole_pitch"]),
    ("B0 = 0.4,", "B0 = 0.0,", ["motors.right.field.B0"]),
    ("decay = 0.015 }", "decay = 0.015 }\nkind = 3", ["motors.right.kind"]),
    ("[design]", "[design]\ntable = { lower = 0.008, spacing = 0.001 }", ["design.table", "motors.left"])])
def test_refuses_an_impossible_motor(tmp_path: Path, old: str, new: str, facts: list[str]) -> None:
    path = described(tmp_path / "unlike.toml")
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with raises(StageError, path, *facts):
        read_own(path)


def test_the_motor_of_the_page_is_read(tmp_path: Path) -> None:
    page = (Path(__file__).parents[3] / "docs" / "own_stage.md").read_text(encoding="utf-8")
    block = re.search(r"\n    (\[motors\.right\.catalogue\]\n(?:    .*\n)+)", page)
    assert block is not None
    path = written(tmp_path / "unlike.toml", LIKE, {})
    with path.open("a", encoding="utf-8") as file:
        file.write("\n" + block[1].replace("\n    ", "\n"))
    left, right = read_own(path).motors
    assert left.kind is None
    assert right.kind is not None and right.kind.thrust == pytest.approx(7.0 / 10.65, rel=1e-3)
    assert right.kind.limit == pytest.approx(6.0 / 9.0)
