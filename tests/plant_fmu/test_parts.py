"""Parts of a stage, each by itself: amplifier, guide, end stop, encoder, attraction, division of a step."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from plant_fmu.attraction import attraction_factor
from plant_fmu.current_amplifier import AmplifierRating, CurrentAmplifier
from plant_fmu.encoder import Encoder
from plant_fmu.end_stop import EndStop
from plant_fmu.guide import GuideFriction
from plant_fmu.integration import integration_steps
from plant_fmu.ripple import Ripple

DT = 0.25e-3


def amplify(commands: list[float], rating: AmplifierRating, dt: float = DT) -> tuple[CurrentAmplifier, list[float]]:
    amplifier, currents = CurrentAmplifier(), []
    rating.prepare(dt)
    for command in commands:
        amplifier.advance(command, rating)
        currents.append(amplifier.current)
    return amplifier, currents


def test_lag_is_exact_and_starts_at_the_first_clamped_command() -> None:
    _, currents = amplify([20.0] + [-3.0] * 8, AmplifierRating(9.0, 7.0))
    assert currents[0] == 9.0
    expected = [-3.0 + 12.0 * math.exp(-DT * k / 0.3e-3) for k in range(1, 9)]
    assert currents[1:] == pytest.approx(expected, rel=1e-12)


@given(st.floats(1e-6, 3e-3))
def test_middle_current_gives_the_exact_mean(dt: float) -> None:
    """Simpson's rule over the step is the integral of the exponential."""
    rating = AmplifierRating(9.0, 7.0)
    rating.prepare(dt)
    simpson = (1.0 + 4.0 * rating.lag_decay_middle + rating.lag_decay) / 6.0
    assert simpson == pytest.approx(-math.expm1(-dt / 0.3e-3) * 0.3e-3 / dt, rel=1e-9)


@pytest.mark.parametrize("name", ["lag", "thermal_time", "continuous"])
def test_effects_switched_off(name: str) -> None:
    rating = AmplifierRating(9.0, 7.0)
    setattr(rating, name, 0.0)
    amplifier, currents = amplify([0.0] + [50.0] * 40_000, rating)
    assert currents[-1] == pytest.approx({"lag": 7.0, "thermal_time": 9.0, "continuous": 9.0}[name])
    assert amplifier.saturated
    assert (currents[1] == {"lag": 9.0}.get(name)) == (name == "lag")


def test_a_peak_of_the_largest_command_clamps_nothing() -> None:
    """How to run without a clamp: inputs are within ±1000 A."""
    rating = AmplifierRating(1000.0, 0.0)
    rating.lag = 0.0
    commands = [1000.0, -1000.0, 0.0, 9.1, -7.3]
    amplifier, currents = amplify(commands, rating)
    assert currents == commands
    assert not amplifier.saturated


def test_continuous_limit_against_its_equation() -> None:
    """q' = (i² − q)/T with the clamp that q moves; 8 A commanded on a 5 A, 4 A amplifier."""
    def clamp(q: float) -> float:
        return 5.0 - min(max((q / 16.0 - 0.9) / 0.1, 0.0), 1.0)

    solution = solve_ivp(lambda t, q: clamp(q[0])**2 - q, (0.0, 4.0), [0.0], rtol=1e-10, atol=1e-12, max_step=1e-3,
                         dense_output=True)
    assert solution.sol is not None
    rating, amplifier = AmplifierRating(5.0, 4.0), CurrentAmplifier()
    rating.prepare(DT)
    for k in range(16_000):
        amplifier.advance(8.0, rating)
        if k % 500 == 499:
            assert amplifier.heat == pytest.approx(solution.sol((k + 1) * DT)[0], abs=2e-5)
    assert amplifier.saturated
    assert 4.0 < amplifier.current < 4.1


@given(st.lists(st.floats(-100.0, 100.0), min_size=1, max_size=50))
def test_current_stays_within_the_peak(commands: list[float]) -> None:
    _, currents = amplify(commands, AmplifierRating(9.0, 7.0))
    assert max(map(abs, currents)) <= 9.0


def slide(friction: GuideFriction, velocities: np.ndarray, dt: float) -> np.ndarray:
    """Deflection along a path, in small steps."""
    w, path = 0.0, []
    for v in velocities:
        middle = w + 0.5 * dt * friction.slide(0.0, w, v)[1]
        w += dt * friction.slide(0.0, middle, v)[1]
        path.append(w)
    return np.array(path)


def test_sliding_friction() -> None:
    friction = GuideFriction(4.0, 0.3e-3, 0.0)
    path = slide(friction, np.full(20_000, 0.05), 1e-6)
    # Dahl: w = 1 − exp(−x/δ), so that its stiffness at rest is Fc/δ.
    assert path == pytest.approx(1.0 - np.exp(-0.05e-6 * np.arange(1, 20_001) / 0.3e-3), abs=1e-6)
    assert friction.slide(0.0, path[-1], 0.05)[0] == pytest.approx(4.0, rel=0.05)
    assert GuideFriction(4.0, 0.3e-3, 2.0).slide(0.0, -1.0, -3.0)[0] == -10.0


def test_friction_dissipates() -> None:
    """Over a closed cycle the friction takes energy, and the deflection stays within ±1."""
    friction = GuideFriction(4.0, 0.3e-3, 0.0)
    t = np.arange(0.0, 2.0, 1e-5)
    velocity = 5e-3 * np.cos(2 * np.pi * t)
    path = slide(friction, velocity, 1e-5)
    assert np.abs(path).max() <= 1.0
    assert np.sum(friction.coulomb * path * velocity) * 1e-5 > 0.0


@pytest.mark.parametrize(("coulomb", "presliding"), [(0.0, 1e-3), (4.0, 0.0)])
def test_friction_off(coulomb: float, presliding: float) -> None:
    assert GuideFriction(coulomb, presliding, 0.0).slide(0.0, 0.0, 1.0)[1] == 0.0


def test_ripple() -> None:
    assert Ripple(0.15, 5e-3).acceleration(0.0) == pytest.approx(0.15 * math.sin(0.5))
    assert Ripple(0.15, 5e-3).acceleration(1e-3) == pytest.approx(0.15 * math.sin(0.4 * math.pi + 0.5))
    assert Ripple(0.0, 5e-3).acceleration(1e-3) == Ripple(1.0, 0.0).acceleration(1e-3) == 0.0


@given(st.floats(-0.1, 0.1), st.floats(-10.0, 10.0))
def test_stop_pushes_and_never_pulls(position: float, velocity: float) -> None:
    stop = EndStop(-0.05, 0.05)
    stop.engage(position)
    force = stop.force(position, velocity)
    if position < -0.05:
        assert force >= 0.0
    elif position > 0.05:
        assert force <= 0.0
    elif abs(position) < 0.0499:
        assert force == 0.0
    stop.engage(-position)
    assert stop.force(-position, -velocity) == -force


def test_stop_values() -> None:
    stop = EndStop(0.0, 0.01)
    stop.engage(0.0101)
    assert stop.force(0.0101, 0.02) == pytest.approx(-(40.0 + 30.0))
    assert stop.force(0.0101, -1.0) == 0.0
    assert stop.touched(0.0101)
    assert not stop.touched(0.01)
    stop.stiffness = stop.damping = 0.0
    assert not stop.touched(0.0101)


@given(st.floats(-0.1, 0.1), st.sampled_from([10e-6, 1e-6, 1e-3]))
def test_encoder_rounds(position: float, resolution: float) -> None:
    measured = Encoder(resolution).measure(position)
    assert abs(measured - position) <= resolution * 0.5000001
    assert measured == math.floor(position / resolution + 0.5) * resolution
    assert Encoder(0.0).measure(position) == position


def test_attraction_repeats_with_the_slots() -> None:
    assert attraction_factor(0.027, 0.0, 19.05e-3) == 1.0
    assert attraction_factor(0.027, 19.05e-3 / 2, 19.05e-3) == pytest.approx(1.0 - 0.027)
    assert attraction_factor(0.027, 19.05e-3 + 1e-3, 19.05e-3) == pytest.approx(
        attraction_factor(0.027, -1e-3, 19.05e-3))
    assert attraction_factor(0.0, 0.3, 19.05e-3) == 1.0


@given(st.integers(1, 50), st.floats(-1e-12, 1e-12))
def test_whole_division_survives_rounding(count: int, noise: float) -> None:
    assert integration_steps(count * 0.2e-3 * (1.0 + noise), 0.2e-3) == count


@given(st.floats(1e-9, 1.0), st.floats(1e-5, 1e-2))
def test_no_integration_step_is_too_long(dt: float, longest: float) -> None:
    steps = integration_steps(dt, longest)
    assert steps >= 1
    assert dt / steps <= longest * (1.0 + 1e-8)
    assert steps == 1 or dt / (steps - 1) > longest * (1.0 - 1e-8)
