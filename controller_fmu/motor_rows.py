"""Columns of A(y, u) by motors that differ, or have separate air gaps."""

from controller_fmu.common_row import NONE
from controller_fmu.level_platform import LevelPlatform
from controller_fmu.motor_current import MotorCurrent
from controller_fmu.motor_layout import MotorLayout
from controller_fmu.tilting_platform import TiltingPlatform
from pmlsm.gap_functions import gap_functions
from pmlsm.stage_description import StageDescription
from pmlsm.velocity_rows import normal_terms, thrust_term


class MotorRows:
    """The vertical row as the sum over the motors, and the column of each horizontal axis."""

    def __init__(self, stage: StageDescription):
        self.attraction = 0.0                             # columns of the vertical row
        self.coils = 0.0
        self.iron = 0.0
        self.thrust = [0.0 for _ in stage.horizontal]       # and of the horizontal ones

    def collect(self, layout: MotorLayout, motors: list[MotorCurrent], platform: LevelPlatform | TiltingPlatform,
                gap: float) -> None:
        """Compute the columns; `gap` is that of the encoder, where there is one (m)."""
        sharing = layout.sharing
        thrust = self.thrust
        self.attraction = 0.0
        self.coils = 0.0
        self.iron = 0.0
        for k in range(len(thrust)):
            thrust[k] = NONE
        for number in layout.by_axis:
            motor = motors[number]
            kind = layout.kinds[layout.kind[number]]
            ratio = kind.ratio
            k = layout.drives[number]
            f1, f2, f3, f4 = gap_functions(kind.geometry, platform.gap(number, gap))
            attraction, coils, iron = normal_terms(
                sharing * ratio.attraction, sharing * ratio.coils, sharing * ratio.iron, f2, f3, f4, motor.i_d,
                motor.i_q * motor.i_q + motor.i_d * motor.i_d)
            self.attraction += attraction
            self.coils += coils
            self.iron += iron
            thrust[k] += thrust_term(sharing * ratio.thrust, f1, motor.i_q)
