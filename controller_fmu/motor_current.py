"""Delivered current of one motor, or of a pair wired in parallel, as the estimator takes it in."""


class MotorCurrent:
    """Direct and quadrature current."""

    def __init__(self) -> None:
        self.i_d = 0.0   # A, input
        self.i_q = 0.0   # A, input
