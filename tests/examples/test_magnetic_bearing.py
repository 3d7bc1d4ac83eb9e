"""A plant and its controller with another physics than the stages', against a separate integration of the equations."""

from pathlib import Path

import fmpy
import numpy as np
import pytest
from example_builds import EXAMPLES, require_compiler, script
from facts import raises, require_facts, warns
from fmpy.fmi2 import FMU2Slave
from fmpy_validation import validate_fmu
from native_builds import require_native_tools
from scipy.integrate import solve_ivp

import maglev
from maglev.user.source import PythonFile

FOLDER = EXAMPLES / "magnetic_bearing"
CORE, MASS, AIR_GAP, ECCENTRICITY, TURNING, G = 1.13e-5, 4.0, 0.4e-3, 1e-6, 628.0, 9.81


def rates(time: float, state: np.ndarray, commands: np.ndarray, load: float) -> np.ndarray:
    """Rates of x, y, their velocities, and the currents of the magnets in +x, -x, +y, -y, which are the states here."""
    place, velocity, currents = state[:2], state[2:4], state[4:].reshape(2, 2)
    signs = np.array([1.0, -1.0])
    gaps = AIR_GAP - np.outer(place, signs)                # m, by axis and magnet
    inductances = CORE / (2.0 * gaps)
    induced = -CORE * currents / (2.0 * gaps**2) * np.outer(-velocity, signs)
    voltages = np.clip(80.0 * (commands - currents), -150.0, 150.0)
    forces = CORE * currents**2 / (4.0 * gaps**2) @ signs
    unbalance = MASS * ECCENTRICITY * TURNING**2 * np.array([np.cos(TURNING * time), np.sin(TURNING * time)])
    acceleration = (forces + unbalance + [0.0, load]) / MASS - [0.0, G]
    return np.concatenate([velocity, acceleration, ((voltages - currents - induced) / inductances).ravel()])


@pytest.mark.thorough
def test_it_moves_as_the_equations_say(slow: None) -> None:
    """With the example's own controller, through lift and step, and currents as states instead of the flux."""
    run = maglev.run(FOLDER / "levitate.toml")
    law = PythonFile(FOLDER / "controller.py").load().definition.new_block().law
    state = np.array([0.0, -150e-6, *np.zeros(6)])
    found = [state[:2]]
    for k in range(2200):
        time = 1e-4 * k
        law.x.measured, law.y.measured = map(float, state[:2])
        law.x.reference = 40e-6 if k >= 2000 else 0.0
        law.y.reference = 0.0 if k >= 500 else -150e-6
        law.step(time)
        commands = np.array([[law.x.plus_cmd, law.x.minus_cmd], [law.y.plus_cmd, law.y.minus_cmd]])
        state = solve_ivp(rates, (time, time + 1e-4), state, args=(commands, 0.0), method="DOP853", rtol=1e-10,
                          atol=1e-13).y[:, -1]
        found.append(state[:2])
    exact = np.array(found)[::5]
    ours = np.column_stack([run[f"plant.{axis}.position"] for axis in "xy"])[:len(exact)]
    assert np.ptp(exact, axis=0).min() > 40e-6
    errors = np.abs(ours - exact).max(axis=0)
    assert errors[0] < 1e-11
    assert errors[1] < 3e-9   # its amplifiers reach their largest voltage, and a step goes over that kink
    assert [str(claim.verdict) for claim in run.verdicts] == ["met"]


@pytest.mark.thorough
def test_native_fmus_of_both_have_the_bits_of_the_files(slow: None, tmp_path: Path) -> None:
    require_native_tools()
    built = [maglev.build(FOLDER / name, fmus=tmp_path, kind="native", target="host")[0]
             for name in ("bearing.py", "controller.py")]
    assert [problem for fmu in built for problem in validate_fmu(str(fmu))] == []
    files = maglev.run(FOLDER / "levitate.toml")
    with warns("turning"):
        native = maglev.run(FOLDER / "levitate.toml", plant=built[0], controller=built[1], keep_settings=True)
    for name in ("plant.x.position", "plant.y.position", "plant.y.plus.i", "controller.x.plus_cmd"):
        np.testing.assert_array_equal(native[name], files[name], err_msg=name)


@pytest.fixture(scope="module")
def in_c(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The plant in C, as its reader builds it."""
    require_compiler()
    built: Path = script(EXAMPLES / "pd_controller_c" / "build.py").build(tmp_path_factory.mktemp("c"), FOLDER)
    return built


def test_the_plant_in_c_is_valid_and_moves_as_the_one_in_python(in_c: Path) -> None:
    assert validate_fmu(str(in_c)) == []
    python = maglev.run(FOLDER / "levitate.toml")
    with warns("turning = 628 rad/s"):
        run = maglev.run(FOLDER / "levitate.toml", plant=in_c)
    assert [str(claim.verdict) for claim in run.verdicts] == ["met"]
    for name in ("plant.x.position", "plant.y.position"):
        assert np.abs(run[name] - python[name]).max() < 1e-13, name   # m: the rounding of another sine and sum
    assert not run["plant.touched"].any()
    with pytest.warns(UserWarning), raises(maglev.RunFailed, "0 s", "bearing.fmu", "x.position", "y.position") as told:
        maglev.run(FOLDER / "levitate.toml", plant=in_c, set={"plant.mass": 0.0})
    require_facts(str(told.value).replace("-nan", "nan"), "nan m")   # the sign is the compiler's


def test_plain_fmpy_runs_the_plant_in_c(in_c: Path, tmp_path: Path) -> None:
    """In a loop of a few lines around the controller's class: the bits of our master."""
    with warns("turning = 628 rad/s"):
        run = maglev.run(FOLDER / "levitate.toml", plant=in_c)
    description = fmpy.read_model_description(in_c)
    number = {variable.name: variable.valueReference for variable in description.modelVariables}
    plant = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(in_c, tmp_path / "plant"),
                      modelIdentifier=description.coSimulation.modelIdentifier, instanceName="plant")
    plant.instantiate()
    plant.setupExperiment(startTime=0.0)
    plant.setReal([number["turning"]], [628.0])
    plant.enterInitializationMode()
    plant.exitInitializationMode()
    law = PythonFile(FOLDER / "controller.py").load().definition.new_block().law
    places = [number["x.position"], number["y.position"]]
    commands = [number[f"{axis}.{magnet}.i_cmd"] for axis in "xy" for magnet in ("plus", "minus")]
    found = [plant.getReal(places)]
    for k in range(6000):
        law.x.measured, law.y.measured = found[-1]
        law.x.reference = 40e-6 if k >= 2000 else 0.0
        law.y.reference = 0.0 if k >= 500 else -150e-6
        law.step(1e-4 * k)
        plant.setReal([*commands, number["y.force"]], [law.x.plus_cmd, law.x.minus_cmd, law.y.plus_cmd, law.y.minus_cmd,
                                                       20.0 if k >= 4000 else 0.0])
        plant.doStep(currentCommunicationPoint=1e-4 * k, communicationStepSize=1e-4)
        found.append(plant.getReal(places))
    plant.terminate()
    plant.freeInstance()
    for axis, values in zip("xy", np.transpose(found), strict=True):
        np.testing.assert_array_equal(values[::5], run[f"plant.{axis}.position"])
