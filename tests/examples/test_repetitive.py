"""The example that learns what repeats: its condition, and errors that fall as it says."""

from importlib import import_module

import numpy as np
import pytest
from example_builds import EXAMPLES

import maglev

STOPS = {"y.stop.lower": 15e-3, "y.stop.upper": 34e-3}


@pytest.fixture(autouse=True)
def beside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)


@pytest.mark.parametrize("axis", ["y", "x", "z"])
def test_it_converges_on_the_linear_loop(axis: str) -> None:
    """|1 − g T/T̂| < 1 at every harmonic, with the stage's constants at both ends of the swing; not with 3 g."""
    repetitive = import_module("repetitive")
    known = repetitive.loop_at_harmonics(axis, 25e-3, repetitive.KNOWN)
    for gap in (20e-3, 29.9e-3):
        ratio = repetitive.loop_at_harmonics(axis, gap, STOPS) / known
        assert np.abs(1.0 - 0.7 * ratio).max() < 0.33
        assert np.abs(1.0 - 2.1 * ratio).max() > 1.0


def test_a_reference_at_its_own_frequency_needs_no_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """T = 1 at ω0, by the internal model."""
    repetitive = import_module("repetitive")
    monkeypatch.setattr(repetitive, "HARMONICS", range(1, 2))
    assert repetitive.loop_at_harmonics("x", 25e-3, repetitive.KNOWN) == pytest.approx([1.0], abs=1e-6)


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
def test_an_update_takes_the_error_to_a_third() -> None:
    repetitive = import_module("repetitive")
    period = 2.0 * np.pi / repetitive.OMEGA
    run = maglev.run({"extends": repetitive.REFERENCES, "name": "short", "title": "Short", "stop_time": "6.7 s",
                      "metrics": {"tracking_from": "4 s"}},
                     controller=repetitive.RepetitiveRegulator)
    number = np.floor((run.time - 4.0) / period + 1e-9)
    for axis in repetitive.GAINS:
        error = np.abs(run[f"plant.{axis}.position"] - run[f"controller.{axis}.reference"])
        first, second = (error[number == k].mean() for k in (0, 1))
        assert 50e-6 < first < 80e-6
        assert 0.25 < second / first < 0.5, axis
