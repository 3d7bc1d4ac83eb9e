"""A stage that tilts: the rows of its motors at gaps of their own, and constants from a run's recording."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from facts import raises
from reference_5dof import NOMINAL, Reference5DOF
from reference_stage import G, park_matrix

import maglev
from maglev.files.errors import CsvError, IdentificationError
from maglev.identification.identify import Identification, identify
from maglev.identification.recording import read_recording
from maglev.identification.regressors import ESTIMATED_STAGES, accelerations, regressors

DESCRIPTION = ESTIMATED_STAGES["5dof"]
TRUTH = {"C1": 0.6135, "C2": 0.8224, "C3": 334.52, "C4": 8.71, "C5": 0.0045}
MOTORS = ("alpha1", "alpha2", "beta1", "beta2")
SEEN = ["plant.x.encoder", "plant.z.encoder", *(f"plant.{motor}.gap_encoder" for motor in MOTORS)]
CURRENTS = [f"plant.{motor}.i_{component}" for motor in MOTORS for component in "dq"]
SMOOTH = {**{f"plant.{axis}.{name}": 0.0 for axis in DESCRIPTION.axes for name in ("bias", "friction.coulomb",
                                                                          "friction.viscous")},
          **{f"plant.{motor}.amplifier.lag": 0.0 for motor in MOTORS},
          "plant.y.ripple.amplitude": 0.0, "plant.attraction_modulation": 0.0}
KINDS = {"ideal": {**SMOOTH, "plant.encoder.resolution": 0.0}, "encoder": SMOOTH, "real": {}}


def samples(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, i_d and i_q at random, off the stops."""
    random = np.random.default_rng(3)
    positions = random.uniform([21e-3, -0.03, -0.03, -8e-3, -8e-3], [29e-3, 0.03, 0.03, 8e-3, 8e-3], (count, 5))
    return positions, random.uniform(-3.0, 3.0, (count, 4)), random.uniform(-3.0, 3.0, (count, 4))


def test_accelerations_are_those_of_the_equations_written_again() -> None:
    """All five axes, at tilts, to rounding."""
    positions, i_d, i_q = samples(20)
    found = accelerations(DESCRIPTION, positions, i_d, i_q, TRUTH)
    stage = Reference5DOF(modulation=0.0)
    for k, q in enumerate(positions):
        along = DESCRIPTION.places.along @ q
        phases = np.array([3 / 2 * park_matrix(d).T @ dq for d, *dq in zip(along, i_d[k], i_q[k], strict=True)])
        expected = stage.forces(q, np.zeros(5), phases) / NOMINAL
        assert found[k] == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert found[:, 3].min() < -1.0 < 1.0 < found[:, 3].max()


def test_rows_carry_each_constant_once() -> None:
    positions, i_d, i_q = samples(5)
    rows = regressors(DESCRIPTION, positions, i_d, i_q, np.zeros((5, 5)))
    assert [(data.row.axis, data.row.constants) for data in rows] == [
        ("y", ("C3", "C4", "C5")), ("x", ("C1",)), ("z", ("C2",))]
    whole = accelerations(DESCRIPTION, positions, i_d, i_q, TRUTH)
    for k, data in enumerate(rows):
        theta = np.array([TRUTH[name] for name in data.row.constants])
        assert data.a @ theta + data.b == pytest.approx(whole[:, k], rel=1e-12)
    assert (rows[0].b == G).all()


def written(path: Path, columns: dict[str, np.ndarray]) -> Path:
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="",
               fmt="%.15g")
    return path


@pytest.mark.usefixtures("slow")
def test_recordings_have_gaps_or_tilts(tmp_path: Path) -> None:
    """Gaps at the motors go before positions, and say which stage it is; three positions alone are another one."""
    time = 1e-3 * np.arange(1200)
    positions = np.array([24e-3, 1e-3, -2e-3, 4e-3, -3e-3]) * (1.0 + 0.1 * np.sin(6.0 * time))[:, None]
    currents = {name: np.sin(time) for name in CURRENTS}
    gaps = positions @ DESCRIPTION.places.gaps.T
    seen = dict(zip(SEEN, np.column_stack([positions[:, 1:3], gaps]).T, strict=True))
    wrong = {f"plant.{axis}.position": 0.025 + 0.0 * time for axis in ("y", "roll", "pitch")}
    for columns in ({"time": time, **seen, **currents}, {"time": time, **seen, **wrong, **currents},
                    {"time": time, **dict(zip(DESCRIPTION.axes, positions.T, strict=True)), **currents}):
        found = read_recording(written(tmp_path / "a.csv", columns))
        assert found.stage.name == "5dof"
        assert found.positions == pytest.approx(positions, abs=1e-12)
    # Phase currents are seen at the displacement of the motor, which tilts too.
    phases: dict[str, np.ndarray] = {}
    for k, motor in enumerate(MOTORS):
        turned = [3 / 2 * park_matrix(d).T @ [1.5, -0.5] for d in positions @ DESCRIPTION.places.along[k]]
        phases |= dict(zip((f"{motor}.i_{phase}" for phase in "abc"), np.array(turned).T, strict=True))
    found = read_recording(written(tmp_path / "a.csv", {"time": time, **seen, **phases}))
    assert found.i_d == pytest.approx(np.full((1200, 4), 1.5), abs=1e-9)
    assert found.i_q == pytest.approx(np.full((1200, 4), -0.5), abs=1e-9)
    three = {"time": time, **dict(zip("yxz", positions.T[:3], strict=True))}
    with raises(IdentificationError, "alpha.i_d"):
        read_recording(written(tmp_path / "a.csv", three))
    seen["plant.beta1.gap_encoder"] = 1e3 * seen["plant.beta1.gap_encoder"]
    with raises(CsvError, "row 2", "plant.beta1.gap_encoder", "23.4", "0.008", "0.04 m"):
        read_recording(written(tmp_path / "a.csv", {"time": time, **seen, **currents}))


SCENARIO = 'extends = "5dof-tracking.toml"\nname = "tracking"\ntitle = "Tracking"\noutput_interval = "0.4 ms"\n'


@cache
def identified(kind: str, fmus: Path, folder: Path) -> Identification:
    """From half of the truth, of a run of `5dof-tracking`; with what is left of the plant's effects."""
    scenario = folder / "tracking.toml"
    scenario.write_text(SCENARIO, encoding="utf-8")
    run = maglev.run(scenario, fmus=fmus, set=KINDS[kind])
    columns = {"time": run.time, **{name: run[name] for name in (*SEEN, *CURRENTS)}}
    recording = read_recording(written(folder / f"{kind}.csv", columns))
    return identify(recording, guess={name: 0.5 * value for name, value in TRUTH.items()}, match=kind != "ideal")


@pytest.fixture(scope="module")
def folder(native_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the native FMUs in its folder native."""
    found = tmp_path_factory.mktemp("tracking")
    (found / "native").symlink_to(native_fmus)
    return found


@pytest.mark.thorough
@pytest.mark.parametrize(("kind", "within"), [("ideal", 0.005), ("encoder", 0.005)])
def test_constants_from_a_run(kind: str, within: float, folder: Path) -> None:
    """As near as those of the other stages: half a percent, also with encoders of 10 µm."""
    found = identified(kind, folder / "native", folder)
    assert max(abs(found.estimate.final[name] / value - 1.0) for name, value in TRUTH.items()) < within
    assert found.warnings == []
    # The replay tilts as the recording does.
    assert (found.replay_error < 0.1 * found.replay_motion).all()


@pytest.mark.thorough
def test_constants_of_the_stage_with_all_its_effects(folder: Path) -> None:
    """Attraction and coils within 5 and 2 %, as on the 3-DOF stage; friction is counted in the thrusts."""
    found = identified("real", folder / "native", folder)
    apart = {name: abs(found.estimate.final[name] / value - 1.0) for name, value in TRUTH.items()}
    assert apart["C3"] < 0.05 and apart["C4"] < 0.02
    assert apart["C1"] < 0.1 and apart["C2"] < 0.1
    assert found.standard_error["C5"] > 0.25 * TRUTH["C5"]
