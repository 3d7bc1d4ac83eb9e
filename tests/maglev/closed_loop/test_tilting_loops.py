"""Closed loops of a platform that tilts: they run, and hold the tilts as well as their encoders see them."""

from pathlib import Path

import numpy as np
import pytest

from maglev.cosim.master import FmuSetup, Master, Recording

STEP = 2e-3   # s, ten samples
AXES = ("y", "x", "z", "roll", "pitch")
START = dict.fromkeys(AXES, 0.0) | {"y": 25e-3}
COUNT = {"y": 10e-6, "x": 10e-6, "z": 10e-6, "roll": 50e-6, "pitch": 50e-6}   # of the encoders; at a motor over 0.2 m


def simulate(folder: Path, loop: str, targets: dict[str, float], start: dict[str, float]) -> Recording:
    """Steps of references at 1 s."""
    ends = START | targets
    steps = {f"loop.{axis}.reference": [START[axis] if k * STEP < 1.0 else ends[axis] for k in range(3001)]
             for axis in AXES}
    with Master([FmuSetup("loop", folder / f"{loop}.fmu", start)], [], STEP) as master:
        return master.run(6.0, steps)


def assert_settled(recording: Recording, targets: dict[str, float]) -> None:
    """All axes are within an encoder count of where they are to be, in truth."""
    for axis, target in (START | targets).items():
        away = np.abs(recording.columns[f"loop.plant.{axis}.position"][-200:] - target).max()
        assert away < 1.1 * COUNT[axis], axis


@pytest.mark.parametrize("loop", ["ClosedLoop5DOF", "ClosedLoopLinear5DOF", "ClosedLoopPID5DOF"])
@pytest.mark.parametrize("targets", [{"y": 23e-3}, {"roll": 10e-3}, {"roll": -10e-3}, {"pitch": 10e-3},
                                     {"pitch": -10e-3}, {"x": 10e-3}, {"z": 10e-3},
                                     {"y": 24e-3, "x": -5e-3, "z": 5e-3, "roll": 4e-3, "pitch": -4e-3}], ids=str)
def test_steps_settle_to_a_count_of_the_encoders(fastest_fmus: Path, loop: str, targets: dict[str, float]) -> None:
    recording = simulate(fastest_fmus, loop, targets, {})
    assert_settled(recording, targets)
    assert not recording.columns["loop.plant.at_stop"].any()
    assert not recording.columns["loop.controller.tripped"].any()


def test_equal_thrusts_turn_the_platform_about_no_vertical_axis(fastest_fmus: Path) -> None:
    """What a model with other constants leaves over is little of what the thrusts could do at 0.2 m."""
    recording = simulate(fastest_fmus, "ClosedLoop5DOF", {"x": 10e-3, "roll": 5e-3, "pitch": 5e-3}, {})
    moments = np.abs(recording.columns["loop.plant.yaw_moment"])
    thrust = 10.6 * 0.6135 * np.abs(recording.columns["loop.plant.alpha1.i_q"]).max()
    assert thrust > 5.0
    assert moments.max() < 0.02 * 0.4 * thrust


def test_a_payload_off_the_centre_is_held(fastest_fmus: Path) -> None:
    """0.5 kg at (100, 50) mm from the start on: the platform returns to where it was."""
    recording = simulate(fastest_fmus, "ClosedLoop5DOF", {}, {"plant.payload.mass": 0.5, "plant.payload.x": 0.1,
                                                         "plant.payload.z": 0.05})
    assert_settled(recording, {})
    largest = max(np.abs(recording.columns[f"loop.plant.{axis}.position"]).max() for axis in ("roll", "pitch"))
    assert 0.2e-3 < largest < 3e-3
