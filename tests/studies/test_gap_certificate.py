"""The certificate of the interpolated loop: its bounds against scipy, its model against the blocks, its arithmetic."""

import json
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference_stage import G, shape_functions
from scipy.optimize import brentq

from maglev.linear.loop import linearise_loop
from pmlsm.rig_3dof import RIG
from studies.gap_certificate import FILE, LOWER, UPPER, cells, loop, positive, run_group, table, verify

CELLS = cells(table())
REGULATOR = table()


def row(gap: float, current: float, modulation: float, phase: float) -> float:
    """Vertical acceleration of the plant (m/s²), with its bias and a ripple of any phase."""
    _, f2, f3, f4 = shape_functions(gap)
    stage, ripple = RIG.stage, RIG.vertical.ripple
    return (G + RIG.vertical.bias + ripple.amplitude * np.sin(2 * np.pi * gap / ripple.period + phase)
            - 4 * stage.iron * f4 * current**2 + 4 * stage.coils * f3 * current
            - 4 * stage.attraction * (1 - modulation) * f2)


def rest(gap: float, modulation: float, phase: float) -> float:
    """Current that holds the mover (A)."""
    return brentq(lambda i: row(gap, i, modulation, phase), -12.0, 12.0, xtol=1e-13)


@given(st.floats(LOWER + 1e-5, UPPER - 1e-5), st.floats(-4.0, 4.0), st.floats(0.0, 0.0135), st.floats(0.0, 2 * np.pi))
def test_bounds_hold_what_scipy_finds(gap: float, current: float, modulation: float, phase: float) -> None:
    lower, upper, box = next(each for each in CELLS if each[0] <= gap <= each[1])
    held, step = rest(gap, modulation, phase), 1e-7
    slope = (rest(gap + step, modulation, phase) - rest(gap - step, modulation, phase)) / (2 * step)
    REGULATOR.table.choose(gap, REGULATOR.here)
    gain = REGULATOR.here.gain
    ends = []
    for at in (lower + 1e-12, upper - 1e-12):
        REGULATOR.table.choose(at, REGULATOR.here)
        ends.append((REGULATOR.here.current, REGULATOR.here.gain))
    table_slope, growth = np.diff(ends, axis=0)[0] / (upper - lower)
    found = {"alpha": -gain * table_slope, "sigma": gain * (table_slope - slope), "growth": growth / gain}
    if abs(current - held) > 1e-3:
        found["mu"] = row(gap, current, modulation, phase) / (current - held) / gain
    for name, value in found.items():
        low, high = box[name]
        room = 1e-3 + 1e-4 * (high - low)   # of the differences
        assert low - room <= value <= high + room, name


@pytest.mark.parametrize("gap", [19.5e-3, 22.5e-3, 25.5e-3, 28.5e-3])
def test_model_has_the_slow_poles_of_the_blocks(gap: float) -> None:
    """In the middle of a cell, where the table's lines have the curve's slope; it leaves out the sampling."""
    still = {"y.ripple.amplitude": 0.0, "attraction_modulation": 0.0}
    theirs = linearise_loop("Plant3DOF", "InterpolatedRegulator3DOF", {"y": gap}, plant_parameters=still).rates
    held, step = rest_without_ripple(gap), 1e-6
    slope = (rest_without_ripple(gap + step) - rest_without_ripple(gap - step)) / (2 * step)
    REGULATOR.table.choose(gap, REGULATOR.here)
    lower, upper = (getattr(REGULATOR.table, f"point{int((gap - 18e-3) * 1e3) + k}") for k in range(2))
    gain, table_slope = REGULATOR.here.gain, (upper.current - lower.current) / 1e-3
    secant = (without_ripple(gap, held + 1e-4) - without_ripple(gap, held - 1e-4)) / 2e-4
    ours = np.linalg.eigvals(loop(REGULATOR, secant / gain, -gain * table_slope, gain * (table_slope - slope), 0.0,
                                  0.0))
    for rate in ours[np.abs(ours) < 200.0]:
        assert np.abs(theirs - rate).min() < (0.01 if abs(rate) < 20.0 else 0.04) * abs(rate), rate


def without_ripple(gap: float, current: float) -> float:
    """Vertical acceleration of the plant (m/s²) without its ripple."""
    ripple = RIG.vertical.ripple
    return row(gap, current, 0.0, 0.0) - ripple.amplitude * np.sin(2 * np.pi * gap / ripple.period)


def rest_without_ripple(gap: float) -> float:
    return brentq(lambda i: without_ripple(gap, i), -12.0, 12.0, xtol=1e-13)


@pytest.mark.thorough
def test_the_certificate_holds_in_rational_arithmetic() -> None:
    """From the stop to the last gap that 4 A hold, at the speed of the thesis's steps (Fig. 5.23)."""
    found = json.loads(FILE.read_text(encoding="utf-8"))
    assert found["rate"] >= 0.05 and found["decay"] > 0.0
    assert CELLS[0][0] == LOWER == RIG.gap_stop.lower and CELLS[-1][1] == pytest.approx(UPPER)
    assert all(one[1] == other[0] for one, other in pairwise(CELLS))
    assert verify(found)


@pytest.mark.parametrize("change", ["rate", "decay", "sign", "asymmetry", "length"])
def test_what_is_none_is_refused(change: str) -> None:
    found = json.loads(FILE.read_text(encoding="utf-8"))
    if change == "rate":
        found["rate"] *= 10.0
    elif change == "decay":
        found["decay"] = 3.0
    elif change == "sign":
        found["P"][4] = [[-each for each in row] for row in found["P"][4]]
    elif change == "asymmetry":
        found["P"][4][0][1] *= 1.5
    else:
        found["P"].pop()
    assert not verify(found)


@pytest.mark.thorough
def test_random_runs_step_to_the_end_of_their_group(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("studies.gap_certificate.GROUP", 3)
    after, runs = run_group(0)
    recording = runs.run(2).recording
    assert recording.columns["controller.y.reference"][-1] == after
    assert recording.columns["plant.y.position"][0] == runs.settings["plant.y.position_start"][2]
    assert (runs["end error of y"] < 1e-3).all() and not np.isfinite(runs["stop contact time"]).any()


@given(st.integers(0, 10**6))
def test_pivots_say_what_eigenvalues_say(seed: int) -> None:
    random = np.random.default_rng(seed)
    root = random.integers(-3, 4, (4, 4))
    matrix = root @ root.T + int(random.integers(-2, 3)) * np.eye(4, dtype=int)
    least = np.linalg.eigvalsh(matrix)[0]
    if abs(least) > 1e-9:
        assert positive([[Fraction(int(each)) for each in row] for row in matrix]) == (least > 0.0)
