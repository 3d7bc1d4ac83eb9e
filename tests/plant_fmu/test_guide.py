"""Friction whose level varies along the guide: the level by scipy's spline, and the work that it does on a stage."""

import math

import numpy as np
import pytest
from named_stage import Stage3DOF
from scipy.interpolate import BSpline
from scipy.stats import norm

from plant_fmu.guide import FIRST_STREAM, GuideFriction
from plant_fmu.track import HALF_OF_WORDS, SPACING
from pmlsm.random_words import random_words


def guide(variation: float, seed: int = 3, number: int = 1, correlation: float = 4e-3) -> GuideFriction:
    friction = GuideFriction(2.0, 0.5e-3, 0.0)
    friction.variation, friction.correlation = variation, correlation
    friction.start(seed, number)
    return friction


def level(places: np.ndarray, variation: float, seed: int, number: int, correlation: float) -> np.ndarray:
    """Fc max(0, 1 + s n): weights of a cubic B-spline are normal quantiles of the words; one word places the nodes."""
    stream, spacing = FIRST_STREAM + number, SPACING * correlation
    words = [random_words(seed, stream, node)[0] for node in (*range(-60, 60), HALF_OF_WORDS)]
    shares = (np.array(words) + 0.5) / 2**32
    spline = BSpline(np.arange(-62.0, 62.0), norm.ppf(shares[:-1]) / math.sqrt(151.0 / 315.0), 3)
    found: np.ndarray = 2.0 * np.maximum(0.0, 1.0 + variation * spline(places / spacing + shares[-1]))
    return found


@pytest.mark.parametrize(("variation", "seed", "number", "correlation"), [(0.4, 3, 1, 4e-3), (1.5, 9, 0, 1e-3)])
def test_the_level_is_that_of_the_spline_and_never_below_nothing(
        variation: float, seed: int, number: int, correlation: float) -> None:
    friction = guide(variation, seed, number, correlation)
    places = np.linspace(-40.0, 40.0, 400) * correlation
    found = np.array([friction.level(place) for place in places.tolist()])
    assert found == pytest.approx(level(places, variation, seed, number, correlation), abs=1e-6)
    assert (found.min() == 0.0) == (variation > 1.0)


def test_without_variation_the_level_is_the_same_everywhere_and_there_is_none_at_rest() -> None:
    assert [guide(0.0).level(place) for place in (-1.0, 0.0, 0.3)] == [2.0] * 3
    assert guide(0.4).slide(0.02, 0.0, 0.0) == (0.0, 0.0)


def test_the_work_of_friction_is_its_level_over_the_way() -> None:
    """Sliding, w = ±1: what a mover under a constant force lacks in energy, there and back, is ∫ Fc(q) |dq|."""
    stage = Stage3DOF()
    stage.guide_seed = 3.0
    for name in ("y", "z"):
        getattr(stage, name).locked = True
    x = stage.x
    x.bias = x.friction.viscous = x.ripple.amplitude = 0.0
    x.friction.coulomb, x.friction.presliding, x.friction.variation = 2.0, 1e-5, 0.4
    assert stage.start() == 0
    ways, lost = [], []
    for k in range(2400):
        x.force = -40.0 if 600 <= k < 1800 else 40.0
        before, energy = x.position, 0.5 * x.mass * x.velocity ** 2
        stage.step(k * 1e-4, 1e-4)
        ways.append((before, x.position))
        lost.append(x.force * (x.position - before) - 0.5 * x.mass * x.velocity ** 2 + energy)
    ends = np.array(ways)
    between = ends[:, :1] + np.diff(ends) * [0.0, 0.5, 1.0]
    expected = np.abs(np.diff(ends)[:, 0]) * (level(between, 0.4, 3, 1, 4e-3) @ [1.0, 4.0, 1.0]) / 6.0
    assert np.ptp(ends) > 0.012, "moved over three correlation lengths"
    # But for the ways over which the deflection builds up, at the start and where the mover turns.
    assert np.sum(lost) == pytest.approx(np.sum(expected), abs=5 * 1e-5 * 2.0 * 2.0)
