"""The description of the stages against the page and the blocks."""

from collections.abc import Callable
from typing import Any

import pytest
from named_controllers import Regulator2DOF, Regulator3DOF
from named_stage import Stage2DOF, Stage3DOF

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.identification.model_file import CONSTANTS
from pmlsm.stage_description import StageDescription

STAGE_2DOF = PACKAGED_STAGES["2dof"]
STAGE_3DOF = PACKAGED_STAGES["3dof"]

both = pytest.mark.parametrize(("description", "stage", "regulator"), [(STAGE_2DOF, Stage2DOF, Regulator2DOF),
                                                               (STAGE_3DOF, Stage3DOF, Regulator3DOF)])


@both
def test_blocks_have_what_the_stage_has(description: StageDescription, stage: Callable[[], Any],
                                        regulator: Callable[[], Any]) -> None:
    for block in (stage(), regulator()):
        assert all(hasattr(block, name) for name in (
            *(constant.name for constant in description.constants), *description.axis_names, *description.motor_names))
    assert regulator().sample_time == description.sample_time
    assert [getattr(stage(), axis.name).mass for axis in description.axes] == [axis.mass for axis in description.axes]


@both
def test_a_motor_drives_its_axis_alone(description: StageDescription, stage: Callable[[], Any],
                                       regulator: Callable[[], Any]) -> None:
    """A quadrature current in one motor accelerates the axis that it is said to drive, and no other horizontal one."""
    for motor in description.motors:
        block = stage()
        block.start()
        getattr(block, motor.name).i_q = 1.0
        block.add_slope(0.0, 0.0)
        free = stage()
        free.start()
        free.add_slope(0.0, 0.0)
        moved = [axis.name for axis in description.horizontal
                 if getattr(block, axis.name).acceleration != getattr(free, axis.name).acceleration]
        assert moved == [motor.drives]


@both
def test_a_constant_acts_on_its_axis_alone(description: StageDescription, stage: Callable[[], Any],
                                           regulator: Callable[[], Any]) -> None:
    def accelerations(scaled: str = "") -> dict[str, float]:
        block = stage()
        block.start()
        for motor in description.motor_names:
            getattr(block, motor).i_d = getattr(block, motor).i_q = 1.0
        if scaled:
            setattr(block, scaled, 1.1 * getattr(block, scaled))
        block.add_slope(0.0, 0.0)
        return {axis: getattr(block, axis).acceleration for axis in description.axis_names}

    before = accelerations()
    for constant in description.constants:
        after = accelerations(constant.name)
        assert [axis for axis in description.axis_names if after[axis] != before[axis]] == [constant.axis]


def test_names_that_files_may_use() -> None:
    assert list(PACKAGED_STAGES) == ["2dof", "3dof", "5dof"]
    assert tuple(constant.name for constant in STAGE_3DOF.constants) == CONSTANTS
