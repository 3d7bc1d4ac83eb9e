"""Certified ellipsoids against what is known, against simulation, and against their own definition."""

import numpy as np
import pytest
from limited_loops import THESIS, first_order, five_states
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from maglev.analysis.axis_loop import AxisLoop, axis_loop
from maglev.analysis.certificate import Certificate, Inequalities, Scaled, certify, decrease_of, synthesise
from maglev.analysis.region_simulation import comes_back, largest_step

pytestmark = pytest.mark.usefixtures("slow")

NONE = np.zeros(3)


@pytest.mark.parametrize("sample_time", [0.0, 0.01])
def test_first_order_region_is_known(sample_time: float) -> None:
    """Of x' = x + sat(−3 x) with a limit of 0.2 it is |x| < 0.2: there the limit just balances the pole."""
    assert 0.99 * 0.2 < certify(first_order(1.0, 3.0, 0.2, sample_time), NONE).step < 0.2


def test_first_order_region_of_another_limit_and_pole() -> None:
    assert 0.1 * 0.99 < certify(first_order(5.0, 6.0, 0.5), NONE).step < 0.1


@pytest.mark.parametrize(("gains", "step", "sampled"), [(THESIS, 17.32e-3, 17.37e-3), (NONE, 14.49e-3, 14.41e-3)])
def test_five_states_of_the_thesis(gains: NDArray[np.float64], step: float, sampled: float) -> None:
    """Optima of the thesis's loop and of the one that runs, with the same limit: as the page says."""
    loop = axis_loop("3dof", "x", "25 mm")
    assert loop.limits == pytest.approx([3.885], abs=0.5e-3)
    for each, optimum in ((five_states(loop.limits[0]), step), (loop, sampled)):
        inequalities = Inequalities(Scaled(each), 0.0, gains)
        assert inequalities.largest_step() * Scaled.STEP == pytest.approx(optimum, abs=0.01e-3)
        # A certificate keeps up to a hundredth away from it.
        assert 0.985 * optimum < certify(each, gains).step < 1.005 * optimum


@pytest.fixture(scope="module", params=["thesis", "none", "synthesised"])
def continuous(request: pytest.FixtureRequest) -> tuple[AxisLoop, Certificate]:
    loop = five_states()
    gains = {"thesis": THESIS, "none": NONE}
    return loop, certify(loop, gains[request.param] if request.param in gains else synthesise(loop, 0.5))


def on_the_border(found: Certificate, count: int) -> NDArray[np.float64]:
    """Random states with V = 1, shape (n, count)."""
    directions = np.random.default_rng(5).normal(size=(len(found.P), count))
    states: NDArray[np.float64] = np.linalg.solve(np.linalg.cholesky(found.P).T, directions / np.linalg.norm(
        directions, axis=0))
    return states


def test_states_on_the_border_come_back(continuous: tuple[AxisLoop, Certificate]) -> None:
    """By an integrator that knows nothing of the inequalities."""
    loop, found = continuous

    def slope(_: float, state: NDArray[np.float64]) -> NDArray[np.float64]:
        wanted = loop.K @ state
        cut = wanted - np.minimum(np.maximum(wanted, loop.lower), loop.upper)
        change: NDArray[np.float64] = loop.A @ state - (loop.B[:, 0] + loop.E @ found.gains) * cut
        return change

    starts = np.column_stack([on_the_border(found, 6), found.step * loop.at_step])
    for start in starts.T:
        run = solve_ivp(slope, (0.0, 12.0), start, method="LSODA", rtol=1e-8, atol=1e-12, max_step=0.02)
        levels = found.level(run.y)
        assert levels[0] == pytest.approx(1.0, rel=1e-6)
        assert levels.max() <= 1.0 + 1e-6
        assert levels[-1] < 1e-4


def test_eigenvalues_of_the_inequalities(continuous: tuple[AxisLoop, Certificate]) -> None:
    """[AᵀP + PA, −P B + T Gᵀ; ·, −2 T] is negative definite, and the sector condition holds in the ellipsoid."""
    loop, found = continuous
    p, t, g = found.P, found.T[0], found.G[0]
    corner = (t * g - p @ (loop.B[:, 0] + loop.E @ found.gains))[:, None]
    matrix = np.block([[loop.A.T @ p + p @ loop.A, corner], [corner.T, np.array([[-2.0 * t]])]])
    size = np.sqrt(np.diag(np.block([[p, np.zeros((len(p), 1))], [np.zeros((1, len(p))), np.array([[t]])]])))
    assert np.linalg.eigvalsh(matrix / np.outer(size, size)).max() < 0.0
    assert np.linalg.eigvalsh(p).min() > 0.0
    beyond = loop.K[0] - g
    assert np.sqrt(beyond @ np.linalg.inv(p) @ beyond) <= loop.limits[0] * (1.0 + 1e-9)


@pytest.mark.parametrize(("stage", "axis"), [
    ("3dof", "x"), pytest.param("5dof", "roll", marks=pytest.mark.thorough)])
def test_one_sample_decreases_the_sampled_loops_function(stage: str, axis: str) -> None:
    loop = axis_loop(stage, axis, "25 mm")
    found = certify(loop, loop.gains)
    border = on_the_border(found, 300)
    for states in (border, 0.3 * border):
        wanted = loop.K @ states
        cut = wanted - np.clip(wanted, loop.lower[:, None], loop.upper[:, None])
        pushed = loop.B + np.outer(loop.E @ found.gains, loop.w)
        after = states + loop.sample_time * (loop.A @ states - pushed @ cut)
        assert (found.level(after) < found.level(states)).all()
    assert comes_back(loop, found, border).all()


def test_a_larger_ellipsoid_is_no_certificate() -> None:
    """The check by eigenvalues can fail: with the P of one loop and the antiwindup of a worse one."""
    loop = five_states()
    found = certify(loop, THESIS)

    def decrease(gains: NDArray[np.float64]) -> float:
        return decrease_of(loop.A, loop.injected(gains), found.G, found.P, found.T, 0.0, 0.0)

    assert decrease(THESIS) > 0.0
    assert decrease(-THESIS) < 0.0
    assert decrease_of(loop.A, loop.injected(THESIS), found.G, found.P, found.T, 0.0, 3.0) < 0.0


def test_steps_grow_as_the_limit() -> None:
    """Without a command at rest, all that a limit does is to scale."""
    free = {"x.bias": 0.0, "z.bias": 0.0}
    steps = [certify(loop, loop.gains).step for loop in
             (axis_loop("3dof", "x", "25 mm", plant_parameters=free,
                        controller_parameters={"current_limit": limit}) for limit in (2.0, 3.0, 4.0))]
    assert steps == pytest.approx([steps[2] * share for share in (0.5, 0.75, 1.0)], rel=5e-3)


def test_steps_grow_with_the_limit_of_an_unstable_axis() -> None:
    loops = [axis_loop("3dof", "y", "25 mm", controller_parameters={"current_limit": limit})
             for limit in (2.0, 3.0, 4.0)]
    steps = [certify(loop, loop.gains).step for loop in loops]
    assert steps[0] < steps[1] < steps[2]


@pytest.mark.few(2)
@pytest.mark.parametrize(("stage", "axis", "gap"), [
    ("3dof", "y", "25 mm"), ("3dof", "z", "22 mm"), ("2dof", "v", "20 mm"), ("2dof", "h", "20 mm")])
def test_certified_steps_are_smaller_than_those_that_come_back(stage: str, axis: str, gap: str) -> None:
    loop = axis_loop(stage, axis, gap)
    found = certify(loop, loop.gains)
    assert 0.3 * largest_step(loop, found) < found.step < largest_step(loop, found)


def test_synthesised_gains_certify_several_times_the_step() -> None:
    """And keep the rate of decay that was asked for, on an ellipsoid that is still much larger than the thesis's."""
    loop = axis_loop("3dof", "x", "25 mm")
    gains, thesis = synthesise(loop, 1.0), certify(loop, loop.gains).step
    assert certify(loop, gains).step > 5.0 * thesis
    assert certify(loop, gains, decay=0.9).step > 2.0 * thesis
