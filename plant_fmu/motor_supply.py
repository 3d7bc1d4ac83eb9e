"""Supply of one three-phase motor, or of a pair wired in parallel: three amplifiers and what the mover sees."""

from math import fabs

from plant_fmu.current_amplifier import AmplifierRating, CurrentAmplifier
from plant_fmu.winding import Winding
from pmlsm.dq_transform import clarke, park, phase_currents
from pmlsm.electrical_angle import ElectricalAngle


def larger(one: float, other: float) -> float:
    """The larger of two numbers."""
    return one if one > other else other


class MotorSupply:
    """Three independent amplifiers; i_d and i_q follow from the electrical angle at the true displacement (2.1), (4.4).

    The phases are independent, so that they may have a common part; it makes no force (assumed). Without current in
    one of them the others flow as before.
    """

    def __init__(self, peak: float, continuous: float, resistance: float, inductance: float):
        self.amplifier = AmplifierRating(peak, continuous)
        self.winding = Winding(resistance, inductance)
        self.i_a_cmd = 0.0      # A, input
        self.i_b_cmd = 0.0      # A, input
        self.i_c_cmd = 0.0      # A, input
        self.phase_a = CurrentAmplifier()
        self.phase_b = CurrentAmplifier()
        self.phase_c = CurrentAmplifier()
        self.e_a = 0.0          # V, induced by the motion, where the bus has a voltage
        self.e_b = 0.0
        self.e_c = 0.0
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
        self.voltage = 0.0      # V, output
        self.saturated = False  # output

    def induce(self, theta: float, gap_rate: float, velocity: float, thrust: float, coils: float, iron: float) -> None:
        """Set the voltages that the motion induces, from the forces: their power is that of the forces.

        3/2 (e_d i_d + e_q i_q) = N g' + T v with N = coils i_d − iron (i_d² + i_q²), T = −thrust i_q. The currents are
        those at the end of the last integration step.

        Parameters
        ----------
        theta : float
            Electrical angle, rad.
        gap_rate, velocity : float
            g' and v, m/s.
        thrust, coils, iron : float
            At the gap: N/A, N/A, N/A².
        """
        e_d = (coils - iron * self.i_d) * gap_rate / 1.5
        e_q = (-thrust * velocity - iron * self.i_q * gap_rate) / 1.5
        self.e_a, self.e_b, self.e_c = phase_currents(e_d, e_q, theta)

    def advance(self, dt: float, bus: float) -> None:
        """Follow the commands over one integration step dt (s) with the voltage of the bus (V); 0 = no limit."""
        a = self.phase_a
        b = self.phase_b
        c = self.phase_c
        rating = self.amplifier
        rating.prepare(dt)
        if rating.stuck:
            a.hold(rating)
            b.hold(rating)
            c.hold(rating)
        elif rating.off:
            a.advance(0.0, rating)
            b.advance(0.0, rating)
            c.advance(0.0, rating)
        else:
            a.advance(self.i_a_cmd, rating)
            b.advance(self.i_b_cmd, rating)
            c.advance(self.i_c_cmd, rating)
        winding = self.winding
        self.voltage = 0.0
        if bus > 0.0:
            a.limit(rating, winding, self.e_a, bus)
            b.limit(rating, winding, self.e_b, bus)
            c.limit(rating, winding, self.e_c, bus)
            self.voltage = larger(larger(fabs(a.voltage), fabs(b.voltage)), fabs(c.voltage))
        if winding.thermal_resistance > 0.0:
            winding.warm(a.mean_square() + b.mean_square() + c.mean_square(), dt)
        self.start_alpha, self.start_beta = clarke(a.current_start, b.current_start, c.current_start)
        self.middle_alpha, self.middle_beta = clarke(a.current_middle, b.current_middle, c.current_middle)
        self.end_alpha, self.end_beta = clarke(a.current, b.current, c.current)

    def resume(self, angle: ElectricalAngle) -> None:
        """Take the phase currents, as they are in a continuous model; i_d and i_q at an electrical angle."""
        self.phase_a.current = self.i_a
        self.phase_b.current = self.i_b
        self.phase_c.current = self.i_c
        self.end_alpha, self.end_beta = clarke(self.i_a, self.i_b, self.i_c)
        self.at_end(angle)

    def derive(self, bus: float) -> None:
        """Compute the rates of a continuous model with the voltage of the bus (V); 0 = no limit."""
        a = self.phase_a
        b = self.phase_b
        c = self.phase_c
        rating = self.amplifier
        winding = self.winding
        share = 1.0
        if rating.off:
            share = 0.0
        a.derive(share * self.i_a_cmd, rating, winding, self.e_a, bus)
        b.derive(share * self.i_b_cmd, rating, winding, self.e_b, bus)
        c.derive(share * self.i_c_cmd, rating, winding, self.e_c, bus)
        self.voltage = larger(larger(fabs(a.voltage), fabs(b.voltage)), fabs(c.voltage))
        winding.derive(self.i_a * self.i_a + self.i_b * self.i_b + self.i_c * self.i_c)

    def settle(self) -> bool:
        """Take in an event of a continuous model, whose rates are known; whether a current has jumped."""
        rating = self.amplifier
        a = self.phase_a
        b = self.phase_b
        c = self.phase_c
        jump_a = a.settle(rating)
        jump_b = b.settle(rating)
        jump_c = c.settle(rating)
        self.i_a = a.current
        self.i_b = b.current
        self.i_c = c.current
        self.saturated = a.saturated or b.saturated or c.saturated
        return jump_a or jump_b or jump_c

    def at_start(self, angle: ElectricalAngle) -> None:
        """Set i_d and i_q to the start of the integration step, at an electrical angle."""
        self.i_d, self.i_q = park(self.start_alpha, self.start_beta, angle.sine, angle.cosine)

    def at_middle(self, angle: ElectricalAngle) -> None:
        """Set i_d and i_q to the middle of the integration step, at an electrical angle."""
        self.i_d, self.i_q = park(self.middle_alpha, self.middle_beta, angle.sine, angle.cosine)

    def at_end(self, angle: ElectricalAngle) -> None:
        """Set i_d and i_q to the end of the integration step, at an electrical angle."""
        self.i_d, self.i_q = park(self.end_alpha, self.end_beta, angle.sine, angle.cosine)

    def deliver(self, angle: ElectricalAngle) -> None:
        """Set the outputs at the end of a communication step, at an electrical angle."""
        self.at_end(angle)
        self.i_a = self.phase_a.current
        self.i_b = self.phase_b.current
        self.i_c = self.phase_c.current
        self.saturated = self.phase_a.saturated or self.phase_b.saturated or self.phase_c.saturated
