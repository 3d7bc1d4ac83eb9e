"""Columns of A(y, u) by motors that have each its own air gap."""

from estimator_fmu.motor_current import MotorCurrent
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.motor_ratio import MotorRatio
from pmlsm.velocity_rows import normal_terms, thrust_acceleration


class MotorRows:
    """The vertical row as the sum over the motors, and the thrust of each."""

    def __init__(self, sharing: float):
        self.sharing = sharing     # motors that share each current
        self.attraction = 0.0      # columns of the vertical row
        self.coils = 0.0
        self.iron = 0.0

    def clear(self) -> None:
        """Begin with no motor."""
        self.attraction = 0.0
        self.coils = 0.0
        self.iron = 0.0

    def add(self, geometry: MotorGeometry, gap: float, motor: MotorCurrent) -> float:
        """Take in a motor at its gap (m); returns its part of the column of the axis that it drives."""
        f1, f2, f3, f4 = gap_functions(geometry, gap)
        attraction, coils, iron = normal_terms(self.sharing, self.sharing, self.sharing, f2, f3, f4, motor.i_d,
                                               motor.i_q * motor.i_q + motor.i_d * motor.i_d)
        self.attraction += attraction
        self.coils += coils
        self.iron += iron
        return thrust_acceleration(self.sharing, f1, motor.i_q)

    def add_kind(self, geometry: MotorGeometry, ratio: MotorRatio, gap: float, motor: MotorCurrent) -> float:
        """Take in a motor that is unlike the others, whose constants are in a ratio to theirs; as of `add`."""
        f1, f2, f3, f4 = gap_functions(geometry, gap)
        attraction, coils, iron = normal_terms(
            self.sharing * ratio.attraction, self.sharing * ratio.coils, self.sharing * ratio.iron, f2, f3, f4,
            motor.i_d, motor.i_q * motor.i_q + motor.i_d * motor.i_d)
        self.attraction += attraction
        self.coils += coils
        self.iron += iron
        return thrust_acceleration(self.sharing * ratio.thrust, f1, motor.i_q)
