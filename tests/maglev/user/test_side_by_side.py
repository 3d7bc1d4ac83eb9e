"""Two motors side by side under one horizontal axis, which also tilt the platform about it: v, h, roll."""

from math import pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from described_stages import written
from facts import raises
from named_blocks import named_block
from reference_pair import ReferenceMotor, lagrangian_motion

import maglev
from maglev.descriptions.own_fmus import definition
from maglev.files.errors import StageError
from maglev.linear.loop import linearise_loop
from maglev.runs.starts import following
from maglev.user.adoption import know_stage
from maglev.user.consequences import place_at_gap
from maglev.user.scenario_loop import setpoints
from pmlsm.gap_functions import gap_functions
from pmlsm.stage_description import StageDescription

pytestmark = pytest.mark.usefixtures("slow")

LIKE = "side-by-side"
# Unlike in all that the equations could mix up: places, height of the magnets, payload, masses.
UNEVEN = {"z = -0.15": "z = -0.11", "z = 0.15": "z = 0.17", "height = 0.0 ": "height = -0.04 ",
          "mass = 0.196": "mass = 0.23"}
PAYLOAD, OFFSET = 0.4, 0.05   # kg, m


def thesis_motor(stage: StageDescription, z: float) -> ReferenceMotor:
    """A motor by the stage's constants."""
    mass, travelling, _ = (axis.mass for axis in stage.axes)
    of, geometry = stage.plant, stage.motor()

    def forces(gap: float, along: float, i_d: float, i_q: float) -> tuple[float, float]:
        f1, f2, f3, f4 = gap_functions(geometry, gap)
        pull = of.attraction * f2 * (1.0 - stage.modulation * sin(pi * along / geometry.slot_pitch)**2)
        return (mass * (of.coils * f3 * i_d - of.iron * f4 * (i_d**2 + i_q**2) - pull),
                -travelling * of.thrust["h"] * f1 * i_q)

    return ReferenceMotor(z, geometry.pole_pitch, forces)


def test_it_moves_by_its_equations(tmp_path: Path) -> None:
    """The plant's block, without friction, bias and lag, against an integration of its own."""
    stage = know_stage(written(tmp_path / "pair.toml", LIKE, UNEVEN))
    plant: Any = named_block("PlantPair")
    start = np.array([0.0203, 1.5e-3, 4e-3])
    plant.payload.mass, plant.payload.z, plant.encoder.resolution = PAYLOAD, OFFSET, 0.0
    for axis, position in zip(stage.axis_names, start.tolist(), strict=True):
        of = getattr(plant, axis)
        of.bias = of.friction.coulomb = of.friction.viscous = of.ripple.amplitude = 0.0
        of.position_start = position
    currents = np.array([[1.0, -0.3, -0.7], [-0.4, 0.9, -0.5]])
    for motor, phases in zip(("left", "right"), currents.tolist(), strict=True):
        supply = getattr(plant, motor)
        supply.amplifier.lag = 0.0
        supply.i_a_cmd, supply.i_b_cmd, supply.i_c_cmd = phases
    assert plant.start() == 0
    times = 1e-3 * np.arange(31)
    rows = [start]
    for k in range(30):
        assert plant.step(1e-3 * k, 1e-3) == 0
        rows.append(np.array([getattr(plant, axis).position for axis in stage.axis_names]))
    expected = lagrangian_motion([axis.mass for axis in stage.axes], stage.height, (PAYLOAD, OFFSET),
                                 [thesis_motor(stage, motor.z) for motor in stage.motors], start, currents, times)
    assert (np.ptp(expected, axis=0) > 1.5e-4).all()   # it goes somewhere along all of them
    assert np.abs(np.array(rows) - expected).max(axis=0) == pytest.approx(np.zeros(3), abs=2e-9)


@pytest.mark.few(1)
@pytest.mark.parametrize("law", ["", "Linear", "PID"])
def test_it_runs(tmp_path: Path, law: str) -> None:
    stage = know_stage(written(tmp_path / "pair.toml", LIKE, UNEVEN))
    loop: Any = named_block(f"ClosedLoop{law}Pair")
    assert loop.start() == 0
    for k in range(3):
        for axis, values in setpoints(stage).items():
            getattr(loop.controller, axis).reference = 1e-3 * values[k]
        for _ in range(60):
            assert loop.step(0.0, 1e-2) == 0
            assert not loop.plant.at_stop
    for axis, values in setpoints(stage).items():
        assert getattr(loop.plant, axis).position == pytest.approx(1e-3 * values[2], abs=3e-5)
    left, right = loop.plant.left_mount, loop.plant.right_mount
    tilt = loop.plant.roll.position
    assert abs(tilt) > 4e-4
    assert left.gap - right.gap == pytest.approx((0.11 + 0.17) * tilt)
    assert left.thrust == pytest.approx(right.thrust, rel=0.02, abs=0.02)   # no yaw by the gaps


def test_it_is_held_level_at_the_ends_wherever_it_begins(tmp_path: Path) -> None:
    """A tilt at the start, which the stops leave no room for at the ends of travel, is none of theirs."""
    tilted = written(tmp_path / "tilted.toml", LIKE, {"start = 0.0               # rad": "start = 2e-3  # rad",
                                                      "# poles =": "poles =", "# observer_time": "observer_time"})
    assert set(place_at_gap(know_stage(tilted), 0.0279).margins) == {"v", "h", "roll"}


@pytest.mark.thorough
def test_tools_take_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run, margins, a controller to begin with, a model that follows the plant, an environment."""
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "pair.toml", LIKE, UNEVEN)
    (tmp_path / "short.toml").write_text('extends = "pair-setpoints.toml"\nname = "short"\nstop_time = "1.2 s"\n')
    maglev.new_controller("law.py", stage="pair.toml")
    for controller in (None, "law.py"):
        run = maglev.run("short.toml", kind="python", controller=controller)
        assert not run["plant.at_stop"].any()
        assert run.plan.axes["roll"].rotation
        assert abs(run["plant.roll.position"] - run["controller.roll.reference"])[-1] < 1e-4
    found = maglev.stage("pair.toml")
    assert set(found.places[0].margins) == {"v", "h", "roll"}
    loop = linearise_loop("PlantPair", "RegulatorPair", {"v": 0.02, "roll": 2e-3})
    assert loop.stable and loop.margins("left.gap_measured").disk > 0.0
    own = {"controller.C1": 7.0}
    stage = know_stage("pair.toml")
    blocks = {name: definition(f"{kind}Pair") for name, kind in (("plant", "Plant"), ("controller", "Regulator"))}
    start = {name: {v.name: 1.0 for v in of.variables} for name, of in blocks.items()}
    assert following(stage, start["plant"].get, start["controller"].get, own) is not None
    import gymnasium

    environment = gymnasium.make("maglev.gym:maglev/Stage-v0", stage="pair.toml")
    observation, _ = environment.reset(seed=1)
    assert observation[:3] == pytest.approx([0.0, 0.02, 0.02], abs=1e-3)   # h, and the gaps at the motors
    environment.close()


@pytest.mark.parametrize(("changes", "facts"), [
    ({"z = -0.15": "x = 0.1\nz = -0.15"}, ["motors.left.x", "0.1 m", "0"]),
    ({"z = -0.15": "z = 0.15"}, ["motors", "0.15 m"]), ({"rotation = true ": "rotation = false "}, ["motor_stop"]),
    ({"sharing = 1 ": "sharing = 2 "}, ["sharing", "2", "1"])])
def test_refuses_an_impossible_stage(tmp_path: Path, changes: dict[str, str], facts: list[str]) -> None:
    from maglev.user.reading import read_own

    with raises(StageError, tmp_path / "pair.toml", *facts):
        read_own(written(tmp_path / "pair.toml", LIKE, changes))
