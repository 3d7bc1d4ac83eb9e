"""An axis that brackets hold in place: it stays there, and the others move."""

import math
from typing import Any

import pytest
from named_stage import Stage2DOF, Stage3DOF

CASES = [(Stage2DOF, ("v", "h"), ("motor",)), (Stage3DOF, ("y", "x", "z"), ("alpha", "beta"))]


def driven(kind: type, motors: tuple[str, ...], locked: str) -> Any:
    """A stage after 50 ms under currents, with an axis locked."""
    stage = kind()
    getattr(stage, locked).locked = True
    stage.start()
    for k in range(100):
        for motor in motors:
            supply = getattr(stage, motor)
            supply.i_a_cmd, supply.i_b_cmd, supply.i_c_cmd = 0.5, -1.0, 0.5
        stage.step(k * 0.5e-3, 0.5e-3)
    return stage


@pytest.mark.parametrize(("kind", "axes", "motors"), CASES)
def test_a_locked_axis_stays_and_the_others_move(kind: type, axes: tuple[str, ...], motors: tuple[str, ...]) -> None:
    for locked in axes:
        stage = driven(kind, motors, locked)
        axis = getattr(stage, locked)
        assert axis.position == axis.position_start
        assert axis.velocity == 0.0
        moved = [abs(getattr(stage, other).position - getattr(stage, other).position_start)
                 for other in axes if other != locked]
        assert max(moved) > 1e-6
        assert all(math.isfinite(distance) for distance in moved)


def test_forces_on_a_locked_axis_do_nothing() -> None:
    stage = Stage3DOF()
    stage.y.locked = True
    stage.y.force = 500.0
    stage.start()
    for k in range(50):
        stage.step(k * 0.2e-3, 0.2e-3)
    assert stage.y.position == stage.y.position_start
    assert not stage.at_stop
