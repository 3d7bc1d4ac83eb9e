"""Rows of a platform that tilts: those of the stage's own motion, from gaps and currents of its motors."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from named_controllers import Estimator5DOF
from named_stage import Stage5DOF

from controller_fmu.status import BAD_PLACES, STEPPED

MOTORS = ("alpha1", "alpha2", "beta1", "beta2")
CURRENTS = st.lists(st.floats(-4.0, 4.0), min_size=8, max_size=8)


@given(st.floats(0.022, 0.028), st.floats(-5e-3, 5e-3), st.floats(-5e-3, 5e-3), CURRENTS)
def test_rows_are_the_motion_of_the_stage(gap: float, roll: float, pitch: float, currents: list[float]) -> None:
    """Without friction, bias, ripple and modulation, and at the nominal masses."""
    stage, estimator = Stage5DOF(), Estimator5DOF()
    stage.attraction_modulation = stage.encoder.resolution = 0.0
    for name, start in (("y", gap), ("x", 0.0), ("z", 0.0), ("roll", roll), ("pitch", pitch)):
        axis = getattr(stage, name)
        axis.position_start = start
        axis.bias = axis.friction.coulomb = axis.friction.viscous = axis.ripple.amplitude = 0.0
    assert stage.start() == estimator.start() == STEPPED
    for k, motor in enumerate(MOTORS):
        supply, taken = getattr(stage, motor), getattr(estimator, motor)
        supply.i_d, supply.i_q = taken.i_d, taken.i_q = currents[2 * k:2 * k + 2]
        getattr(estimator, f"{motor}_place").gap_measured = getattr(stage, f"{motor}_mount").gap_encoder
    estimator.x.begin()
    estimator.z.begin()
    estimator.sample()
    block = stage.block
    block.mover.push(block.axes, block.motors, block.magnetics)
    mounts = [getattr(stage, f"{motor}_mount") for motor in MOTORS]
    columns = np.array([estimator.rows.attraction, estimator.rows.coils, estimator.rows.iron])
    assert columns @ [stage.C3, stage.C4, stage.C5] == pytest.approx(sum(m.normal for m in mounts) / 6.9, rel=1e-9)
    assert stage.C1 * estimator.x.filter.output == pytest.approx((mounts[0].thrust + mounts[1].thrust) / 10.6, abs=1e-9)
    assert stage.C2 * estimator.z.filter.output == pytest.approx((mounts[2].thrust + mounts[3].thrust) / 8.6, abs=1e-9)
    assert estimator.y.measured == pytest.approx(gap, abs=1e-12)


def test_motors_on_one_line_are_refused() -> None:
    estimator = Estimator5DOF()
    for motor in MOTORS:
        getattr(estimator, f"{motor}_place").x = 0.0
    assert estimator.start() == BAD_PLACES
