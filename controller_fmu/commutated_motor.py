"""Motor whose direct and quadrature current come from outside, and the displacement that it commutates with."""

from controller_fmu.motor_command import MotorCommand


class MeasuredDisplacement:
    """Axis of which only the measurement is needed."""

    def __init__(self) -> None:
        self.measured = 0.0        # m, input


class CommutatedMotor:
    """Motor, or pair wired in parallel, that is commanded the currents it is asked for, as far as the limit lets it."""

    def __init__(self) -> None:
        self.i_d_reference = 0.0   # A, input
        self.i_q_reference = 0.0   # A, input
        self.commands = MotorCommand()
        self.i_d_cmd = 0.0         # A, output, after the limit
        self.i_q_cmd = 0.0         # A, output, after the limit
        self.i_a_cmd = 0.0         # A, output
        self.i_b_cmd = 0.0         # A, output
        self.i_c_cmd = 0.0         # A, output
        self.saturated = False     # whether a reference is beyond the limit

    def commutate(self, limit: float, theta: float) -> None:
        """Command the references within ±limit (A; 0 = no limit), commutated at an electrical angle (rad), (C.1)."""
        commands = self.commands
        commands.command(self.i_d_reference, self.i_q_reference, limit, theta)
        self.i_d_cmd = commands.i_d_cmd
        self.i_q_cmd = commands.i_q_cmd
        self.i_a_cmd = commands.i_a_cmd
        self.i_b_cmd = commands.i_b_cmd
        self.i_c_cmd = commands.i_c_cmd
        self.saturated = commands.limited
