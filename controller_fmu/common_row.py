"""Columns of A(y, u) by motors that are alike and have one air gap."""

from controller_fmu.level_platform import LevelPlatform
from controller_fmu.motor_current import MotorCurrent
from controller_fmu.motor_layout import MotorLayout
from pmlsm.gap_functions import gap_functions
from pmlsm.stage_description import StageDescription
from pmlsm.velocity_rows import normal_terms, thrust_term

NONE = -0.0   # first value of a sum: the sum of it and one term is exactly the term, even if that is −0


class CommonRow:
    """The vertical row by the sums of all currents, and the column of each horizontal axis."""

    def __init__(self, stage: StageDescription):
        self.carrying = stage.carrying                      # motors that carry the mover
        self.attraction = 0.0                             # columns of the vertical row
        self.coils = 0.0
        self.iron = 0.0
        self.thrust = [0.0 for _ in stage.horizontal]       # and of the horizontal ones

    def collect(self, layout: MotorLayout, motors: list[MotorCurrent], platform: LevelPlatform, gap: float) -> None:
        """Compute the columns at an air gap (m)."""
        sharing = layout.sharing
        thrust = self.thrust
        f1, f2, f3, f4 = gap_functions(layout.kinds[0].geometry, gap)
        direct = NONE
        squares = 0.0
        for k in range(len(thrust)):
            thrust[k] = NONE
        for motor, k in zip(motors, layout.drives, strict=True):
            direct += motor.i_d
            squares = squares + motor.i_q * motor.i_q + motor.i_d * motor.i_d
            thrust[k] += motor.i_q
        for k in range(len(thrust)):
            thrust[k] = thrust_term(sharing, f1, thrust[k])
        self.attraction, self.coils, self.iron = normal_terms(self.carrying, sharing, sharing, f2, f3, f4, direct,
                                                              squares)
