"""Derivatives of laws that have one and that have none, against what is known of them."""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

import numpy as np
import pytest
from facts import raises

from maglev.analysis.participant import Derivative, Participant, derivative
from maglev.cosim.master import FmuSetup
from maglev.files.errors import LinearModelError

REST = 1e-3   # m


class Law:
    """A lag of what a subclass makes of the measurement."""

    inputs = {"y.measured": "m"}
    outputs = {"alpha.i_a_cmd": "A"}

    def __init__(self) -> None:
        self.sample_time = 1e-3
        self.y_measured = REST
        self.alpha_i_a_cmd = 0.0
        self.state = 0.0

    def step(self, t: float) -> None:
        self.state = 0.9 * self.state + self.shaped(self.y_measured - REST)
        self.alpha_i_a_cmd = self.state

    def shaped(self, deviation: float) -> float:
        return 200.0 * deviation + 3e7 * deviation ** 3


class Rounded(Law):
    def shaped(self, deviation: float) -> float:
        return 200.0 * round(deviation / 5e-6) * 5e-6


class Relay(Law):
    def shaped(self, deviation: float) -> float:
        return float(np.sign(deviation))


class Kinked(Law):
    def shaped(self, deviation: float) -> float:
        return 200.0 * deviation if deviation > 0.0 else 300.0 * deviation


class Narrow(Law):
    """Limited to what 5 µm give."""

    def shaped(self, deviation: float) -> float:
        return 200.0 * max(-5e-6, min(5e-6, deviation))


class Slower(Law):
    """Samples every third time, and holds what it found."""

    def __init__(self) -> None:
        super().__init__()
        self.waiting = 1   # at the point where it is pushed: neither this nor the next sample is one of its own

    def step(self, t: float) -> None:
        self.waiting -= 1
        if self.waiting < 0:
            super().step(t)
            self.waiting = 2


class Random(Law):
    def __init__(self) -> None:
        super().__init__()
        self.lock = Lock()   # no copy of it can be made
        self.random = np.random.default_rng()

    def shaped(self, deviation: float) -> float:
        return 200.0 * deviation + 1e-3 * self.random.standard_normal()


class Locked(Law):
    def __init__(self) -> None:
        super().__init__()
        self.lock = Lock()


@contextmanager
def simulated(law: type) -> Iterator[Participant]:
    """The law at rest, after it was somewhere else."""
    with Participant(FmuSetup("controller", law), ["y.measured"], ["alpha.i_a_cmd"], 1e-3) as part:
        past = np.full((60, 1), REST)
        past[:5] += 1e-6
        outputs = [part.step(row) for row in past.tolist()]
        part.mark(past, outputs[-1])
        yield part


def slope(law: type) -> Derivative:
    with simulated(law) as part:
        return derivative(part, np.array([REST]), 0, 1e-6, 80)


def test_a_cubic_law_has_its_slope_within_the_estimate() -> None:
    found = slope(Law)
    exact = 200.0 * 0.9 ** np.arange(80)
    assert found.verdict == ""
    assert found.holds_to == pytest.approx(20e-6)
    assert np.abs(found.response[:, 0] - exact).max() < 1e-9 * 200.0
    # The smaller push of 10 µm alone is off by 3e7 · (10 µm)² = 3e-3, as estimated.
    assert found.error * 200.0 == pytest.approx(3e7 * (10e-6) ** 2, rel=1e-3)
    assert np.abs(found.coarse[:, 0] - exact).max() == pytest.approx(3e7 * (10e-6) ** 2, rel=1e-3)


@pytest.mark.parametrize(("law", "says"), [
    (Rounded, "no response to 2 µ, one to more: a rounding or a dead zone"), (Relay, "a step: 0.1 µ change it as much"),
    (Kinked, "a kink: up and down differ by 40 %"), (Slower, "samples more slowly, or varies with time")])
def test_names_inputs_without_a_derivative(law: type, says: str) -> None:
    found = slope(law)
    assert says in found.verdict
    assert not found.response.any()


def test_reports_a_narrow_range() -> None:
    found = slope(Narrow)
    assert found.verdict == ""
    assert found.holds_to == pytest.approx(2e-6)
    assert found.response[0, 0] == pytest.approx(200.0, rel=1e-9)


def test_past_and_state_lead_to_the_same_point() -> None:
    rows = np.array([[REST + 1e-5], [REST], [REST - 2e-6]])
    with simulated(Law) as by_state, simulated(Locked) as by_past:
        assert by_state.means == "its saved state"
        assert by_past.means == "its past run again"
        found = by_state.response(rows).tolist()
        assert found == by_past.response(rows).tolist() == by_state.response(rows).tolist()


def test_chance_is_refused() -> None:
    with simulated(Random) as part, raises(LinearModelError):
        part.back()
