"""Constants that jump: what is left of the jump along paths that are exponentials."""

from collections.abc import Callable
from math import exp, log

import numpy as np
import pytest

from maglev.runs.execution import RunResult
from maglev.runs.procedure_outcome import Outcome
from maglev.runs.procedures import evaluate_all

Simulated = Callable[..., RunResult]

TIME = 1e-3 * np.arange(40_001)
JUMP = 20.0   # s
JUMPS = {"C1": (14.2, 11.36), "C2": (791.0, 632.8)}
RATES = {"keeping": 0.0, "forgetting_slowly": 0.2, "forgetting_fast": 1.0}   # 1/s, of the path and of forgetting


def path(before: float, after: float, rate: float) -> np.ndarray:
    """From before the jump to after it."""
    return np.where(TIME < JUMP, before, after + (before - after) * np.exp(-rate * (TIME - JUMP)))


def percent(text: str) -> float:
    assert text.endswith("%")
    return float(text.removesuffix("%"))


@pytest.fixture(scope="module")
def outcome(simulated: Simulated) -> Outcome:
    """Estimates that are 3 % too large before the jump of C2, and scatter by 1 % there."""
    alternating = np.where(np.arange(len(TIME)) % 2 == 0, 0.01, -0.01) * (TIME < JUMP)
    estimates = {name: {"C1": path(*JUMPS["C1"], rate),
                        "C2": path(*JUMPS["C2"], rate) + JUMPS["C2"][0] * ((TIME < JUMP) * 0.03 + alternating)}
                 for name, rate in RATES.items()}
    (found,) = evaluate_all([simulated("2dof-forgetting", TIME, {}, estimates)])
    return found


def test_what_is_left_of_a_jump_decays_with_the_rate(outcome: Outcome) -> None:
    """Five seconds after it; the row before that is 1 ms early, which is 0.1 % of what is left at most."""
    (table,) = outcome.tables
    assert [row[:2] for row in table.rows] == [(name, rate) for name in ("C1", "C2") for rate in ("0", "0.2", "1")]
    left = [percent(row[4]) for row in table.rows]
    assert left == pytest.approx([100.0 * exp(-5.0 * rate) for rate in (0.0, 0.2, 1.0)] * 2, abs=0.1)


def test_mean_and_scatter_before_the_jump(outcome: Outcome) -> None:
    (table,) = outcome.tables
    assert [(percent(row[2]), percent(row[3])) for row in table.rows] == [(0.0, 0.0)] * 3 + [(3.0, 1.0)] * 3


def test_the_chart_has_the_plant_beside_its_estimates(outcome: Outcome) -> None:
    (chart,) = outcome.charts
    assert chart.number is None
    for panel, (name, (before, after)) in zip(chart.panels, JUMPS.items(), strict=True):
        assert panel.y_title == name
        *estimates, plant = panel.curves
        assert [curve.label for curve in estimates] == [f"forgetting {rate} 1/s" for rate in ("0", "0.2", "1")]
        assert set(plant.y) == {before, after}
        assert [y for x, y in zip(plant.x, plant.y, strict=True) if x < JUMP] == [before] * list(plant.y).count(before)
    fast = chart.panels[0].curves[2]
    half = JUMP + log(2.0)
    assert np.interp(half, fast.x, fast.y) == pytest.approx(0.5 * sum(JUMPS["C1"]), abs=0.01)


def test_nothing_is_claimed_of_the_thesis(outcome: Outcome) -> None:
    assert outcome.settings.claims == []
    assert outcome.values == ()
    assert outcome.runs == ("2dof-forgetting",)
