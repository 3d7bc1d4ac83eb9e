"""Windings of a motor: the current that a limited voltage drives through them, and how warm they get."""

from pmlsm.exponential import exponential, exponential_minus_one
from pmlsm.logarithm import logarithm

COPPER = 3.93e-3       # 1/K, by which the resistance of copper grows from that at 20 °C
SHORTEST_LAG = 1.0e-9  # s; where the voltage is limited, a lag of 0 is this one


class Winding:
    """Three phases with u = R i + L di/dt + e, |u| ≤ the bus voltage; e is induced by the motion.

    The amplifier demands (i* − i)/lag of di/dt, and gets what the voltage allows: without a limit, or where there is
    voltage enough, that is the lag exactly. Assumed: R and L (estimated in docs/model.md), one L for all three phases
    and any air gap, no mutual inductance, amplifiers that know e, and equal temperatures of all phases.
    """

    def __init__(self, resistance: float, inductance: float):
        self.resistance = resistance    # R, ohm, parameter: cold, of a phase as its amplifier sees it
        self.inductance = inductance    # L, H, parameter
        self.thermal_resistance = 0.0   # K/W, parameter: from the windings to their surroundings; 0 = they stay as warm
        self.thermal_time = 600.0       # s, parameter
        self.rise = 0.0                 # K, state and output: above the temperature at which R holds
        self.rise_rate = 0.0            # K/s, in a continuous model

    def present_resistance(self) -> float:
        """Resistance (ohm) at the present temperature."""
        return self.resistance * (1.0 + COPPER * self.rise)

    def warm(self, squares: float, dt: float) -> None:
        """Take in the loss R Σi² of a mean of the squared currents (A²) over a time dt (s): one time constant."""
        final = self.thermal_resistance * self.present_resistance() * squares
        if self.thermal_time > 0.0:
            self.rise = final + (self.rise - final) * exponential(-dt / self.thermal_time)
        else:
            self.rise = final

    def derive(self, squares: float) -> None:
        """Compute the rate of the rise by the squared currents (A²), in a continuous model."""
        self.rise_rate = 0.0
        if self.thermal_resistance > 0.0:
            time = self.thermal_time
            if time < SHORTEST_LAG:
                time = SHORTEST_LAG
            self.rise_rate = (self.thermal_resistance * self.present_resistance() * squares - self.rise) / time

    def demanded(self, current: float, target: float, lag: float, induced: float) -> float:
        """Voltage (V) by which a current (A) follows a target (A) with a lag (s) against an induced voltage (V)."""
        return self.present_resistance() * current + self.inductance * (target - current) / lag + induced

    def follow(self, current: float, target: float, lag: float, induced: float, voltage: float,
               dt: float) -> tuple[float, float]:
        """Follow a target with a limited voltage.

        di/dt = (i* − i)/T within (±V − e − R i)/L, solved exactly with constant e. i moves in one direction, along
        exponentials of the time constants T and L/R, between which it changes at most twice.

        Parameters
        ----------
        current, target : float
            i at the start and i*, A.
        lag : float
            T, s, above 0.
        induced, voltage : float
            e and V, V.
        dt : float
            s.

        Returns
        -------
        current, charge : float
            At the end, A, and its integral over the time, A s.
        """
        resistance = self.present_resistance()
        slow = self.inductance / resistance
        fall = resistance - self.inductance / lag   # of the demanded voltage, by the current
        unlimited = induced + self.inductance * target / lag
        demand = self.demanded(current, target, lag, induced)
        side = 0   # of the voltage that is at its limit: 1 the upper one, -1 the lower one, 0 none
        if demand > voltage:
            side = 1
        elif demand < -voltage:
            side = -1
        charge = 0.0
        left = dt
        for part in range(3):
            if left > 0.0:
                rest = target   # where the current would end
                time_constant = lag
                if side != 0:
                    rest = (side * voltage - induced) / resistance
                    time_constant = slow
                time = left
                next_side = side
                bound = current
                if part < 2 and fall != 0.0:
                    for limit in range(-1, 2, 2):
                        if side == 0 or side == limit:
                            edge = (limit * voltage - unlimited) / fall   # the demand is at this limit there
                            if (edge - current) * (rest - edge) > 0.0:
                                meeting = time_constant * logarithm((rest - current) / (rest - edge))
                                if meeting < time:
                                    time = meeting
                                    bound = edge
                                    next_side = limit - side
                end = bound if time < left else (
                    current - (rest - current) * exponential_minus_one(-time / time_constant))
                charge += rest * time + (current - end) * time_constant
                current = end
                side = next_side
                left -= time
        return current, charge
