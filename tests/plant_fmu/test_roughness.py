"""Roughness of the guides: statistics over tracks, the spline written again, and what a stage does on one."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from named_stage import Stage2DOF, Stage3DOF
from scipy.interpolate import BSpline
from scipy.stats import kstest, kurtosis, norm

from plant_fmu.roughness import FIRST_STREAM, Roughness
from plant_fmu.stage import NO_SEED
from plant_fmu.track import HALF_OF_WORDS, SPACING
from pmlsm.random_words import random_words

LENGTH = 2e-3   # m


def track(seed: int = 1, number: int = 0, rms: float = 1.0, correlation: float = LENGTH) -> Roughness:
    found = Roughness()
    found.rms, found.correlation = rms, correlation
    found.start(seed, number)
    return found


def values(found: Roughness, places: np.ndarray) -> np.ndarray:
    return np.array([found.acceleration(place) for place in places.tolist()])


@pytest.fixture(scope="module")
def many() -> np.ndarray:
    """1500 tracks at 31 places 0.5 mm apart, shape (tracks, places)."""
    places = 0.0137 + 0.5e-3 * np.arange(31)
    return np.array([values(track(seed, seed % 3), places) for seed in range(1500)])


def test_tracks_are_gaussian_with_the_rms(many: np.ndarray) -> None:
    """At single places, where tracks are independent: mean, rms, fourth moment, and the whole distribution."""
    assert abs(many.mean()) < 0.02
    assert np.sqrt((many ** 2).mean()) == pytest.approx(1.0, abs=0.015)
    assert abs(kurtosis(many, axis=None)) < 0.1
    assert kstest(many[:, 15], norm.cdf).pvalue > 1e-3
    assert kstest(many[:, 0], norm.cdf).pvalue > 1e-3


def test_the_covariance_is_gaussian_with_the_correlation_length(many: np.ndarray) -> None:
    """exp(−d²/2ℓ²) within 0.01 by the spline, and within what 1500 tracks leave open."""
    lags = 0.5e-3 * np.arange(31)
    found = np.array([(many[:, :31 - k] * many[:, k:]).mean() for k in range(31)])
    expected = np.exp(-(lags / LENGTH) ** 2 / 2.0)
    assert np.abs(found[:17] - expected[:17]).max() < 0.03
    # The covariance of the spline itself, of degree 7, without chance.
    exact = BSpline.basis_element(np.arange(-4.0, 5.0), extrapolate=False)
    of_spline = np.nan_to_num(exact(lags / (SPACING * LENGTH))) / (151.0 / 315.0)
    assert np.abs(of_spline - expected).max() < 0.01
    assert np.abs(found[:17] - of_spline[:17]).max() < 0.03


def test_the_variance_hardly_depends_on_the_place_between_the_nodes() -> None:
    """Within 5 %, and its mean over a cell is 1: only that is what the nodes' random place leaves."""
    basis = BSpline.basis_element(np.arange(-2.0, 3.0), extrapolate=False)
    ways = np.linspace(0.0, 1.0, 1001)
    shares = np.array([[basis(way - k) for k in (-1.0, 0.0, 1.0, 2.0)] for way in ways])
    variance = np.sum(np.nan_to_num(shares) ** 2, axis=1) / (151.0 / 315.0)
    assert np.trapezoid(variance, ways) == pytest.approx(1.0, abs=1e-6)
    assert np.abs(variance - 1.0).max() < 0.05


@pytest.mark.parametrize(("seed", "number", "length"), [(1, 0, 2e-3), (77, 2, 0.7e-3)])
def test_a_track_is_the_spline_of_its_words(seed: int, number: int, length: float) -> None:
    """By scipy: normal quantiles of the words as weights of a cubic B-spline, nodes placed by one word more."""
    stream, spacing = FIRST_STREAM + number, SPACING * length
    nodes = np.arange(-60, 60)
    weights = np.asarray(norm.ppf([(random_words(seed, stream, int(node))[0] + 0.5) / 2**32 for node in nodes]))
    offset = (random_words(seed, stream, HALF_OF_WORDS)[0] + 0.5) / 2**32
    spline = BSpline(np.arange(-62.0, 62.0), weights / math.sqrt(151.0 / 315.0), 3)
    places = np.linspace(-50.0, 50.0, 400) * spacing
    assert values(track(seed, number, 0.3, length), places) == pytest.approx(
        0.3 * spline(places / spacing + offset), abs=1e-6)


def test_tracks_are_smooth() -> None:
    """Two continuous derivatives: over a border of cells the second difference does not jump, the third does."""
    found, h = track(), 1e-6
    border = (3.0 - found.track.offset) / found.track.per_metre
    places = border + h * np.arange(-6, 7)
    second = np.diff(values(found, places), 2) / h ** 2
    curvature = np.abs(np.diff(values(found, 0.05 + 1e-5 * np.arange(2000)), 2)).max() / 1e-10
    assert np.abs(np.diff(second)).max() < 0.01 * curvature


@given(st.lists(st.floats(-0.1, 0.1), min_size=2, max_size=8), st.integers(0, 2**32 - 1))
def test_where_the_mover_was_before_is_no_matter(places: list[float], seed: int) -> None:
    """Bit for bit: what is kept of a cell is what a new track computes there."""
    kept = track(seed)
    assert [kept.acceleration(place) for place in places] == [track(seed).acceleration(place) for place in places]


def test_axes_and_seeds_have_tracks_of_their_own() -> None:
    places = np.linspace(-0.05, 0.05, 200)
    found = [values(track(seed, number), places) for seed in (1, 2, 4294967295) for number in range(3)]
    between = np.corrcoef(found)[np.triu_indices(len(found), 1)]
    assert np.abs(between).max() < 0.6
    assert abs(between.mean()) < 0.1


@pytest.mark.parametrize("place", [math.inf, -math.inf, math.nan, 1e300])
def test_a_mover_that_has_run_away_raises_nothing(place: float) -> None:
    found = track()
    found.acceleration(0.01)
    assert isinstance(found.acceleration(place), float)


def test_a_seed_is_a_whole_number() -> None:
    stage = Stage3DOF()
    stage.guide_seed = 1.5
    assert stage.start() == stage.stops + NO_SEED


def test_a_stage_that_is_off_moves_as_one_without() -> None:
    """Whatever the seed: the same bits."""
    ends = []
    for seed in (1.0, 9.0):
        stage = Stage2DOF()
        stage.guide_seed = seed
        assert stage.start() == 0
        for k in range(100):
            stage.step(k * 0.5e-3, 0.5e-3)
        ends.append((stage.v.position, stage.h.velocity))
    assert ends[0] == ends[1]


@pytest.mark.parametrize(("axis", "payload"), [("x", 0.0), ("z", 2.0)])
def test_roughness_is_a_conservative_force(axis: str, payload: float) -> None:
    """m v²/2 is the work of the force m0 r(q) from the start on, there and back."""
    stage = Stage3DOF()
    stage.guide_seed = 5.0
    for name in ("y", "x", "z"):
        each = getattr(stage, name)
        each.friction.coulomb = each.friction.viscous = each.bias = each.ripple.amplitude = 0.0
        each.locked = name != axis
    moved = getattr(stage, axis)
    moved.roughness.rms, moved.position_start = 0.2, -0.03
    nominal = moved.mass
    moved.mass += payload
    assert stage.start() == 0
    places, speeds = [], []
    for k in range(3200):
        moved.force = nominal * (-3.0 if 800 <= k < 2400 else 3.0)
        before = moved.position
        work = moved.force / moved.mass
        energy = 0.5 * moved.velocity ** 2
        stage.step(k * 1e-4, 1e-4)
        gained = 0.5 * moved.velocity ** 2 - energy - work * (moved.position - before)
        places.append((before, moved.position))
        speeds.append(gained)
    again = track(5, {"y": 0, "x": 1, "z": 2}[axis], 0.2)
    ways = np.array(places)
    ends = np.array([0.0, 0.5, 1.0])
    work_done = [(b - a) / 6.0 * float(np.dot([1.0, 4.0, 1.0], values(again, a + (b - a) * ends))) for a, b in ways]
    assert np.ptp(ways) > 0.015, "moved over seven correlation lengths"
    assert np.sum(speeds) == pytest.approx(np.sum(work_done) * nominal / (nominal + payload), abs=2e-9)
    assert np.abs(np.cumsum(speeds) - np.cumsum(work_done) * nominal / (nominal + payload)).max() < 1e-8
