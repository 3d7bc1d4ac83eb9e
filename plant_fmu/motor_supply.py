"""Supply of one three-phase motor, or of a pair wired in parallel: three amplifiers and the mover's i_d and i_q."""

from math import fabs

from plant_fmu.current_amplifier import AmplifierRating, CurrentAmplifier
from plant_fmu.winding import Winding
from pmlsm.dq_transform import clarke, park, phase_currents
from pmlsm.electrical_angle import ElectricalAngle

START = 0    # points of an integration step, at which there are currents
MIDDLE = 1
END = 2


class MotorSupply:
    """Three independent amplifiers; i_d and i_q follow from the electrical angle at the true displacement (2.1), (4.4).

    The phases are independent, so that they may have a common part; it makes no force (assumed). Without current in
    one of them the others flow as before.
    """

    def __init__(self, peak: float, continuous: float, resistance: float, inductance: float, axis: int = 1,
                 group: int = 0):
        self.axis = axis      # number of the axis that the motor drives
        self.group = group    # number of its `MotorGroup`
        self.amplifier = AmplifierRating(peak, continuous)
        self.winding = Winding(resistance, inductance)
        self.i_a_cmd = 0.0      # A, input
        self.i_b_cmd = 0.0      # A, input
        self.i_c_cmd = 0.0      # A, input
        self.phases = [CurrentAmplifier(), CurrentAmplifier(), CurrentAmplifier()]   # a, b, c
        self.e_a = 0.0          # V, induced by the motion, where the bus has a voltage
        self.e_b = 0.0
        self.e_c = 0.0
        self.i_alpha = [0.0, 0.0, 0.0]   # A, stator-frame components at START, MIDDLE and END of an integration step
        self.i_beta = [0.0, 0.0, 0.0]
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
        a = self.phases[0]
        b = self.phases[1]
        c = self.phases[2]
        rating = self.amplifier
        rating.prepare(dt)
        if rating.stuck:
            for phase in self.phases:
                phase.hold(rating)
        elif rating.off:
            for phase in self.phases:
                phase.advance(0.0, rating)
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
            self.voltage = self.largest_voltage()
        if winding.thermal_resistance > 0.0:
            winding.warm(a.mean_square() + b.mean_square() + c.mean_square(), dt)
        self.i_alpha[START], self.i_beta[START] = clarke(a.current_start, b.current_start, c.current_start)
        self.i_alpha[MIDDLE], self.i_beta[MIDDLE] = clarke(a.current_middle, b.current_middle, c.current_middle)
        self.i_alpha[END], self.i_beta[END] = clarke(a.current, b.current, c.current)

    def largest_voltage(self) -> float:
        """Return the largest voltage (V) of a phase, without its sign."""
        largest = 0.0
        for phase in self.phases:
            voltage = fabs(phase.voltage)
            if voltage > largest:
                largest = voltage
        return largest

    def turn(self, point: int, angle: ElectricalAngle) -> None:
        """Set i_d and i_q to START, MIDDLE or END of the integration step, at an electrical angle."""
        self.i_d, self.i_q = park(self.i_alpha[point], self.i_beta[point], angle.sine, angle.cosine)

    def deliver(self) -> None:
        """Set the outputs at the end of a communication step."""
        self.i_a = self.phases[0].current
        self.i_b = self.phases[1].current
        self.i_c = self.phases[2].current
        self.saturated = False
        for phase in self.phases:
            if phase.saturated:
                self.saturated = True

    def resume(self, angle: ElectricalAngle) -> None:
        """Take over the phase currents of a continuous model, and compute i_d and i_q at an electrical angle."""
        self.phases[0].current = self.i_a
        self.phases[1].current = self.i_b
        self.phases[2].current = self.i_c
        self.i_alpha[END], self.i_beta[END] = clarke(self.i_a, self.i_b, self.i_c)
        self.turn(END, angle)

    def derive(self, bus: float) -> None:
        """Compute the rates of a continuous model with the voltage of the bus (V); 0 = no limit."""
        rating = self.amplifier
        winding = self.winding
        share = 0.0 if rating.off else 1.0
        self.phases[0].derive(share * self.i_a_cmd, rating, winding, self.e_a, bus)
        self.phases[1].derive(share * self.i_b_cmd, rating, winding, self.e_b, bus)
        self.phases[2].derive(share * self.i_c_cmd, rating, winding, self.e_c, bus)
        self.voltage = self.largest_voltage()
        winding.derive(self.i_a * self.i_a + self.i_b * self.i_b + self.i_c * self.i_c)

    def settle(self) -> bool:
        """Take in an event of a continuous model, whose rates are known; return True if a current has jumped."""
        jumps = False
        for phase in self.phases:
            if phase.settle(self.amplifier):
                jumps = True
        self.deliver()
        return jumps
