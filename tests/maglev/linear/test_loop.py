"""Loops of linear models against the one-sample maps of plant and controller blocks, stepped one after the other."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from facts import raises
from linear_blocks import jacobian, measure, plant_state, read_all, read_plant, rest, set_all, smooth_stage, step_both
from named_blocks import named

from maglev.files.errors import LinearModelError
from maglev.linear.linearise import linearise
from maglev.linear.loop import Loop, linearise_loop
from maglev.linear.parameters import block_of, linear_stage

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

CASES = [("Plant2DOF", "Regulator2DOF", {"v": 20e-3}), ("Plant2DOF", "LinearRegulator2DOF", {"v": 20e-3, "h": 11e-3}),
         ("Plant2DOF", "PID2DOF", {"v": 17e-3}), ("Plant3DOF", "Regulator3DOF", {"y": 25e-3, "x": 8e-3, "z": -3e-3}),
         ("Plant3DOF", "Regulator3DOF", {"y": 29e-3}), ("Plant3DOF", "LinearRegulator3DOF", {"y": 25e-3}),
         ("Plant3DOF", "ScheduledRegulator3DOF", {"y": 21e-3, "x": -20e-3}), ("Plant3DOF", "PID3DOF", {"y": 25e-3}),
         ("Plant5DOF", "Regulator5DOF", {"y": 25e-3}), ("Plant5DOF", "PID5DOF", {"y": 23e-3, "roll": 4e-3, "z": -6e-3}),
         ("Plant5DOF", "Regulator5DOF", {"y": 22e-3, "x": 8e-3, "z": -3e-3, "roll": 7e-3, "pitch": -5e-3}),
         ("Plant3DOF", "InterpolatedRegulator3DOF", {"y": 23.3e-3, "z": 7e-3}),
         ("Plant5DOF", "LinearRegulator5DOF", {"y": 24e-3, "x": 5e-3, "roll": -2e-3, "pitch": 3e-3})]
FLEXIBLE = {"Plant3DOF": {"y.mode.frequency": 60.0, "y.mode.mass_share": 0.3, "y.mode.encoder_share": 0.4,
                          "z.mode.frequency": 85.0, "z.mode.damping": 0.03, "z.mode.encoder_share": -0.5},
            "Plant5DOF": {"x.mode.frequency": 70.0, "x.mode.encoder_share": 0.6, "pitch.mode.frequency": 80.0,
                          "pitch.mode.mass_share": 0.25, "pitch.mode.encoder_share": 0.7}}


def sampled_map(plant: str, controller: Any, stage: Any, loop: Loop, state: np.ndarray) -> np.ndarray:
    """State of both blocks after one sample."""
    n = len(loop.plant.states)
    plant_state(plant, stage, state[:n].tolist())
    set_all(controller, loop.controller.states, state[n:].tolist())
    measure(plant, controller, stage)
    step_both(plant, controller, stage)
    return np.array([*read_plant(plant, stage), *read_all(controller, loop.controller.states)])


@pytest.mark.parametrize(("plant", "controller", "at", "modes"), [
    *((*case, None) for case in CASES), ("Plant3DOF", "PID3DOF", {"y": 25e-3, "z": 4e-3}, FLEXIBLE["Plant3DOF"]),
    ("Plant5DOF", "PID5DOF", {"y": 25e-3, "x": 3e-3}, FLEXIBLE["Plant5DOF"]),
    # Where thrusts tilt it, this law spreads currents in a way of its own, which differs by some 20 µA.
    ("Plant5DOF", "InterpolatedRegulator5DOF", {"y": 25.4e-3}, {"y.bias": 0.0, "x.bias": 0.0, "z.bias": 0.0})])
def test_closed_loop_is_that_of_the_blocks(plant: str, controller: str, at: dict[str, float | str],
                                           modes: dict[str, float] | None) -> None:
    """The whole matrix, and the poles: slow ones to 1e-5, those of lag and observers to 1e-4."""
    loop = linearise_loop(plant, controller, at, plant_parameters=modes)
    block, stage = named(block_of(controller, {}), linear_stage(controller)), smooth_stage(plant, True, modes)
    assert block.start() == 0
    state = rest(plant, block, stage, loop)
    assert sampled_map(plant, block, stage, loop, state) == pytest.approx(state, rel=1e-7, abs=1e-9)
    units = {**loop.plant.units, **loop.controller.units}
    steps = np.array([{"m": 1e-7, "m/s": 1e-5, "A": 1e-4, "rad": 1e-7, "rad/s": 1e-5}.get(units[name], 1e-6) for name in
                      (*loop.plant.states, *loop.controller.states)])
    # Of states with units of their own: as far as they move the currents by a tenth of a milliampere.
    gains = np.abs(loop.controller.C).max(axis=0)
    steps[len(loop.plant.states):] = np.where(gains > 0.0, 1e-4 / np.maximum(gains, 1e-12), 1e-7)
    numeric = jacobian(lambda s: sampled_map(plant, block, stage, loop, s), state, steps)
    scale = steps[:, None] / steps[None, :]
    difference = np.abs(loop.closed.A - numeric) / scale
    assert difference.max() < 1e-6 * (np.abs(numeric) / scale).max()
    theirs = np.log(np.linalg.eigvals(numeric).astype(complex)) / block.sample_time
    for rate in loop.rates:
        assert np.abs(theirs - rate).min() < (1e-5 if rate.real > -300.0 else 1e-4) * abs(rate), rate
    assert loop.stable


def test_the_gain_margin_with_a_flexible_mode_is_where_the_running_loop_begins_to_swing() -> None:
    """What is measured of x, times so much: 3 % below the margin a deviation dies out, 3 % above it grows."""
    mode = {"x.mode.frequency": 30.0, "x.mode.mass_share": 0.2, "x.mode.encoder_share": -1.0}
    rigid, loop = (linearise_loop("Plant3DOF", "PID3DOF", {"y": 25e-3}, plant_parameters=each) for each in (None, mode))
    limit = loop.margins("x").gain_up
    assert limit < 0.5 * rigid.margins("x").gain_up, "the mode takes most of the margin"
    ends = []
    for factor in (0.97 * limit, 1.03 * limit):
        block, stage = named(block_of("PID3DOF", {}), linear_stage("PID3DOF")), smooth_stage("Plant3DOF", True, mode)
        assert block.start() == 0
        state = rest("Plant3DOF", block, stage, loop)
        state[1] += 1e-7
        plant_state("Plant3DOF", stage, state[:len(loop.plant.states)].tolist())
        course = []
        for _ in range(3000):
            measure("Plant3DOF", block, stage, "x", (factor - 1.0) * (stage.x.position + stage.x.swing))
            step_both("Plant3DOF", block, stage)
            course.append(abs(stage.x.mode.deflection))
        ends.append(max(course[-200:]) / max(course[400:600]))
    assert ends[0] < 0.9 and ends[1] > 1.1


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
def test_stage_settles_as_the_slowest_pole_says() -> None:
    """3-DOF, after 10 µm off in the gap: once the fast poles have died out, the error is the slowest pair's decay."""
    loop = linearise_loop("Plant3DOF", "Regulator3DOF", {"y": 25e-3})
    block, stage = named(block_of("Regulator3DOF", {}), linear_stage("Regulator3DOF")), smooth_stage("Plant3DOF", True)
    assert block.start() == 0
    state = rest("Plant3DOF", block, stage, loop)
    offset = np.zeros(len(state))
    offset[0] = 1e-5
    linear, errors, ours = offset, [], []
    moved = state + offset
    for _ in range(5000):
        errors.append(moved[0] - state[0])
        ours.append(linear[0])
        moved = sampled_map("Plant3DOF", block, stage, loop, moved)
        linear = loop.closed.A @ linear
    assert np.abs(np.array(errors) - ours).max() < 1e-3 * 1e-5


def test_sampled_fast_without_lag_or_observer_the_published_poles() -> None:
    """With the controller's constants in the plant: what (5.14) is designed for, axis by axis, as polynomials."""
    own = {f"C{k}": value for k, value in zip(range(1, 6), (0.6135, 0.8224, 327.50, 8.48, 0.0070), strict=True)}
    quiet = {f"{axis}.{name}": 0.0 for axis in "yxz" for name in ("bias", "friction.viscous")}
    loop = linearise_loop("Plant3DOF", "Regulator3DOF", {"y": "25 mm"}, amplifier=False,
                          plant_parameters={**own, **quiet, "y.ripple.amplitude": 0.0},
                          controller_parameters={"sample_time": "10 us", "observer.time1": 0.0, "observer.time2": 0.0})
    published: dict[str, list[complex]] = {"y": [-91.3, -4.2 + 6.4j, -4.2 - 6.4j, -2.3 + 2j, -2.3 - 2j],
                                           "x": [-5, -6, -7, -8, -9]}
    for axis, poles in published.items():
        places = [k for k, name in enumerate(loop.closed.states)
                  if axis in (name.split(".")[0], name.split(".")[1]) and "observer" not in name]
        # The observer's position is the last measurement: its pole is at z = 0.
        names = [k for k, name in enumerate(loop.closed.states) if f".{axis}.observer" in f".{name}"]
        block = loop.closed.A[np.ix_(places + names, places + names)]
        z = np.linalg.eigvals(block)
        rates = np.log(z[np.abs(z) > 0.9].astype(complex)) / 10e-6
        assert len(rates) == 5
        assert np.poly(rates).real == pytest.approx(np.poly(poles).real, rel=1e-2)


def test_a_controller_of_ones_own() -> None:
    """A static state feedback on positions alone cannot damp; a loop takes it, opens and closes."""
    plant = linearise("Plant2DOF", {"v": "20 mm"}, hold=0.5e-3)
    template = linearise("PID2DOF", plant.equilibrium).select(("v.measured", "h.measured"), plant.inputs)
    gains = np.array([[-8000.0, 0.0], [0.0, 500.0]])
    mine = replace(template, name="mine", states=(), A=np.zeros((0, 0)), B=np.zeros((0, 2)), C=np.zeros((2, 0)),
                   D=gains)
    loop = Loop(plant, mine)
    np.testing.assert_allclose(loop.closed.A, plant.A + plant.B @ gains @ plant.C, rtol=1e-12)
    assert loop.references == ()
    assert not loop.stable
    with raises(LinearModelError, "stable"):
        loop.margins("v")
    with raises(LinearModelError, "sample time"):
        Loop(plant, replace(mine, sample_time=1e-3))
    with raises(LinearModelError, "'motor.i_q_cmd'", "motor.i_d_cmd"):
        Loop(plant, mine.select(mine.inputs, ("motor.i_d_cmd",)))
    with raises(LinearModelError, "continuous", "sampled"):
        linearise_loop("Plant2DOF", replace(mine, sample_time=None), {"v": "20 mm"})
    with raises(LinearModelError, "parameters"):
        linearise_loop("Plant2DOF", mine, {"v": "20 mm"}, controller_parameters={"v.kp": 1.0})
