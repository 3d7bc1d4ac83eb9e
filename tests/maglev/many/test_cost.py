"""What a candidate costs."""

from math import inf, nan

import numpy as np
import pytest

from maglev.many.study_columns import Column
from maglev.many.tuning_plan import REFUSED, Cost

COLUMNS = (Column("failed", "", max=0.0), Column("settling", "s"), Column("overshoot", "", max=0.5),
           Column("current", "A"))
BEFORE = np.array([[0.0, 3.0, 0.2, 1.0], [0.0, inf, 0.3, 2.0]])   # of two plants


def cost(*simulated: list[float], over: str = "worst", times: float | None = None) -> float:
    """Cost of one candidate with these metrics on the plants."""
    return float(Cost(COLUMNS, (1,), {} if times is None else {2: times}, over).of(np.array([simulated]), BEFORE)[0])


def test_the_worst_plant_or_the_mean_of_all() -> None:
    simulated = [0.0, 1.0, 0.4, 9.0], [0.0, 2.0, 0.1, inf]
    assert cost(*simulated) == 2.0
    assert cost(*simulated, over="mean") == 1.5


@pytest.mark.parametrize("broken", [[1.0, 1.0, 0.1, 1.0], [0.0, inf, 0.1, 1.0], [0.0, 1.0, 0.51, 1.0],
                                    [nan, nan, nan, nan]])
def test_breaking_a_limit_costs_more_than_keeping_all(broken: list[float]) -> None:
    assert cost([0.0, 1.0, 0.1, 1.0], broken) > REFUSED > cost([0.0, 1e5, 0.5, inf], [0.0, 1e5, 0.5, inf])


def test_what_was_before_counts_plant_by_plant() -> None:
    within, beyond = [0.0, 1.0, 0.25, 1.0], [0.0, 1.0, 0.35, 1.0]
    assert cost([0.0, 1.0, 0.2, 1.0], within, times=1.0) == 1.0
    assert cost(within, [0.0, 1.0, 0.2, 1.0], times=1.0) > REFUSED   # the first plant had 0.2
    assert cost([0.0, 1.0, 0.2, 1.0], beyond, times=1.0) > REFUSED
    assert cost([0.0, 1.0, 0.2, 1.0], beyond, times=1.2) == 1.0


def test_of_two_that_break_limits_the_lesser_excess_costs_less() -> None:
    good = [0.0, 1.0, 0.1, 1.0]
    costs = [cost(good, [0.0, 1.0, overshoot, 1.0]) for overshoot in (0.5, 0.6, 0.7, 5.0)]
    assert costs == sorted(costs)
    assert len(set(costs)) == 4
    assert cost([nan] * 4, [nan] * 4) > cost(good, [nan] * 4)
