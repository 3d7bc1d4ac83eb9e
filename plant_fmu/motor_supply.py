"""Supply of one three-phase motor, or of a pair wired in parallel: three amplifiers and what the mover sees."""

from plant_fmu.current_amplifier import AmplifierRating, CurrentAmplifier
from pmlsm.dq_transform import clarke, park


class MotorSupply:
    """Three independent amplifiers; i_d and i_q follow from the electrical angle at the true displacement (2.1), (4.4).

    The phases are independent, so that they may have a common part; it makes no force (assumed).
    """

    def __init__(self, peak: float, continuous: float):
        self.amplifier = AmplifierRating(peak, continuous)
        self.i_a_cmd = 0.0      # A, input
        self.i_b_cmd = 0.0      # A, input
        self.i_c_cmd = 0.0      # A, input
        self.phase_a = CurrentAmplifier()
        self.phase_b = CurrentAmplifier()
        self.phase_c = CurrentAmplifier()
        self.start_alpha = 0.0    # A, stator-frame components at the start of an integration step
        self.start_beta = 0.0
        self.middle_alpha = 0.0   # in its middle
        self.middle_beta = 0.0
        self.end_alpha = 0.0      # at its end
        self.end_beta = 0.0
        self.i_a = 0.0          # A, output, delivered
        self.i_b = 0.0          # A, output
        self.i_c = 0.0          # A, output
        self.i_d = 0.0          # A, output, and at the integration point while a step is computed
        self.i_q = 0.0          # A, output, likewise
        self.saturated = False  # output

    def advance(self, dt: float) -> None:
        """Follow the commands over one integration step dt (s)."""
        a = self.phase_a
        b = self.phase_b
        c = self.phase_c
        rating = self.amplifier
        rating.prepare(dt)
        a.advance(self.i_a_cmd, rating)
        b.advance(self.i_b_cmd, rating)
        c.advance(self.i_c_cmd, rating)
        self.start_alpha, self.start_beta = clarke(a.current_start, b.current_start, c.current_start)
        self.middle_alpha, self.middle_beta = clarke(a.current_middle, b.current_middle, c.current_middle)
        self.end_alpha, self.end_beta = clarke(a.current, b.current, c.current)

    def at_start(self, theta: float) -> None:
        """Set i_d and i_q to the start of the integration step, at an electrical angle (rad)."""
        self.i_d, self.i_q = park(self.start_alpha, self.start_beta, theta)

    def at_middle(self, theta: float) -> None:
        """Set i_d and i_q to the middle of the integration step, at an electrical angle (rad)."""
        self.i_d, self.i_q = park(self.middle_alpha, self.middle_beta, theta)

    def at_end(self, theta: float) -> None:
        """Set i_d and i_q to the end of the integration step, at an electrical angle (rad)."""
        self.i_d, self.i_q = park(self.end_alpha, self.end_beta, theta)

    def deliver(self, theta: float) -> None:
        """Set the outputs at the end of a communication step, at an electrical angle (rad)."""
        self.at_end(theta)
        self.i_a = self.phase_a.current
        self.i_b = self.phase_b.current
        self.i_c = self.phase_c.current
        self.saturated = self.phase_a.saturated or self.phase_b.saturated or self.phase_c.saturated
