"""Command to one motor: limit, then commutation at the electrical angle of the measured displacement (C.1)."""

from pmlsm.dq_transform import phase_currents
from pmlsm.saturation import saturate


class MotorCommand:
    """Commanded currents of one motor, or of a pair wired in parallel."""

    def __init__(self) -> None:
        self.i_d_cmd = 0.0       # A, output, after the limit
        self.i_q_cmd = 0.0       # A, output, after the limit
        self.i_a_cmd = 0.0       # A, output
        self.i_b_cmd = 0.0       # A, output
        self.i_c_cmd = 0.0       # A, output
        self.limited = False     # true if a command is at its limit
        self.excess_d = 0.0      # sat(i_d) − i_d, A
        self.excess_q = 0.0      # sat(i_q) − i_q, A

    def command(self, i_d: float, i_q: float, limit: float, theta: float) -> None:
        """Limit i_d and i_q (A) to ±limit (A; 0 = no limit) and commutate them at an electrical angle (rad)."""
        self.i_d_cmd = i_d
        self.i_q_cmd = i_q
        if limit > 0.0:
            self.i_d_cmd = saturate(i_d, limit)
            self.i_q_cmd = saturate(i_q, limit)
        self.excess_d = self.i_d_cmd - i_d
        self.excess_q = self.i_q_cmd - i_q
        self.limited = self.excess_d != 0.0 or self.excess_q != 0.0
        self.i_a_cmd, self.i_b_cmd, self.i_c_cmd = phase_currents(self.i_d_cmd, self.i_q_cmd, theta)

    def release(self) -> None:
        """Command no current."""
        self.command(0.0, 0.0, 0.0, 0.0)
