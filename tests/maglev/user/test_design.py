"""Stages that are designed: what a motor's data sheet makes, how it runs, and what is said of it."""

import json
import re
from dataclasses import fields
from math import inf, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import error_line
from command_line import maglev as command
from facts import raises, require_facts
from named_blocks import named_block
from scipy.integrate import quad

import maglev
from maglev.analysis.axis_loop import stage_and_regulators as of_regulators
from maglev.cli.new import stage_file
from maglev.files.errors import ScenarioError, StageError
from maglev.linear.loop import linearise_loop
from maglev.scenario.loading import load_plan
from maglev.user import gain_design as design
from maglev.user.adoption import know_stage, stage_named
from maglev.user.consequences import fall
from maglev.user.motor import MOTORS, Motor
from maglev.user.new_stage import new_stage
from maglev.user.scenario_loop import setpoints
from pmlsm.stage_description import StageDescription

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

# An iron-core motor as they are sold: 93 N/A rms, 950 N at 0.9 mm, under 12 kg at 5 mm.
REAL = ["force_constant=93", "attraction=950", "attraction_gap=0.9mm", "pole_pitch=12mm", "peak=6.5", "continuous=3.2",
        "gap=5mm", "mass=12kg"]


def simulated(stage: StageDescription, law: str = "") -> Any:
    """Closed loop of a stage after its setpoints, each for 0.6 s; it has touched no stop."""
    loop = named_block(f"ClosedLoop{law}{stage.suffix}")
    assert loop.start() == 0
    for k in range(4):
        for axis, values in setpoints(stage).items():
            getattr(loop.controller, axis).reference = 1e-3 * values[k]
        for _ in range(60):
            assert loop.step(0.0, 1e-2) == 0
            assert not loop.plant.at_stop
    return loop


@pytest.mark.few(1)
@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("law", ["", "Linear", "PID"])
def test_a_real_motor_runs_at_the_first_try(tmp_path: Path, law: str) -> None:
    """What `new stage` wrote, unchanged; for the thesis's gains, scaled, it was another 0.5 ms and 4 A."""
    path, _ = new_stage(tmp_path / "heavy.toml", motor=REAL)
    stage = know_stage(path)
    loop = simulated(stage, law)
    for axis, values in setpoints(stage).items():
        assert getattr(loop.plant, axis).position == pytest.approx(1e-3 * values[3], abs=5e-6)
    assert stage.sample_time == 1e-4
    assert stage.design.current_limit == pytest.approx(6.5 * sqrt(2.0))


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize(("motor", "like"), [("small", "2dof"), *(
    pytest.param(*each, marks=pytest.mark.thorough) for each in (("medium", "3dof"), ("large", "5dof")))])
def test_packaged_motors_run(tmp_path: Path, motor: str, like: str) -> None:
    path, _ = new_stage(tmp_path / f"{motor}.toml", like, motor=[motor])
    stage = know_stage(path)
    loop = simulated(stage)
    for axis, values in setpoints(stage).items():
        assert getattr(loop.plant, axis).position == pytest.approx(1e-3 * values[3], abs=1e-4)
    found = maglev.stage(path)
    assert not found.warnings
    for place in found.places:
        assert place.currents and min(place.closing, place.opening) > 0.0
        assert min(phase for phase, _ in place.margins.values()) > 35.0
        assert min(gain for _, gain in place.margins.values()) > 6.0


@pytest.mark.few(1)
@pytest.mark.parametrize(("name", "like", "motor"), [("heavy", "2dof", REAL), ("tilting", "5dof", ["medium"])])
def test_margins_of_the_design_are_those_of_the_loop(tmp_path: Path, name: str, like: str, motor: list[str]) -> None:
    """Of one axis by itself, and of derivatives of the blocks, closed by all of them: two ways to one number."""
    path, _ = new_stage(tmp_path / f"{name}.toml", like, motor=motor)
    stage = know_stage(path)
    axes = stage.axis_names if name == "heavy" else ("y", "roll", "x")
    for axis in axes:
        time, rates, designed = design.designed_rates(stage, [axis], stage.design.observer_time)
        assert time == stage.design.observer_time
        assert design.gains_at_rate(rates[axis]) == stage.axis(axis).design.gains
        start, lower, upper = design.gap_travel(stage)
        lifted = {f"{motor}.amplifier.{key}": value for motor in stage.motor_names
                  for key, value in (("peak", 1e3), ("continuous", 0.0))}
        loops = [linearise_loop(f"Plant{stage.suffix}", f"Regulator{stage.suffix}", {stage.vertical.name: gap},
                                plant_parameters=lifted, controller_parameters={"current_limit": 0.0})
                 for gap in (start, lower + 1e-9, upper - 1e-9)]
        assert all(loop.stable for loop in loops)
        assert min(loop.margins(axis).disk for loop in loops) == pytest.approx(designed, rel=0.02)


def test_a_stage_is_named_by_the_path_of_its_file(tmp_path: Path) -> None:
    path, _ = new_stage(tmp_path / "heavy.toml", motor=REAL)
    assert stage_named(path) == of_regulators(path)[0] == know_stage(path)


def test_a_mover_without_current_falls_as_energy_has_it(tmp_path: Path) -> None:
    """Time over the way, by the speed that the work of gravity and attraction gives: ∫ dg/√(2 ∫ a dg)."""
    stage = know_stage(new_stage(tmp_path / "heavy.toml", motor=[*REAL[:-1], "mass=16kg"])[0])
    begin, end = stage.vertical.start, stage.gap_stop.upper
    plant = named_block("PlantHeavy")
    plant.start()
    plant.attraction_modulation = plant.v.bias = plant.v.friction.coulomb = plant.v.friction.viscous = 0.0

    def acceleration(gap: float) -> float:
        plant.v.begin()
        plant.h.begin()
        plant.v.position = gap
        plant.add_slope(0.0, 0.0)
        return float(plant.v.acceleration)

    def slowness(u: float) -> float:   # with g = begin + (end - begin) u², for the speed begins as the root of the way
        gap = begin + (end - begin) * u * u
        work = quad(acceleration, begin, gap)[0]
        return 2.0 * u * (end - begin) / sqrt(2.0 * work)

    assert fall(stage) == pytest.approx(quad(slowness, 1e-6, 1.0, epsabs=1e-8)[0], rel=1e-4)


def test_force_left_over_is_that_of_the_plant(tmp_path: Path) -> None:
    path, _ = new_stage(tmp_path / "heavy.toml", motor=REAL)
    know_stage(path)
    plant = named_block("PlantHeavy")
    plant.start()
    plant.attraction_modulation = plant.v.bias = 0.0
    found = maglev.stage(path)
    for place in found.places:
        forces = []
        for current in np.linspace(-found.limits["motor"], found.limits["motor"], 401):
            plant.v.begin()
            plant.h.begin()
            plant.v.position, plant.motor.i_d = place.gap, current
            plant.add_slope(0.0, 0.0)
            forces.append(12.0 * plant.v.acceleration)
        assert (-place.closing, place.opening) == pytest.approx((min(forces), max(forces)), rel=1e-4)


@pytest.mark.few(2)
@pytest.mark.parametrize(("changes", "warnings"), [
    ({"# sample_time = 0.0005": "sample_time = 0.0005"},
     ["sample_time: 0.5 ms costs more than 10° of phase, expected 0.1 ms or less"]),
    # The thesis's gains, scaled by the rate of the fall as they were before they were designed.
    ({"# poles = [-90, [-4, 6], [-2, 2]]": "poles = [-176, [-7.8, 11.7], [-3.9, 3.9]]"},
     [r"v = 3.5 mm: v has margins of \d+° and [34].\d dB, expected 35° and 6 dB"]),
    ({"# current_limit = 4.0": "current_limit = 3.0"},
     [r"v = 3.5 mm: i_d = 3.79 A holds the mover, expected less than 3 A: a larger limit"]),
    ({"continuous = 3.2": "continuous = 2.5"},
     [r"v = 3.5 mm: i_d = 3.79 A holds the mover, the amplifiers give continuously 3.54 A"])])
def test_warns_of_designs_that_run_badly(tmp_path: Path, changes: dict[str, str], warnings: list[str]) -> None:
    path, _ = new_stage(tmp_path / "heavy.toml", motor=REAL)
    text = path.read_text(encoding="utf-8")
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    said = maglev.stage(path).warnings
    assert len(said) == len(warnings), said
    for one, expected in zip(said, warnings, strict=True):
        assert re.search(expected, one), one


@pytest.mark.usefixtures("slow")
def test_the_command_prints_what_follows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert command("new", "stage", "heavy", "--motor", "medium", "--motor", "mass=12kg").exit_code == 0
    done = command("stage", "heavy.toml", "--json", "heavy.json")
    assert done.exit_code == 0, done.output
    for words in ("12 kg at a gap of 5 mm", "of at most 9.19", "sample time       0.1 ms", "force left over"):
        assert words in done.stdout
    assert "warning" not in done.stdout
    data = json.loads((tmp_path / "heavy.json").read_text(encoding="utf-8"))
    assert data["wanted_sample_time"] == 1e-4 and len(data["places"]) == 3
    built = command("build", "--stage", "heavy.toml", "MeasurementHeavy")
    assert built.exit_code == 0 and "sample time 0.1 ms, margins" in built.stderr
    (tmp_path / "heavy.toml").write_text((tmp_path / "heavy.toml").read_text().replace("# sample_time", "sample_time"))
    built = command("build", "--stage", "heavy.toml", "MeasurementHeavy")
    assert "sample_time: 0.5 ms costs more than 10° of phase" in built.stderr
    require_facts(error_line(command("stage", "hevy.toml")), "hevy.toml", "'heavy.toml'")


@pytest.mark.parametrize(("motor", "facts"), [
    (["tiny"], ["--motor", "tiny", "small, medium, large"]),
    (["force=3"], ["--motor", "force=3", "'force_constant'"]),
    (["force_constant=93"], ["--motor", "attraction, attraction_gap, pole_pitch, peak", "KEY=VALUE"]),
    (["medium", "peak=3kg"], ["--motor", "peak", "'3kg'", "A"]),
    (["medium", "peak=1e9"], ["--motor", "peak", "1e+09 A", "0.001", "700 A"]),
    (["medium", "gap=50mm"], ["--motor", "gap=50mm", "pole_pitch", "12 mm"]),
    (["medium", "slot_width=9mm"], ["--motor", "slot_width=0.009", "slot_pitch", "0.004 m"]),
    (["medium", "currents=mean"], ["--motor", "currents=mean", "rms", "peak"]),
    (["medium", "mass=50kg"], ["v", "5 mm", "motor", "-9.2 A", "4.38406 A"])])
def test_refuses_impossible_motors(tmp_path: Path, motor: list[str], facts: list[str]) -> None:
    with raises(StageError, *facts):
        new_stage(tmp_path / "own.toml", motor=motor)
    assert not list(tmp_path.iterdir())


def test_the_help_names_all_keys() -> None:
    told = re.search(r"Keys: ([^.]*)\.", stage_file.__doc__ or "")
    assert told is not None and {each.name for each in fields(Motor)} <= {*re.findall(r"\w+", told[1])}
    assert all(path.is_file() for path in MOTORS.values())


def test_setpoints_follow_the_stage(tmp_path: Path) -> None:
    """A gap that is edited takes the references of the scenario with it; and only a stage has some."""
    path, scenario = new_stage(tmp_path / "heavy.toml", motor=REAL)
    before = [signal.values for signal in load_plan(scenario).signals]   # type: ignore[union-attr]
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("start = 0.005 ", "start = 0.0048 "), encoding="utf-8")
    after = [signal.values for signal in load_plan(scenario).signals]   # type: ignore[union-attr]
    assert before[0][0] == 5e-3 and after[0][0] == 4.8e-3
    scenario.write_text('extends = "loops/2dof.toml"\nname = "none"\nstop_time = 1\nsignals = "setpoints"\n')
    with raises(ScenarioError, "signals", "'setpoints'", "stage"):
        load_plan(scenario)


def test_a_controller_to_begin_with_has_the_limits_of_its_stage(tmp_path: Path) -> None:
    path, _ = new_stage(tmp_path / "heavy.toml", motor=REAL)
    stage = know_stage(path)
    text = maglev.new_controller(tmp_path / "own.py", stage=str(path)).read_text(encoding="utf-8")
    assert f"self.limit = {stage.design.current_limit}" in text
    assert f"self.observer.time1 = {stage.design.observer_time}" in text
    assert inf > stage.vertical.design.bandwidth > 70.0
