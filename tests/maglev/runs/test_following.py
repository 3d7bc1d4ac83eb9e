"""A controller's model at the plant's masses, `--model plant`: what a mass of another size then does not change."""

from pathlib import Path

import numpy as np
import pytest
from facts import raises

import maglev
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import ScenarioError
from maglev.user.new_stage import new_stage
from maglev.user.reading import read_own
from pmlsm.stage_description import StageDescription

STEPS = {axis: (0.0, way) for axis, way in zip("hxz", (3e-3, 3e-3, -2e-3), strict=True)}
STEPS |= {"v": (0.020, 0.021), "y": (0.025, 0.0245), "roll": (0.0, 2e-3), "pitch": (0.0, -1e-3)}

# Masses 15 to 30 % above the nominal ones, of every axis another one.
HEAVIER = {"v": 5.2, "h": 2.0, "y": 7.9, "x": 13.0, "z": 10.5, "roll": 0.26, "pitch": 0.23}


def scenario(folder: Path, stage: StageDescription, law: str, steps: bool, own: bool = False) -> Path:
    """A stage that is, except for its masses, what the controller takes it for: it rests, or all axes step."""
    plant = {f"{axis.name}.{name}": 0.0 for axis in stage.axes for name in
             ("bias", "friction.coulomb", "friction.viscous", *(() if axis.rotation else ("ripple.amplitude",)))}
    plant |= {"encoder.resolution": 0.0, "attraction_modulation": 0.0, **{f"{motor}.amplifier.lag": 0.0
                                                                       for motor in stage.motor_names}}
    plant |= {each.name: each.model for each in stage.constants}
    base = 'stage = "mine.toml"' if own else f'extends = "loops/{stage.name}.toml"'
    lines = [base, 'name = "follows"', 'title = "It follows"',
             "stop_time = 0.6", "[fmus.controller]", f'model = "{law}{stage.suffix}"', "[fmus.plant.start]"]
    lines += [f'"{name}" = {value!r}' for name, value in plant.items()]
    for axis in stage.axis_names:
        start, end = STEPS[axis]
        lines += ["[[signals]]", f'to = "controller.{axis}.reference"', 'kind = "steps"', "times = [0, 0.1]",
                  f"values = [{start}, {end if steps else start}]"]
    path = folder / "follows.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def masses(stage: StageDescription) -> dict[str, float]:
    """Settings of the heavier masses."""
    return {f"plant.{axis.name}.{'inertia' if axis.rotation else 'mass'}": HEAVIER[axis.name] for axis in stage.axes}


def positions(run: maglev.Run, stage: StageDescription) -> np.ndarray:
    """True positions, a row for each axis."""
    return np.array([run[f"plant.{axis}.position"] for axis in stage.axis_names])


@pytest.mark.parametrize("stage", PACKAGED_STAGES.values(), ids=PACKAGED_STAGES)
def test_linearised_motion_has_no_mass(stage: StageDescription, fastest_fmus: Path, tmp_path: Path) -> None:
    """Feedback linearisation makes the accelerations that are demanded, whatever the mass: the path is the same.

    But for what forces change while a current is held, which goes with the sample time.
    """
    path = scenario(tmp_path, stage, "Regulator", steps=True)
    apart = []
    for step in (stage.sample_time, stage.sample_time / 4.0):
        settings = {"controller.sample_time": step}
        nominal = maglev.run(path, fmus=fastest_fmus, step=step, set=settings)
        heavier = maglev.run(path, fmus=fastest_fmus, step=step, set=settings | masses(stage), model="plant")
        apart.append(abs(positions(heavier, stage) - positions(nominal, stage)).max(axis=1))
    assert apart[0].max() < 2e-6
    assert (apart[1] < apart[0] / 3.0).all()
    unknown = maglev.run(path, fmus=fastest_fmus, step=step, set=settings | masses(stage))
    assert (abs(positions(unknown, stage) - positions(nominal, stage)).max(axis=1) > 100.0 * apart[0]).all()
    # What it takes for it is in the provenance, and it takes other currents.
    changes = heavier.result.provenance.changes if heavier.result.provenance else ()
    vertical = stage.vertical
    constant = next(each for each in stage.constants if each.axis == vertical.name)
    value = constant.model * vertical.mass / HEAVIER[vertical.name]
    said, = [change for change in changes if change.startswith(f"controller.{constant.name} = ")]
    assert float(said.split()[2]) == pytest.approx(value, rel=1e-15)
    current = f"plant.{stage.motor_names[0]}.i_d"
    assert abs(heavier[current] - nominal[current]).max() > 0.05


@pytest.mark.parametrize("law", ["LinearRegulator", "PID"])
@pytest.mark.parametrize("stage", PACKAGED_STAGES.values(), ids=PACKAGED_STAGES)
def test_it_begins_at_rest(stage: StageDescription, law: str, fastest_fmus: Path, tmp_path: Path) -> None:
    """The current that holds the mover is computed from the model: with the mass of the run, nothing moves."""
    path = scenario(tmp_path, stage, law, steps=False)
    known = positions(maglev.run(path, fmus=fastest_fmus, set=masses(stage), model="plant"), stage)
    assert abs(known - known[:, :1]).max() < 1e-10
    unknown = positions(maglev.run(path, fmus=fastest_fmus, set=masses(stage)), stage)
    assert abs(unknown - unknown[:, :1]).max() > 1e-4


def test_a_payload_is_mass_and_inertia(fastest_fmus: Path, tmp_path: Path) -> None:
    """p kg on the centre of the platform are p kg on each of its masses, and aside p b², p a² of its inertias."""
    stage = PACKAGED_STAGES["5dof"]
    path = scenario(tmp_path, stage, "Regulator", steps=True)
    payload = {"plant.payload.mass": 0.8, "plant.payload.x": 0.02, "plant.payload.z": -0.03}
    run = maglev.run(path, fmus=fastest_fmus, set=payload, model="plant")
    assert run.result.provenance is not None
    found = {change.split()[0]: float(change.split()[2]) for change in run.result.provenance.changes}
    for name, value in (("y.mass", 7.7), ("x.mass", 11.4), ("roll.inertia", 0.2 + 0.8 * 0.03**2),
                        ("pitch.inertia", 0.2 + 0.8 * 0.02**2), ("C1", 0.6135 * 10.6 / 11.4)):
        assert found[f"controller.{name}"] == pytest.approx(value, rel=1e-12)


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
def test_a_stage_of_ones_own_follows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    new_stage("mine.toml", like="2dof")
    stage = read_own(tmp_path / "mine.toml")
    maglev.build(["PlantMine", "RegulatorMine"], stage="mine.toml")
    path = scenario(tmp_path, stage, "Regulator", steps=True, own=True)
    # Within the limit of the currents, which the designed gains reach at the whole steps.
    smaller = {f"reference.{axis}.amplitude": 0.3 for axis in stage.axis_names}
    nominal = maglev.run(path, set=smaller)
    heavier = maglev.run(path, set=masses(stage) | smaller, model="plant")
    assert abs(positions(heavier, stage) - positions(nominal, stage)).max() < 2e-6
    unknown = maglev.run(path, set=masses(stage))
    assert abs(positions(unknown, stage) - positions(nominal, stage)).max() > 1e-4


@pytest.mark.usefixtures("slow")
def test_every_sample_of_a_study_follows(fastest_fmus: Path, tmp_path: Path) -> None:
    """Each has the masses that are drawn for it; what is set is as it is set."""
    path = scenario(tmp_path, PACKAGED_STAGES["2dof"], "Regulator", steps=True)
    study = maglev.study(path, vary={"plant.v.mass": [4.35, 5.0, 5.5]}, model="plant", fmus=fastest_fmus, out=tmp_path,
                         jobs=1)
    overshoot = study.to_xarray()["overshoot of v"].values
    assert np.ptp(overshoot) < 1e-4
    assert overshoot[0] > 0.01
    without = maglev.study(path, vary={"plant.v.mass": [4.35, 5.0, 5.5]}, fmus=fastest_fmus, out=tmp_path, jobs=1)
    assert np.ptp(without.to_xarray()["overshoot of v"].values) > 0.01
    asked = maglev.run(path, fmus=fastest_fmus, model="plant", set={"plant.v.mass": 5, "controller.C2": 800})
    assert asked.result.provenance is not None
    assert "controller.C2 = 800 m/(s²·T²) instead of 796.99 m/(s²·T²)" in asked.result.provenance.changes


@pytest.mark.parametrize(("settings", "controller", "facts"), [
    ({}, "Commutation3DOF.fmu", ["model", "plant", "C1, C2, C3, C4, C5"]),
    ({"plant.y.mass": 0.0}, None, ["plant.y.mass", "0 kg", "0.001", "1e+06 kg"])])
def test_refuses_a_model_that_cannot_follow(settings: dict[str, float], controller: str | None, facts: list[str],
                                            fastest_fmus: Path) -> None:
    with raises(ScenarioError, *facts):
        maglev.run("3dof-setpoints", fmus=fastest_fmus, set=settings, model="plant",
                   controller=controller and fastest_fmus / controller)


def test_constants_of_another_run_are_not_those_of_the_nominal_mass(fastest_fmus: Path, tmp_path: Path) -> None:
    path = scenario(tmp_path, PACKAGED_STAGES["2dof"], "Regulator", steps=False)
    text = path.read_text(encoding="utf-8").replace("[fmus.plant.start]", "[fmus.controller.start_from]\n"
        'C2 = { run = "2dof-identification-rig", output = "estimator_10ms.C2" }\n[fmus.plant.start]')
    path.write_text(text, encoding="utf-8")
    with raises(ScenarioError, "model", "plant", "controller.C2", "2dof-identification-rig"):
        maglev.run_all([path], fmus=fastest_fmus, model="plant", out=tmp_path)
