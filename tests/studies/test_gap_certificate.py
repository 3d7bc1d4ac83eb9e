"""Certificates of the interpolated loops: bounds against scipy, models against the blocks, arithmetic."""

import json
from functools import cache, partial
from itertools import pairwise
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference_stage import G, shape_functions
from scipy.linalg import expm
from scipy.optimize import brentq

from controller_fmu.status import INTERPOLATED
from controller_fmu.vertical_law import VerticalLaw
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.linear.loop import linearise_loop
from studies import gap_certificate, tilt_certificate
from studies.gap_certificate import (
    LOWER,
    UPPER,
    VERTICAL,
    Loop,
    cells,
    covered_steps,
    positive,
    rational,
    set_up,
    verify,
    vertical,
)
from studies.tilt_certificate import ABOUT, LEVER, SHARE, TILT, tilting

DESCRIPTION = PACKAGED_STAGES["3dof"]

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

REGULATOR = set_up(VERTICAL)
HERE = VerticalLaw(INTERPOLATED)   # what the table has at the gap that was asked for last
LOOPS = {"vertical": VERTICAL, "tilt": TILT}


@cache
def pieces(loop: Loop) -> list[tuple[float, float, gap_certificate.Box]]:
    """Cells of a loop's table with their bounds."""
    return cells(loop, set_up(loop))


def row(gap: float, current: float, modulation: float, phase: float) -> float:
    """Vertical acceleration of the plant (m/s²), with its bias and a ripple of any phase."""
    _, f2, f3, f4 = shape_functions(gap)
    plant, ripple = DESCRIPTION.plant, DESCRIPTION.vertical.ripple
    return (G + DESCRIPTION.vertical.bias + ripple.amplitude * np.sin(2 * np.pi * gap / ripple.period + phase)
            - 4 * plant.iron * f4 * current**2 + 4 * plant.coils * f3 * current
            - 4 * plant.attraction * (1 - modulation) * f2)


def rest(gap: float, modulation: float, phase: float) -> float:
    """Current that holds the mover (A)."""
    return brentq(lambda i: row(gap, i, modulation, phase), -12.0, 12.0, xtol=1e-13)


@given(st.floats(LOWER + 1e-5, UPPER - 1e-5), st.floats(-4.0, 4.0), st.floats(0.0, 0.0135), st.floats(0.0, 2 * np.pi))
def test_bounds_hold_what_scipy_finds(gap: float, current: float, modulation: float, phase: float) -> None:
    held, step = rest(gap, modulation, phase), 1e-7
    slope = (rest(gap + step, modulation, phase) - rest(gap - step, modulation, phase)) / (2 * step)
    gain, table_slope, growth = table_at(gap)
    found = {"alpha": -gain * table_slope, "sigma": gain * (table_slope - slope), "growth": growth / gain}
    if abs(current - held) > 1e-3:
        found["mu"] = row(gap, current, modulation, phase) / (current - held) / gain
    require_within(gap, VERTICAL, found)


@given(st.floats(LOWER + 1e-5, UPPER - 1e-5), st.floats(-ABOUT, ABOUT), st.floats(-ABOUT, ABOUT),
       st.floats(0.0, 0.0135), st.floats(0.0, 2 * np.pi))
def test_bounds_of_a_tilt_hold_what_differences_find(gap: float, current: float, demanded: float, modulation: float,
                                                     phase: float) -> None:
    """Of motors at unlike gaps, all with one current; the ripple is that of y alone, and counts for what holds it."""
    still, step = rest(gap, modulation, phase) + current, 1e-6
    gain, table_slope, growth = table_at(gap)
    require_within(gap, TILT, {
        "mu": (without_ripple(gap, still + step, modulation) - without_ripple(gap, still - step, modulation))
        / (2 * step) / gain,
        "nu": SHARE * (without_ripple(gap + step, still, modulation) - without_ripple(gap - step, still, modulation))
        / (2 * step),
        "eta": SHARE * (gain * table_slope - growth * demanded), "growth": growth / gain})


@given(st.floats(LOWER + 1e-5, UPPER - 1e-5).filter(lambda gap: abs(1e3 * gap - round(1e3 * gap)) > 0.01),
       st.floats(-10.0, 10.0), st.floats(-0.5, 0.5))
def test_currents_for_a_small_tilt_are_what_the_regulator_commands(gap: float, lift: float, turn: float) -> None:
    """Of accelerations (m/s², rad/s²) that y and roll demand; none is at its limit."""
    regulator, tilt = set_up(TILT), 1e-7
    platform, motors = regulator.platform, regulator.motors
    for place in platform.places:
        place.gap_measured = place.moved(gap, tilt, 0.0)
    axes = [SimpleNamespace(demand=partial(float, demand), reference=0.0, measured=0.0)
            for demand in (lift, 0.0, 0.0, tilt * turn, 0.0)]
    regulator.currents.command(axes, motors, regulator.model, platform, 0.0)
    currents = [motors[number].i_d_cmd for number in range(2)]
    gain, table_slope, growth = table_at(gap)
    eta = SHARE * (gain * table_slope - growth * lift / gain)
    assert SHARE / LEVER * gain * (currents[1] - currents[0]) / (2.0 * tilt) == pytest.approx(turn + eta, rel=1e-5)


def table_at(gap: float) -> tuple[float, float, float]:
    """Gain of the table at a gap, and slopes of current and gain there."""
    lower, upper, _ = next(each for each in pieces(VERTICAL) if each[0] <= gap <= each[1])
    ends = []
    for at in (lower + 1e-12, upper - 1e-12, gap):
        REGULATOR.currents.gains.choose(at, HERE)
        ends.append((HERE.forward, HERE.linear.gain))
    table_slope, growth = np.diff(ends[:2], axis=0)[0] / (upper - lower)
    return ends[2][1], table_slope, growth


def require_within(gap: float, loop: Loop, found: dict[str, float]) -> None:
    """What was found at a gap lies within the bounds of its cell, except for the error of differences."""
    box = next(each[2] for each in pieces(loop) if each[0] <= gap <= each[1])
    for name, value in found.items():
        low, high = box[name]
        room = 1e-3 + 1e-4 * (high - low)
        assert low - room <= value <= high + room, name


@pytest.mark.parametrize("gap", [19.5e-3, 22.5e-3, 25.5e-3, 28.5e-3])
def test_model_has_the_slow_poles_of_the_blocks(gap: float) -> None:
    """In the middle of a cell, where the table's lines have the curve's slope; it leaves out the sampling."""
    still = {"y.ripple.amplitude": 0.0, "attraction_modulation": 0.0}
    theirs = linearise_loop("Plant3DOF", "InterpolatedRegulator3DOF", {"y": gap}, plant_parameters=still).rates
    held, step = rest_without_ripple(gap), 1e-6
    slope = (rest_without_ripple(gap + step) - rest_without_ripple(gap - step)) / (2 * step)
    table = REGULATOR.currents.gains
    table.choose(gap, HERE)
    lower, upper = table.points[int((gap - 18e-3) * 1e3):][:2]
    gain, table_slope = HERE.linear.gain, (upper.current - lower.current) / 1e-3
    secant = (without_ripple(gap, held + 1e-4) - without_ripple(gap, held - 1e-4)) / 2e-4
    require_slow_poles(theirs, vertical(REGULATOR, secant / gain, -gain * table_slope, gain * (table_slope - slope),
                                        0.0, 0.0))


@pytest.mark.parametrize("gap", [20.5e-3, 25.5e-3, 28.5e-3])
def test_model_of_a_tilt_has_the_slow_poles_of_the_blocks(gap: float) -> None:
    """Each twice, of roll and pitch, which are alike; next to them are those of y, x and z."""
    still = {"y.ripple.amplitude": 0.0, "attraction_modulation": 0.0}
    theirs = linearise_loop("Plant5DOF", "InterpolatedRegulator5DOF", {"y": gap}, plant_parameters=still).rates
    held, step = rest_without_ripple(gap), 1e-6
    gain, table_slope, _ = table_at(gap)
    tangent = (without_ripple(gap, held + step) - without_ripple(gap, held - step)) / (2 * step)
    stiffness = (without_ripple(gap + step, held) - without_ripple(gap - step, held)) / (2 * step)
    require_slow_poles(theirs, tilting(set_up(TILT), tangent / gain, SHARE * stiffness, SHARE * gain * table_slope, 0.0,
                                       0.0), times=2)


def require_slow_poles(theirs: np.ndarray, matrix: list[list[float]], times: int = 1) -> None:
    """Slow poles of a model are so often among the rates of a loop of blocks, which samples."""
    ours = np.linalg.eigvals(np.array(matrix))
    for rate in ours[np.abs(ours) < 200.0]:
        near = np.sort(np.abs(theirs - rate))[times - 1]
        assert near < (0.01 if abs(rate) < 20.0 else 0.04) * abs(rate), rate


def without_ripple(gap: float, current: float, modulation: float = 0.0) -> float:
    """Vertical acceleration of the plant (m/s²) without its ripple."""
    ripple = DESCRIPTION.vertical.ripple
    return row(gap, current, modulation, 0.0) - ripple.amplitude * np.sin(2 * np.pi * gap / ripple.period)


def rest_without_ripple(gap: float) -> float:
    return brentq(lambda i: without_ripple(gap, i), -12.0, 12.0, xtol=1e-13)


@pytest.mark.thorough
@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_the_certificate_holds_in_rational_arithmetic(loop: Loop) -> None:
    """From the stop to the last gap that 4 A hold, at the speed of the thesis's steps (Fig. 5.23)."""
    found = json.loads(loop.file.read_text(encoding="utf-8"))
    parts = pieces(loop)
    assert found["rate"] >= 0.05 and found["decay"] > 0.0
    assert parts[0][0] == LOWER == DESCRIPTION.gap_stop.lower and parts[-1][1] == pytest.approx(UPPER)
    assert all(one[1] == other[0] for one, other in pairwise(parts))
    assert verify(loop, found)


@pytest.mark.few(4)
@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
@pytest.mark.parametrize("change", ["rate", "decay", "sign", "asymmetry", "length"])
def test_refuses_a_wrong_certificate(change: str, loop: Loop, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gap_certificate, "cells", lambda loop, _: pieces(loop))   # made once
    found = json.loads(loop.file.read_text(encoding="utf-8"))
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
    assert not verify(loop, found)


def test_steps_that_are_covered_keep_the_certified_rate() -> None:
    """By the farthest points of the ellipsoids V ≤ V(0), and by a loop that is any of its corners in turn."""
    found = json.loads(VERTICAL.file.read_text(encoding="utf-8"))
    steps, furthest = covered_steps(found)
    P = np.array(found["P"]) / np.outer(found["scale"], found["scale"])
    start = np.array([-1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0])
    for state, most in ((1, found["rate"]), (0, furthest)):
        farthest = [matrix @ np.eye(8)[state] for matrix in np.linalg.inv(P)]   # x ∝ P⁻¹ c of each gap
        reached = max(abs(x[state]) / np.sqrt(x @ matrix @ x) for x, matrix in zip(farthest, P, strict=True))
        for step, matrix in zip(steps, P, strict=True):
            assert step * np.sqrt(start @ matrix @ start) * reached == pytest.approx(most)
    random, dt, target = np.random.default_rng(1), 5e-4, 25e-3
    x, box = steps[7] * start, next(each[2] for each in pieces(VERTICAL) if each[1] == pytest.approx(target))
    fastest = 0.0
    for _ in range(400):
        corner = [random.choice(bounds) for bounds in box.values()]
        x = expm(dt * np.array(vertical(REGULATOR, *(*corner, x[1])))) @ x
        fastest = max(fastest, abs(x[1]))
        assert abs(x[0]) <= furthest
    assert 0.1 * found["rate"] < fastest <= found["rate"]


@pytest.mark.thorough
@pytest.mark.parametrize("study", [gap_certificate, tilt_certificate])
def test_random_runs_step_to_the_end_of_their_group(monkeypatch: pytest.MonkeyPatch, study: ModuleType) -> None:
    monkeypatch.setattr(study, "GROUP", 3)
    after, runs = study.run_group(0)
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
        assert positive(rational(matrix)) == (least > 0.0)
