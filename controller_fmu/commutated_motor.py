"""Motor whose direct and quadrature current come from outside, and the displacement that it commutates with."""

from controller_fmu.motor_command import MotorCommand


class MeasuredDisplacement:
    """An axis that is only measured."""

    def __init__(self) -> None:
        self.measured = 0.0        # m, input


class CommutatedMotor:
    """Motor, or pair wired in parallel, that is commanded the currents it is asked for, as far as the limit lets it."""

    def __init__(self) -> None:
        self.i_d_reference = 0.0   # A, input
        self.i_q_reference = 0.0   # A, input
        self.command = MotorCommand()

    def commutate(self, limit: float, theta: float) -> bool:
        """Command the references within ±limit (A; 0 = no limit), commutated at an electrical angle (rad), (C.1).

        Returns whether a reference is beyond the limit.
        """
        self.command.command(self.i_d_reference, self.i_q_reference, limit, theta)
        return self.command.limited
