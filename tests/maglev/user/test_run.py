"""Stages of one's own in the air: those that differ from ours in magnets, pitch, mass, travel and number of motors."""

from math import sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from described_stages import SMALL, written
from facts import raises
from interop.loops import foreign, ours_from_zero
from named_blocks import named_block

import maglev
from maglev.api.identifying import write_identification
from maglev.descriptions.own_fmus import built_here
from maglev.files.errors import IdentificationError, StageError
from maglev.identification.model_file import model_settings
from maglev.linear.loop import linearise_loop
from maglev.user.adoption import know_stage
from maglev.user.consequences import runnable

pytestmark = pytest.mark.usefixtures("slow")

# From the 3-DOF stage that everybody begins with: two motors that share each current become single ones.
SINGLE = {"sharing = 2 ": "sharing = 1 "}
FOUR = {**SINGLE, '[motors.alpha]\ndrives = "x"': '[motors.a1]\ndrives = "x"\n\n[motors.a2]\ndrives = "x"',
        '[motors.beta]\ndrives = "z"': '[motors.b1]\ndrives = "z"\n\n[motors.b2]\ndrives = "z"'}
TWO = {**SINGLE, "mass = 6.9 ": "mass = 3.4 ", "pole_pitch = 0.05715": "pole_pitch = 0.048",
       "slot_pitch = 0.01905": "slot_pitch = 0.016", "slot_width = 0.0127": "slot_width = 0.008",
       "magnet_height = 0.005": "magnet_height = 0.006", "lower = -0.062, upper = 0.062": "lower = -0.03, upper = 0.03"}
# A platform that tilts, with longer arms along z than along x, and a heavier one.
TILTING = {"mass = 6.9 ": "mass = 7.5 ", "mass = 0.2 ": "mass = 0.22 ", "z = 0.2": "z = 0.25", "z = -0.2": "z = -0.25",
           "x = 0.2 ": "x = 0.18 ", "x = -0.2 ": "x = -0.18 ", "coulomb = 1.1": "coulomb = 0.8"}


def simulated(suffix: str, axes: dict[str, float], seconds: float) -> tuple[Any, bool]:
    """Closed loop after a time under references (m), and whether it has touched a stop."""
    loop = named_block(f"ClosedLoop{suffix}")
    assert loop.start() == 0
    for axis, reference in axes.items():
        getattr(loop.controller, axis).reference = reference
    touched = False
    for k in range(round(seconds / 0.01)):
        assert loop.step(0.01 * k, 0.01) == 0
        touched = touched or loop.plant.at_stop
    return loop, touched


@pytest.mark.few(2)
@pytest.mark.parametrize(("name", "like", "changes", "references"), [
    ("one", "2dof", {"mass = 4.35 ": "mass = 5.5 "}, {"v": 0.0195, "h": 2e-3}),
    ("small", "2dof", SMALL, {"v": 0.0031, "h": 2e-3}),
    ("two", "3dof", TWO, {"y": 0.0255, "x": 4e-3, "z": -4e-3}),
    ("four", "3dof", FOUR, {"y": 0.0255, "x": 4e-3, "z": -4e-3}),
    ("tilting", "5dof", TILTING, {"y": 0.0255, "x": 4e-3, "z": -4e-3, "roll": 3e-3, "pitch": -4e-3})])
def test_it_levitates(tmp_path: Path, name: str, like: str, changes: dict[str, str],
                      references: dict[str, float]) -> None:
    runnable(written(tmp_path / f"{name}.toml", like, changes))
    loop, touched = simulated(name.capitalize(), references, 2.5)
    assert not touched
    for axis, reference in references.items():
        assert getattr(loop.plant, axis).position == pytest.approx(reference, abs=1.2e-3 if axis in "xz" else 0.2e-3)
    if "roll" in references:
        # Where the motors are: higher where the platform leans up.
        gaps = [getattr(loop.plant, motor).gap for motor in ("alpha1_mount", "beta1_mount")]
        assert gaps == pytest.approx([0.0255 - 0.25 * 3e-3, 0.0255 + 0.18 * -4e-3], abs=0.2e-3)


def test_single_motors_are_a_pair_with_one_current(tmp_path: Path) -> None:
    """Four motors with amplifiers of their own, and two pairs, have one loop."""
    loops = []
    for name, changes in (("quad", FOUR), ("pairs", {})):
        runnable(written(tmp_path / f"{name}.toml", "3dof", changes))
        suffix = name.capitalize()
        for kind in ("Regulator", "LinearRegulator"):
            loops.append(linearise_loop(f"Plant{suffix}", f"{kind}{suffix}", {"y": "24 mm", "x": "3 mm"}))
    for single, pair in zip(loops[:2], loops[2:], strict=True):
        # What the lags of the single amplifiers do in opposition is theirs alone, and fast.
        slow = [np.sort_complex(each.poles[abs(each.poles) > 0.8]) for each in (single, pair)]
        assert slow[0] == pytest.approx(slow[1], abs=1e-7)


@pytest.mark.thorough
def test_fmus_are_known_by_their_content(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They run as ours do for as long as the description is as it was when they were built."""
    monkeypatch.chdir(tmp_path)
    description = written(tmp_path / "own.toml", "2dof", {})
    maglev.build(["PlantOwn", "RegulatorOwn"], stage="own.toml")
    assert built_here(Path("fmus/PlantOwn.fmu"))
    text = (tmp_path / "own-setpoints.toml").read_text(encoding="utf-8")
    (tmp_path / "own-setpoints.toml").write_text(text.replace("16 s", "1.5 s").replace("[0, 1, 6, 11]", "[0, 1, 2, 3]"),
                                                 encoding="utf-8")
    run = maglev.run("own-setpoints.toml")
    assert not run.result.modified
    assert not run["plant.at_stop"].any()
    assert abs(run["plant.v.position"] - 0.020).max() < 2e-3
    description.write_text(description.read_text(encoding="utf-8").replace("mass = 4.35 ", "mass = 4.4 "),
                           encoding="utf-8")
    know_stage(description)
    assert not built_here(Path("fmus/PlantOwn.fmu"))


@pytest.mark.few(6)
@pytest.mark.parametrize(("like", "changes", "facts"), [
    ("3dof", {"mass = 6.9 ": "mass = 14.0 "}, ["alpha", "i_d", "alpha.amplifier.continuous", "4 A"]),
    ("3dof", {"mass = 6.9 ": "mass = 14.0 ", "continuous = 4.0": "continuous = 0",
              "current_limit = 4.0": "current_limit = 0"}, ["alpha", "i_d", "alpha.amplifier.peak", "5 A"]),
    ("3dof", {"current_limit = 4.0": "current_limit = 1.0"}, ["alpha.i_d_cmd", "current_limit", "1 A"]),
    ("3dof", {"attraction = 12.06": "attraction = 60", "iron_attraction = 0.03037": "iron_attraction = 1.0"},
     ["6.9 kg", "25 mm", "34.8 m/s²", "9.81 m/s²"]),
    ("3dof", {"force_constant = 2.313 ": "force_constant = 0.1 "}, ["axes.x", "1.73 N"]),
    ("3dof", {"sample_time = 0.0002 ": "sample_time = 0.01 "}, ["sample_time", "10 ms"]),
    ("3dof", {"lower = 0.0185": "lower = 0.006"}, ["axes.y.stop", "6 to 32 mm", "8…40 mm"]),
    ("5dof", {"lower = 0.0185": "lower = 0.006"}, ["motor_stop", "6 to 32 mm", "8…40 mm"]),
    ("5dof", {"mass = 0.2 ": "mass = 0.01 ", "sample_time = 0.0002 ": "sample_time = 0.002 "}, ["sample_time", "2 ms"]),
    ("3dof", {"# poles = [-90, [-4, 6], [-2, 2]]": "poles = [-1, -1, -1, -1, -1]"}, ["design", "pole"]),
    ("3dof", {"slot_pitch = 0.01905 ": "slot_pitch = 0.01 "},
     ["geometry.slot_width", "0.0127 m", "geometry.slot_pitch", "0.01 m"]),
    ("3dof", {'name = "hover"': 'name = "Hover"'}, ["name", "'Hover'", "lower-case"])])
def test_an_impossible_run_gives_its_reason(tmp_path: Path, like: str, changes: dict[str, str],
                                            facts: list[str]) -> None:
    path = written(tmp_path / "hover.toml", like, changes)
    with raises(StageError, path, *facts):
        runnable(path)


@pytest.mark.thorough
def test_everything_takes_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Regions, environments and controllers to begin with, by the file of its description."""
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "swan.toml", "2dof", {"pole_pitch = 0.05715": "pole_pitch = 0.05"})
    found = maglev.region("swan.toml", "h", "20 mm", run=False)
    assert found.loop.name == "h of PlantSwan with RegulatorSwan at v = 20 mm"
    maglev.new_controller("lqi.py", stage="swan.toml")
    files = maglev.build(stage="swan.toml", names=["PlantSwan", "CommutationSwan", "RegulatorSwan"], kind="native",
                         target="host")
    assert all(map(built_here, files))
    (tmp_path / "short.toml").write_text('extends = "swan-setpoints.toml"\nname = "short"\nstop_time = "1.2 s"\n',
                                         encoding="utf-8")
    compared = maglev.compare("short.toml", ["RegulatorSwan", "lqi.py"])
    assert not any(run["plant.at_stop"].any() for run in compared.runs.values())
    assert not compared.runs["RegulatorSwan"].result.modified
    import gymnasium

    environment = gymnasium.make("maglev.gym:maglev/Stage-v0", stage="swan.toml")
    observation, _ = environment.reset(seed=1)
    assert observation[0] == pytest.approx(0.020)
    environment.close()


@pytest.mark.thorough
def test_a_recording_tells_its_constants(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a stage with four motors without friction, under sinusoids on all axes: those of the block that ran."""
    monkeypatch.chdir(tmp_path)
    stage = know_stage(written(tmp_path / "found.toml", "3dof", {**FOUR, "mass = 6.9 ": "mass = 6.0 "}))
    loop = named_block("ClosedLoopFound")
    plant, controller = loop.plant, loop.controller
    plant.attraction_modulation = plant.encoder.resolution = 0.0
    for axis in stage.axis_names:
        of = getattr(plant, axis)
        of.bias = of.friction.coulomb = of.friction.viscous = of.ripple.amplitude = 0.0
    assert loop.start() == 0
    rows = []
    for k in range(10000):
        t = 1e-3 * k
        for axis, middle, way, rate in (("y", 0.024, 2e-3, 5.0), ("x", 0.0, 8e-3, 4.0), ("z", 0.0, 8e-3, 3.0)):
            getattr(controller, axis).reference = middle + way * sin(rate * t)
        assert loop.step(t, 1e-3) == 0
        currents = [getattr(getattr(plant, motor), f"i_{part}") for motor in stage.motor_names for part in "dq"]
        rows.append([t + 1e-3, *(getattr(plant, axis).position for axis in stage.axis_names), *currents])
    np.savetxt("mine.csv", rows, delimiter=",", header=",".join(["time", *stage.axis_names, *stage.dq_names]),
               comments="")
    found = maglev.identify("mine.csv", stage="found.toml", matched=True)
    for name in ("C1", "C2", "C3", "C4"):
        assert found.estimate.final[name] == pytest.approx(getattr(plant, name), rel=0.01)
    # Back into a run: a model file of this stage, which no other takes.
    model, _, *_ = write_identification(found, "mine.csv", tmp_path)
    settings = model_settings(model, stage)
    assert settings["plant.C3"] == found.estimate.final["C3"]
    with raises(IdentificationError, "stage", "'found'", "2dof", "3dof"):
        model_settings(model)


@pytest.mark.thorough
def test_a_stage_that_tilts_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its scenario runs it, in rad too; what measures each axis by itself says that it does not take it."""
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "leaning.toml", "5dof", TILTING)
    maglev.build(stage="leaning.toml", names=["StageLeaning"], kind="native", target="host")
    run = maglev.run("leaning-setpoints.toml")
    assert not run["plant.at_stop"].any()
    assert run.plan.axes["roll"].rotation
    for axis in ("y", "x", "z", "roll", "pitch"):
        assert abs(run[f"plant.{axis}.position"][-1] - run[f"controller.{axis}.reference"][-1]) < 0.1e-3
    assert run["controller.roll.reference"].max() > 0.5e-3
    (tmp_path / "pid.toml").write_text('extends = "leaning-setpoints.toml"\nname = "pid"\n'
                                       'fmus.controller.model = "PIDLeaning"\n', encoding="utf-8")
    assert not maglev.run("pid.toml")["plant.at_stop"].any()
    # The system of its plant and controller runs in another tool.
    plan = run.plan.model_copy(update={"stop_time": 1.2})
    rows = foreign("fmpy.ssp", plan, Path("fmus/native"), tmp_path, Path("fmus/native/StageLeaning.ssp"))
    assert np.ptp(rows, axis=0).min() > 1e-4
    assert np.array_equal(rows, ours_from_zero(plan, Path("fmus/native")))
    found = maglev.region("leaning.toml", "y", "25 mm", run=False)
    assert found.loop.axes == ("y",)
    assert 1e-3 < found["without"].certificate.step < found["without"].simulated
    # A controller to begin with, through its first steps of all axes.
    maglev.new_controller("lqi.py", stage="leaning.toml")
    (tmp_path / "short.toml").write_text('extends = "leaning-setpoints.toml"\nname = "short"\nstop_time = "2.5 s"\n',
                                         encoding="utf-8")
    short = maglev.run("short.toml", controller="lqi.py")
    assert not short["plant.at_stop"].any()
    assert short["controller.roll.reference"][-1] > 0.5e-3
    assert max(short.metrics.end_errors.values()) < 50e-6
