"""Margins against python-control, and against what they mean: eigenvalues of loops that are changed by as much."""

from functools import cache

import numpy as np
import pytest
from facts import raises
from hypothesis import given
from hypothesis import strategies as st

from maglev.files.errors import LinearModelError
from maglev.linear.loop import Loop, linearise_loop
from maglev.linear.margins import Margins
from maglev.linear.model import LinearModel

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

LOOPS = {"Regulator3DOF": {"y": 25e-3}, "PID3DOF": {"y": 25e-3}, "Regulator2DOF": {"v": 20e-3}, "PID2DOF": {"v": 17e-3}}
OPENINGS = [("Regulator3DOF", "y"), ("Regulator3DOF", "x.measured"), ("Regulator3DOF", "alpha.i_d"), ("PID3DOF", "y"),
            ("PID3DOF", "beta.i_q_cmd"), ("Regulator2DOF", "v"), ("Regulator2DOF", "motor.i_d_cmd"), ("PID2DOF", "h")]


@cache
def loop_of(controller: str) -> Loop:
    return linearise_loop(f"Plant{controller[-4:]}", controller, LOOPS[controller])


@cache
def opened(controller: str, at: str) -> tuple[LinearModel, Margins]:
    return loop_of(controller).opened(at), loop_of(controller).margins(at)


def largest_pole(loop: LinearModel, factor: complex = 1.0, delay: int = 0) -> float:
    """Largest |z| of a loop L closed with a factor and a delay of some samples in it."""
    n = len(loop.states)
    a = np.zeros((n + delay, n + delay), dtype=complex)
    a[:n, :n] = loop.A
    if delay == 0:
        a -= factor * loop.B @ loop.C
    else:
        a[:n, -1:] = -factor * loop.B
        a[n, :n] = loop.C[0]
        a[n + 1:, n:-1] = np.eye(delay - 1)
    return float(np.abs(np.linalg.eigvals(a)).max())


@pytest.mark.parametrize(("controller", "at"), OPENINGS)
def test_opened_and_closed_again(controller: str, at: str) -> None:
    loop, _ = opened(controller, at)
    assert np.poly(loop.A - loop.B @ loop.C) == pytest.approx(np.poly(loop_of(controller).closed.A), rel=1e-6, abs=1e-9)
    assert largest_pole(loop) < 1.0


@pytest.mark.few(4)
@pytest.mark.parametrize(("controller", "at"), OPENINGS)
def test_gain_and_delay_to_the_limit_and_beyond(controller: str, at: str) -> None:
    loop, margins = opened(controller, at)
    assert largest_pole(loop, margins.gain_up * (1 - 1e-4)) < 1.0 < largest_pole(loop, margins.gain_up * (1 + 1e-4))
    assert margins.gain_down > 0.0   # unstable without feedback, or an integrator in it
    assert largest_pole(loop, margins.gain_down * (1 + 1e-4)) < 1.0 < largest_pole(loop, margins.gain_down * (1 - 1e-4))
    assert loop.sample_time
    samples = int(margins.delay / loop.sample_time)
    assert samples > 5
    assert largest_pole(loop, 1.0, samples) < 1.0 < largest_pole(loop, 1.0, samples + 1)
    turned = np.exp(1j * margins.phase * np.array([1 - 1e-4, 1 + 1e-4]))
    stable = [max(largest_pole(loop, f), largest_pole(loop, f.conjugate())) for f in turned]
    assert stable[0] < 1.0 < stable[1]


@pytest.mark.few(2)
@pytest.mark.parametrize(("controller", "at"), OPENINGS)
@pytest.mark.usefixtures("slow")
def test_margins_are_those_of_python_control(controller: str, at: str) -> None:
    """On a grid of its own; python-control has the smallest phase margin, and one of the gain margins."""
    import control  # which takes a second

    loop, margins = opened(controller, at)
    system = loop.to_control()
    grid = np.geomspace(0.3, 0.999 * np.pi / system.dt, 4000)
    response = control.FrequencyResponseData(system(np.exp(1j * grid * system.dt)), grid, smooth=True)
    gains, phases, distances, *_ = control.stability_margins(response, returnall=True)
    assert 1.0 / margins.sensitivity_peak == pytest.approx(min(distances), rel=1e-3)
    assert np.degrees(margins.phase) == pytest.approx(min(np.abs(phases)), rel=1e-3)
    assert min(gain for gain in gains if gain > 1.0) == pytest.approx(margins.gain_up, rel=1e-3)
    assert max(gain for gain in gains if gain < 1.0) == pytest.approx(margins.gain_down, rel=1e-3)
    disk, *_ = control.disk_margins(system, grid)
    assert margins.disk == pytest.approx(disk, rel=1e-3)


@given(st.sampled_from(OPENINGS), st.floats(0.0, 0.999), st.floats(-np.pi, np.pi))
def test_disk_margin_keeps_the_loop_stable(opening: tuple[str, str], size: float, angle: float) -> None:
    loop, margins = opened(*opening)
    delta = margins.disk * size * np.exp(1j * angle)
    assert largest_pole(loop, (1 + delta / 2) / (1 - delta / 2)) < 1.0
    low, high = margins.disk_gain
    assert margins.gain_down <= low < 1.0 < high <= margins.gain_up
    assert margins.disk_phase <= margins.phase
    assert 2.0 * np.arcsin(min(1.0, 0.5 / margins.sensitivity_peak)) <= margins.phase   # what Ms guarantees


@pytest.mark.parametrize(("controller", "at"), OPENINGS)
def test_disk_margin_is_reached(controller: str, at: str) -> None:
    """The worst change on its rim brings a pole to the circle."""
    loop, margins = opened(controller, at)
    grid = np.geomspace(1e-1, np.pi / (loop.sample_time or 1.0), 5000)
    sensitivity = 1.0 / (1.0 + loop.frequency_response(grid)[:, 0, 0])
    worst = sensitivity[np.argmax(np.abs(sensitivity - 0.5))]
    delta = 1.0 / (worst - 0.5)   # 1 + L (1 + δ/2)/(1 − δ/2) = 0
    factors = [(1 + size * delta / 2) / (1 - size * delta / 2) for size in (0.99, 1.01)]
    assert abs(delta) == pytest.approx(margins.disk, rel=1e-4)
    assert [max(largest_pole(loop, f), largest_pole(loop, f.conjugate())) < 1.0 for f in factors] == [True, False]


def test_unknown_opening_and_unstable_loop() -> None:
    with raises(LinearModelError, "'w'", "y.measured"):
        loop_of("Regulator3DOF").margins("w")
    unstable = linearise_loop("Plant3DOF", "Regulator3DOF", {"y": 25e-3}, controller_parameters={"y.k1": 0.0})
    with raises(LinearModelError, "pole", "stable"):
        unstable.margins("y")
