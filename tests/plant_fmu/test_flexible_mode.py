"""A flexible mode and a floor that shakes, against two masses on a spring, in a frame that does not shake."""

import math

import numpy as np
import pytest
from named_stage import Stage2DOF, Stage3DOF, Stage5DOF
from scipy.integrate import solve_ivp

from maglev.descriptions.packaged import PACKAGED_STAGES
from plant_fmu.axis import Axis

DT = 0.2e-3
MASS, SHARE, FREQUENCY, DAMPING = 4.0, 0.3, 60.0, 0.02
OMEGA = 2.0 * math.pi * FREQUENCY


def free_axis(frequency: float = FREQUENCY, damping: float = DAMPING, share: float = SHARE) -> Axis:
    """A mover on which nothing acts."""
    axis = Axis(MASS, 0.0, 0.0, 0.0, 0.0, -10.0, 10.0, 0.0)
    axis.mode.frequency, axis.mode.damping, axis.mode.mass_share = frequency, damping, share
    axis.mode.encoder_share = 0.7
    axis.start(1, 0)
    return axis


def step(axis: Axis, dt: float = DT) -> None:
    """One Runge–Kutta step under the inputs of the axis."""
    axis.begin()
    for weight, ahead in ((dt / 6.0, dt / 2.0), (dt / 3.0, dt / 2.0), (dt / 3.0, dt), (dt / 6.0, 0.0)):
        axis.add_slope(0.0, weight, ahead)
    assert axis.finish()


def test_two_masses_on_a_shaking_floor() -> None:
    """Places of both masses in a frame at rest: spring and damper between them, the guide between rest and floor."""
    axis, floor, force, viscous = free_axis(), 0.8, 6.0, 15.0
    axis.friction.viscous = viscous
    axis.force, axis.floor_acceleration = force, floor
    rest, swinging = (1.0 - SHARE) * MASS, SHARE * MASS
    reduced = rest * swinging / MASS
    spring, damper = reduced * OMEGA**2, 2.0 * DAMPING * OMEGA * reduced

    def rates(t: float, s: np.ndarray) -> list[float]:
        x, u, v, w = s
        between = spring * (u - x) + damper * (w - v)
        return [v, w, (force + between - viscous * (v - floor * t)) / rest, -between / swinging]

    times = np.arange(1, 601) * DT
    x, u, _, _ = solve_ivp(rates, (0.0, times[-1]), np.zeros(4), t_eval=times, rtol=1e-11, atol=1e-14).y
    ground = floor * times**2 / 2.0
    found = []
    for _ in times:
        step(axis)
        found.append((axis.position, axis.mode.deflection, axis.swing))
    position, deflection, swing = np.array(found).T
    assert np.abs(position - (x - ground)).max() < 1e-10
    assert np.abs(deflection - (u - x)).max() < 1e-5 * np.abs(u - x).max()
    np.testing.assert_array_equal(swing, 0.7 * deflection)


def test_a_mode_that_rings_keeps_momentum_and_energy() -> None:
    axis = free_axis(damping=0.0)
    axis.mode.deflection = 1e-4
    rest, swinging = (1.0 - SHARE) * MASS, SHARE * MASS
    energies = []
    for _ in range(2000):
        step(axis)
        v, w = axis.velocity, axis.velocity + axis.mode.rate
        energies.append(0.5 * rest * v**2 + 0.5 * swinging * w**2
                        + 0.5 * rest * swinging / MASS * (OMEGA * axis.mode.deflection)**2)
        assert abs(rest * v + swinging * w) < 1e-14 * swinging * OMEGA * 1e-4 * 1e3
        # The centre of mass stays where it was; the two masses swing about it the way the mode says.
        assert abs(axis.position + SHARE * (axis.mode.deflection - 1e-4)) < 1e-14
    assert energies[-1] == pytest.approx(energies[0], rel=1e-3)
    assert energies[0] == pytest.approx(0.5 * rest * swinging / MASS * (OMEGA * 1e-4)**2, rel=1e-6)


@pytest.mark.parametrize("damping", [0.0, 0.03])
def test_the_fastest_mode_that_is_taken_rings_as_the_page_says(damping: float) -> None:
    """At a tenth of a cycle a step 0.14 % slow and 0.0007 more damping; at half a sixteenth and a thirtieth of it."""
    for cycles, slow, damped in ((0.1, 1.4e-3, 7.0e-4), (0.05, 0.9e-4, 2.3e-5)):
        axis = free_axis(frequency=cycles / DT, damping=damping)
        axis.mode.deflection = 1e-4
        course = []
        for _ in range(400):
            step(axis)
            course.append(axis.mode.deflection)
        # r[k + 2] = 2 ρ cos φ r[k + 1] − ρ² r[k] of one oscillation
        sampled = np.array(course)
        a, b = np.linalg.lstsq(np.column_stack([sampled[1:-1], sampled[:-2]]), sampled[2:], rcond=None)[0]
        rate = np.log(complex(a / 2.0, math.sqrt(-b - a * a / 4.0))) / DT
        omega = 2.0 * math.pi * cycles / DT
        assert 0.0 <= 1.0 - abs(rate) / omega < slow
        assert 0.0 <= -rate.real / abs(rate) - damping < damped


def test_held_in_place_it_swings_more_slowly() -> None:
    """Antiresonance: a force at ω √(1 − μ) moves the rest only as far as the damper has it, 2 ζ √(1 − μ)/μ of rigid."""
    held = OMEGA * math.sqrt(1.0 - SHARE)
    axis = free_axis(damping=0.05)
    moved = []
    for k in range(5_000):
        axis.force = math.sin(held * (k + 0.5) * DT)
        step(axis)
        moved.append(axis.velocity)
    rest = np.array(moved[3000:]) - np.mean(moved[3000:])
    damped = 2.0 * 0.05 * math.sqrt(1.0 - SHARE)
    assert np.abs(rest).max() == pytest.approx(damped / math.hypot(SHARE, damped) / (MASS * held), rel=0.01)


@pytest.mark.parametrize("stage_of", [Stage2DOF, Stage3DOF, Stage5DOF])
def test_off_nothing_of_it_matters(stage_of: type) -> None:
    """Bit for bit, whatever the other parameters of the modes are; a shaking floor moves every stage at once."""
    name = next(name for name, description in PACKAGED_STAGES.items() if stage_of.__name__.endswith(description.suffix))
    courses = []
    for damping, share, shaking in ((0.01, 0.1, 0.0), (0.5, 0.6, 0.0), (0.01, 0.1, 0.3)):
        stage = stage_of()
        for axis in PACKAGED_STAGES[name].axes:
            part = getattr(stage, axis.name)
            part.mode.damping, part.mode.mass_share, part.mode.encoder_share = damping, share, 3.0
            part.floor_acceleration = 0.0 if axis.rotation else shaking
        assert stage.start() == 0
        for k in range(40):
            assert stage.step(k * DT, DT) == 0
        courses.append([getattr(stage, axis).position for axis in PACKAGED_STAGES[name].axis_names])
    assert courses[0] == courses[1]
    for axis, quiet, shaken in zip(PACKAGED_STAGES[name].axes, courses[0], courses[2], strict=True):
        expected = 0.0 if axis.rotation else -0.3 * (40 * DT)**2 / 2.0
        assert shaken - quiet == pytest.approx(expected, rel=0.05, abs=1e-8)


def test_encoders_at_the_motors_see_the_modes_of_the_platform() -> None:
    stage = Stage5DOF()
    stage.encoder.resolution = 0.0
    assert stage.start() == 0
    stage.y.swing, stage.roll.swing, stage.pitch.swing, stage.x.swing = 3e-6, 2e-5, -1e-5, 5e-6
    stage.measure()
    assert stage.x.encoder == stage.x.position + 5e-6
    for motor in PACKAGED_STAGES["5dof"].motors:
        mount = getattr(stage, f"{motor.name}_mount")
        assert mount.gap_encoder - mount.gap == pytest.approx(3e-6 - motor.z * 2e-5 - motor.x * 1e-5, rel=1e-9)
