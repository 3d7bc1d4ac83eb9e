"""The loop of one axis against the whole linear loop, and against the regulator itself."""

from math import inf

import numpy as np
import pytest

from controller_fmu.regulator_3dof import Regulator3DOF
from maglev.errors import StabilityError
from maglev.linear.linearise import linearise
from maglev.linear.loop import linearise_loop
from maglev.stability.axis_loop import axis_loop
from maglev.stability.certificate import certify
from maglev.stability.simulation import Response, Samples, largest_step, respond

LEVEL = {"y.bias": 0.0, "x.bias": 0.0, "z.bias": 0.0}   # then no current along one axis moves another


@pytest.mark.parametrize("controller", ["Regulator3DOF", "LinearRegulator3DOF", "ScheduledRegulator3DOF"])
def test_poles_are_those_of_the_whole_loop(controller: str) -> None:
    whole = linearise_loop("Plant3DOF", controller, {"y": "25 mm"}, plant_parameters=LEVEL).poles
    parts = [1.0 + loop.sample_time * np.linalg.eigvals(loop.A) for loop in
             (axis_loop("3dof", axis, "25 mm", controller=controller, plant_parameters=LEVEL) for axis in "yxz")]
    # Both motors have the same direct current: their difference is a mode of the plant alone.
    found = np.concatenate(parts)
    assert len(found) == len(whole) - 1
    for pole in found:
        assert np.abs(whole - pole).min() < 1e-7


@pytest.mark.parametrize("axis", ["y", "x"])
def test_a_small_step_is_that_of_the_whole_loop(axis: str) -> None:
    closed = linearise_loop("Plant3DOF", "Regulator3DOF", {"y": "25 mm"}, plant_parameters=LEVEL).closed
    state, given = np.zeros(len(closed.states)), np.zeros(len(closed.inputs))
    given[closed.index("input", f"{axis}.reference")] = 1e-5
    answer = respond(axis_loop("3dof", axis, "25 mm", plant_parameters=LEVEL), np.zeros(3), 1e-5)
    place = closed.index("state", f"{axis}.position")
    for k in range(5000):
        assert answer.position[k] == pytest.approx(state[place], abs=1e-10)
        state = closed.A @ state + closed.B @ given


def test_large_steps_are_those_of_the_regulator_itself() -> None:
    """Limit and antiwindup of the block, with 30 mm to go, on a linear axis x at a frozen gap."""
    dt, step = 2e-4, 30e-3
    plant = linearise("Plant3DOF", {"y": "25 mm"}, hold=dt, parameters=LEVEL)
    names = ("x.position", "x.velocity", "alpha.i_q")
    rows = [plant.index("state", name) for name in names]
    a, b = plant.A[np.ix_(rows, rows)], plant.B[rows, plant.index("input", "alpha.i_q_cmd")]
    block = Regulator3DOF()
    assert block.start() == 0
    state = np.zeros(3)
    loop = axis_loop("3dof", "x", "25 mm", plant_parameters=LEVEL)
    answer = respond(loop, loop.gains, step)
    assert answer.command.min() == -4.0 and answer.command.max() == 4.0
    block.sample()   # at rest, before the step
    block.x.reference = step
    for k in range(10000):
        block.x.measured = float(state[0])
        block.sample()
        assert answer.position[k] == pytest.approx(state[0], abs=1e-8)
        assert answer.command[k] == pytest.approx(block.alpha.i_q_cmd, abs=1e-5)
        state = a @ state + b * block.alpha.i_q_cmd
    assert answer.overshoot > 0.3


def test_a_moving_observer_has_seen_it_coming() -> None:
    """Passing the reference at 1 m/s, position and low-passed position go on side by side."""
    loop = axis_loop("3dof", "x", "25 mm", controller_parameters={"current_limit": 1e3})
    places = [loop.states.index(name) for name in ("x.position", "x.observer.position", "x.observer.velocity")]
    state = loop.in_motion[:, None]
    after, _ = Samples(loop, np.zeros(3)).after(state)
    moved = (after - state)[places, 0]
    assert moved[1] == pytest.approx(loop.sample_time, rel=1e-9)
    assert moved[2] == pytest.approx(0.0, abs=1e-9)


def test_the_command_at_rest_takes_from_the_limit() -> None:
    loop = axis_loop("3dof", "y", "25 mm")
    assert loop.at_rest == pytest.approx(linearise("Plant3DOF", {"y": "25 mm"}).equilibrium.currents["alpha.i_d"])
    assert (loop.at_rest + loop.lower, loop.at_rest + loop.upper) == pytest.approx((-4.0, 4.0))
    assert loop.limit == pytest.approx(4.0 - abs(loop.at_rest))


def test_antiwindup_that_is_off_has_no_gains() -> None:
    assert axis_loop("3dof", "z", "25 mm").gains == pytest.approx([1.25e-4] * 3)
    assert not axis_loop("3dof", "z", "25 mm", controller_parameters={"antiwindup": False}).gains.any()


def test_the_linear_loop_without_antiwindup_is_lost_where_it_was_found_to_be() -> None:
    loop = axis_loop("3dof", "x", "25 mm")
    found = certify(loop, np.zeros(3))
    limit = largest_step(loop, found)
    assert abs(respond(loop, found.gains, 0.98 * limit).position[-1] / limit - 0.98) < 0.5
    assert abs(respond(loop, found.gains, 1.1 * limit).position / limit).max() > 3.0


def test_overshoot_and_settling_of_a_response() -> None:
    time = np.arange(5) * 0.1
    answer = Response(-0.01, time, -np.array([0.0, 0.012, 0.0095, 0.01005, 0.01]), np.zeros(5))
    assert answer.overshoot == pytest.approx(0.2)
    assert answer.settling == pytest.approx(0.3)
    assert Response(0.01, time, 0.005 * np.ones(5), np.zeros(5)).settling == inf
    assert Response(0.01, time, 0.01 * np.ones(5), np.zeros(5)).settling == 0.0


@pytest.mark.parametrize("axis", ["x", "roll"])
def test_a_platform_that_tilts_is_refused(axis: str) -> None:
    with pytest.raises(StabilityError, match="5dof: its platform tilts, .* motors come to their limits one by one"):
        axis_loop("5dof", axis, "25 mm")
