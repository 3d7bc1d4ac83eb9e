"""The stages against a tight solution of the same equations, written independently in `reference_stage`."""

import numpy as np
import pytest
from named_stage import Stage2DOF, Stage3DOF
from reference_stage import reference_2dof
from stage_cases import IMPACTS, SMOOTH, Case, differences, equilibrium_current, phases, run_block

pytestmark = pytest.mark.usefixtures("slow")

# What depends on the gap does so most where it is smallest and largest.
BETWEEN = tuple(f"{stage}-DOF near {gap} mm" for stage, gap in ((2, 18), (2, 21), (3, 20), (3, 23), (3, 26)))


@pytest.mark.few(2)
@pytest.mark.parametrize("case", [pytest.param(case, id=case.name, marks=pytest.mark.thorough)
                                  if case.name in BETWEEN else pytest.param(case, id=case.name) for case in SMOOTH])
def test_smooth_motion(case: Case) -> None:
    position, velocity = differences(case)
    assert position < 1e-7
    assert velocity < 1e-5


@pytest.mark.few(2)
@pytest.mark.parametrize("case", IMPACTS, ids=lambda case: case.name)
def test_after_an_end_stop(case: Case) -> None:
    position, _ = differences(case)
    assert position < 1e-5


def test_reference_is_accurate_itself() -> None:
    """A looser tolerance moves the reference by far less than what it is compared with."""
    case = SMOOTH[5]
    dt, steps = 0.5e-3, 100
    _, given = run_block(case.stage, case.start, case.commands, dt, steps)
    tight, loose = (reference_2dof().solve(case.start, lambda k, _: given[k], dt, steps, rtol)
                    for rtol in (1e-11, 1e-9))
    assert np.abs(tight - loose)[:, :6].max() < 1e-8


@pytest.mark.parametrize(("description", "gap"),
                         [(2, 0.017), (2, 0.020), (2, 0.023), (3, 0.021), (3, 0.024), (3, 0.027)])
def test_communication_steps_agree(description: int, gap: float) -> None:
    """Constant commands, no stop: the communication step is no matter, 1e-8 m over 0.1 s."""
    held = np.array([phases(equilibrium_current(description, gap) + 0.15, 0.7, 0.0)] * (description - 1))
    start = (gap, *(0.0,) * (description - 1))
    ends = []
    for dt in (0.1e-3, 0.2e-3, 0.5e-3, 1e-3):
        rows, _ = run_block(description, start, lambda k, x: held, dt, round(0.1 / dt))
        ends.append(rows[::round(1e-3 / dt), :, 0])
    moved = np.ptp(ends[0], axis=0)
    assert (moved > 1e-4).all()
    assert ends[0][:, 0].min() > 8e-3 and ends[0][:, 0].max() < (28e-3 if description == 2 else 32e-3), "no stop"
    assert max(np.abs(end - ends[0]).max() for end in ends[1:]) < 1e-8


def frictionless(stage: Stage2DOF | Stage3DOF, *names: str) -> None:
    """Switch guides and biases off."""
    for name in names:
        axis = getattr(stage, name)
        axis.friction.coulomb = axis.friction.viscous = axis.bias = axis.ripple.amplitude = 0.0


@pytest.mark.parametrize(("description", "axis"), [(2, "h"), (3, "x"), (3, "z")])
def test_ripple_is_a_conservative_force_over_the_slots(description: int, axis: str) -> None:
    """v²/2 is the work of r sin(2π d/t1 + 0.5) from the start on, over two slot pitches and more."""
    stage = Stage2DOF() if description == 2 else Stage3DOF()
    names = ("v", "h") if description == 2 else ("y", "x", "z")
    frictionless(stage, *names)
    for name in names:
        getattr(stage, name).locked = name != axis
    moved = getattr(stage, axis)
    moved.ripple.amplitude, moved.position_start, moved.force = 0.2, -0.02, 0.8 * moved.mass
    assert stage.start() == 0
    for k in range(200):
        assert stage.step(k * 2e-3, 2e-3) == 0
        work = 0.8 * (moved.position + 0.02) - 0.2 * 19.05e-3 / (2 * np.pi) * (
            np.cos(2 * np.pi * moved.position / 19.05e-3 + 0.5) - np.cos(2 * np.pi * -0.02 / 19.05e-3 + 0.5))
        assert moved.velocity**2 / 2 == pytest.approx(work, rel=1e-9, abs=1e-12)
    assert moved.position > 0.02


def test_free_fall_is_a_parabola() -> None:
    stage = Stage3DOF()
    frictionless(stage, "y", "x", "z")
    stage.C3 = 0.0   # no attraction; without current the motors do nothing else
    stage.y.position_start = 0.019
    stage.start()
    for k in range(200):
        stage.step(k * 2e-4, 2e-4)
    assert stage.y.position == pytest.approx(0.019 + 0.5 * 9.81 * 0.04**2, abs=1e-14)
    assert stage.y.velocity == pytest.approx(9.81 * 0.04, abs=1e-13)
    assert stage.x.position == stage.z.position == 0.0


def test_forces_add_their_acceleration() -> None:
    stage = Stage3DOF()
    frictionless(stage, "y", "x", "z")
    stage.x.force, stage.z.force = 10.6, -4.3
    stage.start()
    for k in range(100):
        stage.step(k * 2e-4, 2e-4)
    assert stage.x.velocity == pytest.approx(1.0 * 0.02, rel=1e-12)
    assert stage.z.velocity == pytest.approx(-0.5 * 0.02, rel=1e-12)


def test_horizontal_motion_mirrors() -> None:
    """Left and right are the same except for the sign, with the biases off and the attraction symmetric."""
    ends = []
    for sign in (1, -1):
        stage = Stage2DOF()
        stage.h.bias = 0.0
        stage.h.position_start = sign * 0.01
        stage.start()
        for k in range(200):
            # The motor repeats after two pole pitches, not at a mirror image: drive it by force.
            stage.h.force = sign * 3.0 * np.sin(0.05 * k)
            stage.step(k * 5e-4, 5e-4)
        ends.append((stage.v.position, sign * stage.h.position, sign * stage.h.velocity))
    assert ends[0] == pytest.approx(ends[1], rel=1e-13)
    assert abs(ends[0][1] - 0.01) > 1e-4


@pytest.mark.parametrize(("description", "neutral"), [(2, 19.45e-3), (3, 22.69e-3)])
def test_sign_of_the_direct_current(description: int, neutral: float) -> None:
    """Positive at small gaps, where the magnets pull more than the weight; negative at large ones.

    The gap without current is that of the identified constants to 0.3 mm: the plant carries others.
    """
    gaps = np.arange(16e-3, 26.5e-3, 1e-3)   # the 2-DOF motor cannot hold the mover much lower
    currents = np.array([equilibrium_current(description, gap) for gap in gaps])
    assert (currents[gaps < neutral - 0.5e-3] > 0).all()
    assert (currents[gaps > neutral + 0.5e-3] < 0).all()
    for gap in (neutral - 3e-3, neutral + 3e-3):
        stage, motors = (Stage2DOF(), ("motor",)) if description == 2 else (Stage3DOF(), ("alpha", "beta"))
        axis = stage.v if isinstance(stage, Stage2DOF) else stage.y
        frictionless(stage, "v" if description == 2 else "y")
        stage.attraction_modulation = 0.0
        axis.position_start = gap
        stage.start()
        for name in motors:
            motor = getattr(stage, name)
            held = phases(equilibrium_current(description, gap), 0.0, 0.0)
            motor.i_a_cmd, motor.i_b_cmd, motor.i_c_cmd = (float(i) for i in held)
        stage.step(0.0, 1e-3)
        assert abs(axis.velocity) < 1e-6, "the command holds the mover"
        assert np.sign(getattr(stage, motors[0]).i_d) == np.sign(neutral - gap)
