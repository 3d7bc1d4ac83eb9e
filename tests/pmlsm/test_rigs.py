"""The description of the rigs against the page and the blocks."""

from collections.abc import Callable
from typing import Any

import pytest
from named_controllers import Regulator2DOF, Regulator3DOF
from named_stage import Stage2DOF, Stage3DOF

from maglev.descriptions.packaged import RIGS
from maglev.identification.model_file import CONSTANTS
from pmlsm.stage_description import Rig

RIG_2DOF = RIGS["2dof"]
RIG_3DOF = RIGS["3dof"]

both = pytest.mark.parametrize(("rig", "stage", "regulator"), [(RIG_2DOF, Stage2DOF, Regulator2DOF),
                                                               (RIG_3DOF, Stage3DOF, Regulator3DOF)])


@both
def test_blocks_have_what_the_rig_has(rig: Rig, stage: Callable[[], Any], regulator: Callable[[], Any]) -> None:
    for block in (stage(), regulator()):
        assert all(hasattr(block, name) for name in (
            *(constant.name for constant in rig.constants), *rig.axis_names, *rig.motor_names))
    assert regulator().sample_time == rig.sample_time
    assert [getattr(stage(), axis.name).mass for axis in rig.axes] == [axis.mass for axis in rig.axes]


@both
def test_a_motor_drives_its_axis_alone(rig: Rig, stage: Callable[[], Any], regulator: Callable[[], Any]) -> None:
    """A quadrature current in one motor accelerates the axis that it is said to drive, and no other horizontal one."""
    for motor in rig.motors:
        block = stage()
        block.start()
        getattr(block, motor.name).i_q = 1.0
        block.add_slope(0.0, 0.0)
        free = stage()
        free.start()
        free.add_slope(0.0, 0.0)
        moved = [axis.name for axis in rig.horizontal
                 if getattr(block, axis.name).acceleration != getattr(free, axis.name).acceleration]
        assert moved == [motor.drives]


@both
def test_a_constant_acts_on_its_axis_alone(rig: Rig, stage: Callable[[], Any], regulator: Callable[[], Any]) -> None:
    def accelerations(scaled: str = "") -> dict[str, float]:
        block = stage()
        block.start()
        for motor in rig.motor_names:
            getattr(block, motor).i_d = getattr(block, motor).i_q = 1.0
        if scaled:
            setattr(block, scaled, 1.1 * getattr(block, scaled))
        block.add_slope(0.0, 0.0)
        return {axis: getattr(block, axis).acceleration for axis in rig.axis_names}

    before = accelerations()
    for constant in rig.constants:
        after = accelerations(constant.name)
        assert [axis for axis in rig.axis_names if after[axis] != before[axis]] == [constant.axis]


def test_names_that_files_may_use() -> None:
    assert list(RIGS) == ["2dof", "3dof", "5dof"]
    assert tuple(constant.name for constant in RIG_3DOF.constants) == CONSTANTS
