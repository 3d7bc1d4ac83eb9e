"""Place of a motor on a platform that tilts, and the air gap that is measured there."""


class MotorPlace:
    """A motor's row of J, gap = y − z roll + x pitch, and its column of S = (JᵀJ)⁻¹Jᵀ.

    S turns the gaps at the motors into one vertical motion: y, roll and pitch by least squares. Its transpose spreads a
    force and two torques over the motors with the smallest sum of squares.
    """

    def __init__(self, x: float, z: float, gap: float):
        self.x = x                  # m, parameter: from the centre of mass
        self.z = z                  # m, parameter
        self.gap_measured = gap     # m, input
        self.share_y = 1.0          # column of S
        self.share_roll = 0.0       # 1/m
        self.share_pitch = 0.0      # 1/m

    def moved(self, y: float, roll: float, pitch: float) -> float:
        """Return the displacement (m) at the motor for one (m) and tilts (rad) of the platform: its row of J."""
        return y - self.z * roll + self.x * pitch

    def carried(self, force: float, roll_torque: float, pitch_torque: float) -> float:
        """Return the motor's share of a force (N) and torques (N m) in N; in N/kg if these are for each kg."""
        return self.share_y * force + self.share_roll * roll_torque + self.share_pitch * pitch_torque
