"""The rows of A and b against the stages, and the estimators' velocity against the controllers'."""

import numpy as np
import pytest
from direct_loop import idealise
from hypothesis import given
from hypothesis import strategies as st
from identification_data import new_blocks
from motor import MOTOR

from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from maglev.identification.identify import matched, observed
from maglev.identification.regressors import ESTIMATED_STAGES, accelerations, regressors, shape_functions
from pmlsm.gap_functions import gap_functions


@given(st.sampled_from(["2dof", "3dof"]), st.floats(9e-3, 31e-3),
       st.lists(st.floats(-5.0, 5.0), min_size=4, max_size=4))
def test_rows_are_the_stage(description: str, gap: float, currents: list[float]) -> None:
    axes, motors = ESTIMATED_STAGES[description].axes, ESTIMATED_STAGES[description].motors
    stage, pid = new_blocks(len(axes))
    idealise(len(axes), stage, pid)
    getattr(stage, axes[0]).position = gap
    for k, motor in enumerate(motors):
        getattr(stage, motor).i_d, getattr(stage, motor).i_q = currents[2 * k], currents[2 * k + 1]
    for axis in axes:
        getattr(stage, axis).begin()   # takes the bias
    stage.add_slope(0.0, 0.0)
    m = 2 * len(motors)
    positions = np.array([[gap, *[0.0] * (len(axes) - 1)]])
    constants = {name: getattr(stage, name) for name in ESTIMATED_STAGES[description].constants}
    found = accelerations(ESTIMATED_STAGES[description], positions, np.array([currents[0:m:2]]),
                          np.array([currents[1:m:2]]), constants)
    expected = [getattr(stage, name).acceleration for name in axes]
    assert found[0] == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_constants_are_in_one_row_each() -> None:
    for stage, count in (("2dof", 4), ("3dof", 5)):
        assert ESTIMATED_STAGES[stage].constants == tuple(f"C{k}" for k in range(1, count + 1))
        rows = regressors(ESTIMATED_STAGES[stage], np.full((3, len(ESTIMATED_STAGES[stage].axes)), 0.02),
                          np.ones((3, len(ESTIMATED_STAGES[stage].motors))),
                          np.ones((3, len(ESTIMATED_STAGES[stage].motors))),
                          np.zeros((3, len(ESTIMATED_STAGES[stage].axes))))
        assert [data.a.shape for data in rows] == [(3, len(row.constants)) for row in ESTIMATED_STAGES[stage].rows]


def test_shape_functions_are_pmlsm_bit_for_bit() -> None:
    gaps = np.random.default_rng(1).uniform(5e-3, 45e-3, 500)
    assert shape_functions(MOTOR, gaps).T.tolist() == [list(gap_functions(MOTOR, gap)) for gap in gaps.tolist()]


def test_observer_is_the_controllers() -> None:
    positions = np.random.default_rng(2).normal(0.02, 1e-3, (200, 2))
    shares, observer = ObserverFilter(), VelocityObserver()
    shares.prepare(0.5e-3)
    observer.seed(float(positions[0, 1]))
    expected = []
    for measured in positions[:, 1].tolist():
        observer.update(measured, shares, 0.5e-3)
        expected.append(observer.velocity)
    assert observed(positions, 0.5e-3)[:, 1].tolist() == expected


def test_matched_filter_has_the_delay_of_the_observer() -> None:
    """The observer's velocity is the exact difference of the matched position."""
    dt = 0.5e-3
    positions = np.cumsum(np.random.default_rng(3).normal(0.0, 1e-5, (300, 2)), axis=0)
    filtered = matched(positions, dt)
    assert observed(positions, dt)[1:] == pytest.approx(np.diff(filtered, axis=0) / dt, abs=1e-12)
    assert matched(np.full((5, 1), 3.0), dt) == pytest.approx(np.full((5, 1), 3.0), rel=1e-15)
