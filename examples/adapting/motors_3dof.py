"""The feedback-linearised motors (5.7) of the 3-DOF stage, for adrc.py, l1_adaptive.py and directional_rls.py.

They keep to the language of blocks, so that these controllers can become native FMUs.
"""

from controller_fmu.feedback_linearisation import demanded_current
from controller_fmu.motor_command import MotorCommand
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.saturation import saturate
from pmlsm.velocity_rows import normal_acceleration, thrust_term


class Motors3DOF:
    """Conversion of demanded accelerations to currents, and of limited currents back to accelerations."""

    def __init__(self) -> None:
        # Constants of the thesis's regulator; the stage has others.
        self.C1 = 0.6135         # m/(s² A), thrust along x
        self.C2 = 0.8224         # m/(s² A), thrust along z
        self.C3 = 327.5          # m/(s² T²), magnets on iron
        self.C4 = 8.48           # m/(s² A T), magnets on coils
        self.C5 = 0.007          # m/(s² A²), coils on iron
        self.limit = 4.0         # A, parameter: of i_d and i_q, as in the thesis's regulator (section 5.6.2)
        self.as_limited = False  # true if i_d compensates i_q after its limit, not the demanded i_q
        self.geometry = MotorGeometry()
        self.f1 = 1.0            # shape functions at the measured gap
        self.f2 = 0.0
        self.f3 = 1.0
        self.f4 = 0.0
        self.y = 0.0             # m/s², by the limited currents
        self.x = 0.0
        self.z = 0.0

    def start(self) -> None:
        """Compute what follows from the geometry of the motors."""
        self.geometry.prepare()

    def command(self, alpha: MotorCommand, beta: MotorCommand, y: float, x: float, z: float, gap: float, place_x: float,
                place_z: float) -> None:
        """Command the currents for accelerations of y, x, z (m/s²) at a measured gap and places (m)."""
        self.f1, self.f2, self.f3, self.f4 = gap_functions(self.geometry, gap)
        i_q_x = -x / (2.0 * self.C1 * self.f1)
        i_q_z = -z / (2.0 * self.C2 * self.f1)
        seen_x = i_q_x
        seen_z = i_q_z
        if self.as_limited:
            seen_x = saturate(i_q_x, self.limit)
            seen_z = saturate(i_q_z, self.limit)
        i_d, _ = demanded_current(y, 2.0 * self.C5 * self.f4 * (seen_x * seen_x + seen_z * seen_z), 4.0 * self.C3,
                                  4.0 * self.C4, 4.0 * self.C5, self.f2, self.f3, self.f4)
        alpha.command(i_d, i_q_x, self.limit, self.geometry.electrical_angle(place_x))
        beta.command(i_d, i_q_z, self.limit, self.geometry.electrical_angle(place_z))
        direct = alpha.i_d_cmd
        squares = direct * direct + 0.5 * (alpha.i_q_cmd * alpha.i_q_cmd + beta.i_q_cmd * beta.i_q_cmd)
        self.y = normal_acceleration(4.0 * self.C3, 4.0 * self.C4, 4.0 * self.C5, self.f2, self.f3, self.f4, direct,
                                     squares)
        self.x = thrust_term(2.0 * self.C1, self.f1, alpha.i_q_cmd)
        self.z = thrust_term(2.0 * self.C2, self.f1, beta.i_q_cmd)
