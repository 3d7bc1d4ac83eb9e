"""Stages without tilt whose motors are not alike: one along each axis, or two along one."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from described_stages import written
from facts import raises
from named_blocks import named_block
from reference_pair import ReferenceMotor, sheet_forces
from reference_stage import G
from scipy.integrate import solve_ivp
from unlike_motors import THOROUGH, first_files, given_separately, simulated, tables

import maglev
from maglev.files.errors import StageError
from maglev.identification.regressors import accelerations as identified
from maglev.identification.regressors import estimated_stage
from maglev.linear.linearise import linearise
from maglev.linear.loop import linearise_loop
from maglev.user.adoption import know_stage
from maglev.user.reading import read_own
from maglev.user.scenario_loop import setpoints
from pmlsm.stage_description import StageDescription

pytestmark = pytest.mark.usefixtures("slow")

DRAWINGS = {"alpha": {"pole_pitch": 0.05715, "slot_pitch": 0.01905, "slot_width": 0.0127, "magnet_height": 0.005},
            "beta": {"pole_pitch": 0.048, "slot_pitch": 0.016, "slot_width": 0.008, "magnet_height": 0.006}}
SHEETS: dict[str, dict[str, float]] = {
    "alpha": {"force_constant": 2.313, "at": 0.025, "attraction": 12.06, "attraction_gap": 0.025, "peak": 5.0,
              "direct_constant": 4.296, "iron_attraction": 0.03037},
    "beta": {"force_constant": 3.0, "at": 0.02, "attraction": 20.0, "attraction_gap": 0.02, "peak": 8.0}}
FIELDS = {"alpha": (0.42, 0.0128), "beta": (0.4, 0.015)}   # T at the magnets, and m by which it decays
MODULATION = 0.0135
START = np.array([0.0245, 2e-3, -1.5e-3])
CURRENTS = np.array([[1.0, -0.3, -0.7], [-0.4, 0.9, -0.5]])


def own(motor: str) -> str:
    """What a description says of a motor of its own."""
    return tables(DRAWINGS[motor], SHEETS[motor], FIELDS[motor])


def described(path: Path, changes: dict[str, str] | None = None) -> Path:
    """The thesis's 3-DOF stage with two kinds of motors, and nothing in common."""
    written(path, "3dof", {'drives = "x"\n': f'drives = "x"\n{own("alpha")}',
                           'drives = "z"\n': f'drives = "z"\n{own("beta")}',
                           "\ncurrent_limit =": "\n# current_limit =", **(changes or {})})
    text = path.read_text(encoding="utf-8")
    start, end = text.index("\n# From the motor's drawing"), text.index("\n[design]")
    path.write_text(text[:start] + text[end:], encoding="utf-8")
    return path


def references() -> dict[str, ReferenceMotor]:
    return {motor: ReferenceMotor(0.0, DRAWINGS[motor]["pole_pitch"], sheet_forces(
        DRAWINGS[motor], FIELDS[motor], SHEETS[motor], MODULATION)) for motor in DRAWINGS}


def accelerations(stage: StageDescription, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
    """Of y, x, z at these and i_d, i_q of each motor, (motors, 2), by the references; no bias, no friction.

    Two motors share each current; the slots along x count.
    """
    found = np.zeros(3)
    for k, (motor, (i_d, i_q)) in enumerate(zip(references().values(), dq.tolist(), strict=True)):
        normal, thrust = motor.forces(float(q[0]), float(q[1]), i_d, i_q)
        found[0] += 2.0 * normal
        found[1 + k] = 2.0 * thrust
    return np.array([G, 0.0, 0.0]) + found / [axis.mass for axis in stage.axes]


def test_it_moves_by_its_data_sheets(tmp_path: Path) -> None:
    """The plant's block, without friction, bias and lag, against an integration that knows drawings and data sheets."""
    stage = know_stage(described(tmp_path / "unlike.toml"))
    plant: Any = named_block("PlantUnlike")
    plant.encoder.resolution = 0.0
    for axis, position in zip(stage.axis_names, START.tolist(), strict=True):
        of = getattr(plant, axis)
        of.bias = of.friction.coulomb = of.friction.viscous = of.ripple.amplitude = 0.0
        of.position_start = position
    for motor, phases in zip(stage.motor_names, CURRENTS.tolist(), strict=True):
        supply = getattr(plant, motor)
        supply.amplifier.lag = 0.0
        supply.i_a_cmd, supply.i_b_cmd, supply.i_c_cmd = phases
    assert plant.start() == 0
    rows = []
    for k in range(25):
        rows.append([getattr(plant, axis).position for axis in stage.axis_names])
        assert plant.step(1e-3 * k, 1e-3) == 0

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        dq = np.array([motor.park(float(state[1 + k])) @ phases for k, (motor, phases) in enumerate(
            zip(references().values(), CURRENTS, strict=True))])
        return np.concatenate([state[3:], accelerations(stage, state[:3], dq)])

    expected = solve_ivp(rates, (0.0, 0.024), np.concatenate([START, np.zeros(3)]), method="DOP853",
                         t_eval=1e-3 * np.arange(25), rtol=1e-11, atol=1e-14).y[:3].T
    assert (np.ptp(expected, axis=0) > 5e-5).all()   # it goes somewhere along all of them
    assert np.abs(np.array(rows) - expected).max(axis=0) == pytest.approx(np.zeros(3), abs=1e-11)


def test_linear_model_and_rows_are_those_of_its_data_sheets(tmp_path: Path) -> None:
    """Plant linearised, rows of the identification, and columns of the estimator, against the forces."""
    stage = know_stage(described(tmp_path / "unlike.toml"))
    at = np.array([0.0245, 2e-3, 0.0])
    model = linearise("PlantUnlike", dict(zip(stage.axis_names, at.tolist(), strict=True)), amplifier=False,
                      parameters={f"{axis}.{part}": 0.0 for axis in stage.axis_names
                                  for part in ("bias", "ripple.amplitude")})
    dq = model.equilibrium.dq.reshape(2, 2)
    assert np.abs(accelerations(stage, at, dq)).max() < 1e-7
    gap = np.array([1e-7, 0.0, 0.0])
    slope = (accelerations(stage, at + gap, dq) - accelerations(stage, at - gap, dq))[0] / 2e-7
    assert model.A[3, 0] == pytest.approx(slope, rel=1e-5)

    at[1] = 0.0   # a tooth, where the slots count for nothing
    dq = np.array([[0.7, -0.4], [-0.3, 0.9]])
    constants = {each.name: each.plant for each in stage.constants}
    rows = identified(estimated_stage(stage), at[None], dq[None, :, 0], dq[None, :, 1], constants)
    assert rows[0] == pytest.approx(accelerations(stage, at, dq), abs=1e-7)

    estimator: Any = named_block("EstimatorUnlike")
    assert estimator.start() == 0
    for motor, (i_d, i_q) in zip(stage.motor_names, dq.tolist(), strict=True):
        part = getattr(estimator, motor)
        part.i_d, part.i_q = i_d, i_q
    for axis, position in zip(stage.axis_names, at.tolist(), strict=True):
        getattr(estimator, axis).measured = position
    estimator.sample()
    columns = [estimator.rows.attraction, estimator.rows.coils, estimator.rows.iron]
    assert G + np.dot(columns, [constants[name] for name in stage.constants_of("y")]) == pytest.approx(rows[0, 0])


@pytest.mark.parametrize("law", ["", *THOROUGH])
def test_it_runs(tmp_path: Path, law: str) -> None:
    """By its designed gains, held from the beginning."""
    stage = know_stage(described(tmp_path / "unlike.toml"))
    rows, loop = simulated(stage, law, 100)
    target = [1e-3 * values[2] for values in setpoints(stage).values()]
    assert np.abs(rows[:20, 0] - stage.vertical.start).max() < 1e-4
    assert rows[-1, 0] == pytest.approx(target[0], abs=5e-5)
    assert rows[-1, 1:] == pytest.approx(target[1:], abs=6e-4)   # on its way: friction holds it
    assert abs(loop.plant.alpha.i_d - loop.plant.beta.i_d) > 0.3
    assert named_block("AdaptiveRegulatorUnlike").start() == 0


@pytest.mark.thorough
@pytest.mark.parametrize("law", ["", *THOROUGH])
def test_a_linear_loop_is_about_the_currents_that_a_law_comes_to(tmp_path: Path, law: str) -> None:
    """Each law has its own: without friction and with exact encoders a run comes to them."""
    stage = know_stage(described(tmp_path / "unlike.toml", {"resolution = 1e-05": "resolution = 0.0"}))
    loop: Any = named_block(f"ClosedLoop{law}Unlike")
    for axis in stage.axis_names:
        of = getattr(loop.plant, axis)
        of.friction.coulomb = of.ripple.amplitude = 0.0
        getattr(loop.controller, axis).reference = getattr(loop.plant, axis).position_start
    assert loop.start() == 0
    for _ in range(600):
        assert loop.step(0.0, 1e-2) == 0
    name = {"Linear": "LinearRegulator", "": "Regulator"}.get(law, law)
    model = linearise_loop("PlantUnlike", f"{name}Unlike", {"y": stage.vertical.start}, plant_parameters={
        f"{axis}.ripple.amplitude": 0.0 for axis in stage.axis_names})
    assert model.stable
    found = [getattr(getattr(loop.plant, motor), of) for of in ("i_d", "i_q") for motor in stage.motor_names]
    assert found == pytest.approx([*model.plant.equilibrium.i_d, *model.plant.equilibrium.i_q], abs=1e-4)


@pytest.mark.parametrize("law", ["Linear", pytest.param("PID", marks=pytest.mark.thorough)])
def test_equal_motors_given_separately_are_those_given_once(tmp_path: Path, law: str) -> None:
    """To rounding, with encoders that show it, warm magnets, and a bus whose voltage counts."""
    common = written(tmp_path / "once.toml", "3dof", {"resolution = 1e-05": "resolution = 0.0"})
    twice = know_stage(given_separately(common, tmp_path / "twice.toml", ("alpha", "beta")))
    once = know_stage(common)
    assert [motor.kind is None for motor in twice.motors] == [False, False]
    assert [axis.design for axis in twice.axes] == [axis.design for axis in once.axes]
    effects = {"magnet_rise": 15.0, "bus_voltage": 20.0}
    expected = simulated(once, law, 20, **effects)[0]
    assert simulated(twice, law, 20, **effects)[0] == pytest.approx(expected, abs=1e-11)
    assert np.abs(simulated(once, law, 20)[0] - expected).max() > 1e-6   # they do count


def test_one_motor_given_apart_is_that_of_its_stage(tmp_path: Path) -> None:
    """By the nonlinear law, too, to rounding."""
    common = written(tmp_path / "common.toml", "2dof", {"resolution = 1e-05": "resolution = 0.0"})
    text = common.read_text(encoding="utf-8").replace("common", "apart")
    for key in ("geometry", "catalogue", "field"):
        text = text.replace(f"\n[{key}]", f"\n[motors.motor.{key}]")
    (tmp_path / "apart.toml").write_text(text, encoding="utf-8")
    stages = [know_stage(tmp_path / f"{name}.toml") for name in ("common", "apart")]
    assert [stage.motors[0].kind is None for stage in stages] == [True, False]
    common_rows, apart_rows = (simulated(stage, "", 20)[0] for stage in stages)
    assert apart_rows == pytest.approx(common_rows, abs=1e-11)


def test_the_first_files_know_both_motors(tmp_path: Path) -> None:
    """A controller to begin with gets the accelerations that it demands, and a plant to begin with has them."""
    path, at = described(tmp_path / "unlike.toml"), [0.0245, 0.0, 3e-3]   # x between the slots: no modulation
    stage = know_stage(path)
    demands, currents, of_plant = first_files(path, stage, at, [1e-4, -5e-4, 3e-4])
    assert accelerations(stage, np.array(at), currents) == pytest.approx(demands, rel=1e-5)
    assert of_plant == pytest.approx(demands, rel=1e-4)


@pytest.mark.thorough
def test_native_fmus_have_the_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    described(tmp_path / "unlike.toml")
    (tmp_path / "short.toml").write_text('extends = "unlike-setpoints.toml"\nname = "short"\nstop_time = "1.1 s"\n')
    for controller in ("RegulatorUnlike", "AdaptiveRegulatorUnlike"):
        native, python = (maglev.run("short.toml", kind=kind, controller=controller) for kind in ("native", "python"))
        for axis in ("y", "x", "z"):
            assert (native[f"plant.{axis}.position"] == python[f"plant.{axis}.position"]).all()
            assert np.ptp(native[f"plant.{axis}.position"]) > 1e-5


def test_tables_over_the_gap_are_of_motors_that_are_alike(tmp_path: Path) -> None:
    for key, value in (("table", "{ lower = 0.018, spacing = 0.001 }"),
                       ("schedule", "{ bounds = [0.029, 0.025, 0.021], setpoints = [0.031, 0.027, 0.023, 0.019] }")):
        path = described(tmp_path / f"{key}.toml", {"[design]\n": f"[design]\n{key} = {value}\n"})
        with raises(StageError, path, f"design.{key}", "motors.alpha"):
            read_own(path)


def test_a_packaged_motor_is_its_numbers(tmp_path: Path) -> None:
    """Of a whole stage those that `new stage --motor` writes out, and of one motor the same; keys go over them."""
    maglev.new_stage(tmp_path / "full.toml", "side-by-side", ["small"])
    text = (tmp_path / "full.toml").read_text(encoding="utf-8").replace('"full"', '"named"')
    start, end = text.index("\n# From the motor's drawing"), text.index("\n[design]")
    (tmp_path / "named.toml").write_text(f'motor = "small"\n{text[:start]}{text[end:]}', encoding="utf-8")
    full, named = (read_own(tmp_path / f"{name}.toml") for name in ("full", "named"))
    assert (named.plant, named.motors, named.design) == (full.plant, full.motors, full.design)
    assert {**named.geometry, "recoil_permeability": 1.05} == full.geometry

    one = text.replace('"named"', '"one"').replace("[motors.right]\n", """[motors.right]
motor = "medium"
catalogue = { peak = "9 A" }
""")
    (tmp_path / "one.toml").write_text(one, encoding="utf-8")
    left, right = read_own(tmp_path / "one.toml").motors
    assert left.kind is None and right.kind is not None
    assert right.amplifier.peak == pytest.approx(9.0 * 2.0 ** 0.5)
    (tmp_path / "one.toml").write_text(one.replace('"medium"', '"medum"'), encoding="utf-8")
    with raises(StageError, "motors.right.motor", "'medum'", "'medium'"):
        read_own(tmp_path / "one.toml")
