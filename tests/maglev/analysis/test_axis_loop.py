"""The loop of one axis against the whole linear loop, and against the regulator itself."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from facts import raises
from named_controllers import Regulator3DOF, Regulator5DOF

from controller_fmu.status import LINEAR
from maglev.analysis.axis_loop import axis_loop
from maglev.analysis.certificate import certify
from maglev.analysis.region_simulation import Response, Samples, largest_step, respond
from maglev.files.errors import StabilityError
from maglev.linear.linearise import linearise
from maglev.linear.loop import linearise_loop

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

LEVEL = {"y.bias": 0.0, "x.bias": 0.0, "z.bias": 0.0}   # then no current along one axis moves another


@pytest.mark.parametrize("controller", [f"{law}Regulator3DOF" for law in ("", "Linear", "Scheduled", "Interpolated")])
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
    assert (loop.at_rest + loop.lower[0], loop.at_rest + loop.upper[0]) == pytest.approx((-4.0, 4.0))
    assert loop.limits == pytest.approx([4.0 - abs(loop.at_rest)])


def test_antiwindup_that_is_off_has_no_gains() -> None:
    assert axis_loop("3dof", "z", "25 mm").gains == pytest.approx([1.25e-4] * 3)
    assert not axis_loop("3dof", "z", "25 mm", controller_parameters={"antiwindup": False}).gains.any()


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
def test_the_linear_loop_without_antiwindup_is_lost_where_it_was_found_to_be() -> None:
    loop = axis_loop("3dof", "x", "25 mm")
    found = certify(loop, np.zeros(3))
    limit = largest_step(loop, found)
    assert abs(respond(loop, found.gains, 0.98 * limit).position[-1] / limit - 0.98) < 0.5
    assert abs(respond(loop, found.gains, 1.1 * limit).position / limit).max() > 3.0


def test_overshoot_and_settling_of_a_response() -> None:
    time = np.arange(5, dtype=float) * 0.1
    answer = Response(-0.01, time, -np.array([0.0, 0.012, 0.0095, 0.01005, 0.01]), np.zeros(5))
    assert answer.overshoot == pytest.approx(0.2)
    assert answer.settling == pytest.approx(0.2)
    assert Response(0.01, time, 0.005 * np.ones(5), np.zeros(5)).settling == inf
    assert Response(0.01, time, 0.01 * np.ones(5), np.zeros(5)).settling == 0.0


@pytest.mark.parametrize(("axis", "axes", "commands"), [
    ("y", ("y",), [4]), ("roll", ("roll", "y"), [1, 1, 2]), ("x", ("x", "y", "pitch"), [2, 2, 1, 1])])
def test_limits_of_a_platform_that_tilts_move_other_axes(axis: str, axes: tuple[str, ...], commands: list[int]) -> None:
    """All direct currents at once move y alone; those of one motor y and a tilt; a thrust the tilt that it drives."""
    loop = axis_loop("5dof", axis, "25 mm")
    assert (loop.axes, [len(each) for each in loop.commands]) == (axes, commands)
    whole = linearise_loop("Plant5DOF", "Regulator5DOF", {"y": "25 mm"},
                           plant_parameters={"x.bias": 0.0, "z.bias": 0.0}).poles
    for pole in 1.0 + loop.sample_time * np.linalg.eigvals(loop.A):
        assert np.abs(whole - pole).min() < 1e-6   # roll and pitch have the same
    # What the bias takes of the currents at rest is taken from the limits.
    rest = linearise_loop("Plant5DOF", "Regulator5DOF", {"y": "25 mm"}).plant.equilibrium.currents
    assert loop.limits == pytest.approx([4.0 - max(abs(rest[current]) for current in each) for each in loop.commands])


@pytest.mark.few(1)
@pytest.mark.parametrize(("axis", "step"), [("roll", 15e-3), ("x", 40e-3)])
@pytest.mark.usefixtures("slow")
def test_large_steps_are_those_of_the_regulator_itself_where_the_platform_tilts(axis: str, step: float) -> None:
    """Limits and antiwindup of all motors, of the linear law, on the linear plant with all its axes."""
    known = {"C3": 327.5, "C4": 8.48, "C5": 0.007, "y.ripple.amplitude": 0.0}   # so that the controller rests
    free = {"x.bias": 0.0, "z.bias": 0.0, "y.bias": 0.0, **known}
    loop = axis_loop("5dof", axis, "25 mm", controller="LinearRegulator5DOF", plant_parameters=free)
    # The step leads away from level, and takes what holds a tilt from the limits.
    held = step * loop.at_step[[loop.states.index(each[0]) for each in loop.commands]]
    answer = respond(replace(loop, lower=loop.lower - held, upper=loop.upper - held), loop.gains, step)
    plant = linearise("Plant5DOF", {"y": "25 mm"}, hold=2e-4, parameters=free)
    rest = np.array([plant.equilibrium.currents[name.removesuffix("_cmd")] for name in plant.inputs])
    block = Regulator5DOF(LINEAR)
    assert block.start() == 0
    state, places = np.zeros(len(plant.states)), (block.alpha1_place, block.alpha2_place, block.beta1_place,
                                                  block.beta2_place)
    motors = (block.alpha1, block.alpha2, block.beta1, block.beta2)
    limited = False
    block.sample()   # at rest, before the step
    getattr(block, axis).reference = step
    for k in range(6000):
        seen = dict(zip(plant.outputs, plant.C @ state, strict=True))
        block.x.measured, block.z.measured = seen["x.position"], seen["z.position"]
        for name, place in zip(("alpha1", "alpha2", "beta1", "beta2"), places, strict=True):
            place.gap_measured = 0.025 + seen[f"{name}.gap"]
        block.sample()
        assert answer.position[k] == pytest.approx(seen[f"{axis}.position"], abs=2e-6)
        limited = limited or block.saturated
        commands = np.array([each for motor in motors for each in (motor.i_d_cmd, motor.i_q_cmd)]) - rest
        state = plant.A @ state + plant.B @ commands
    assert limited
    assert answer.overshoot > 0.2


def test_limits_that_move_all_axes_are_refused() -> None:
    """A payload off the centre: no two motors carry alike."""
    with raises(StabilityError, "x, y, pitch, roll", "equal motors"):
        axis_loop("5dof", "x", "25 mm", plant_parameters={"payload.mass": 0.3, "payload.x": 0.1, "payload.z": 0.05})
