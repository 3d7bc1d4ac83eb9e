"""Linear current amplifier module (LCAM), sections 4.1.3, 5.1.3 and 5.6.2."""

from math import fabs

from plant_fmu.winding import SHORTEST_LAG, Winding
from pmlsm.exponential import exponential
from pmlsm.saturation import saturate

DERATING_START = 0.9      # of the squared continuous current; assumed, as is the form of the derating
DERATING_RANGE = 0.1


class AmplifierRating:
    """Ratings that the three phases of a motor's amplifiers share.

    The thesis states the peak and the continuous current. Assumed: the I²t form of the continuous limit, its time
    constant and the lag. Each of these is off where its parameter is 0; the peak is above 0.
    """

    def __init__(self, peak: float, continuous: float):
        self.peak = peak                 # A, parameter
        self.continuous = continuous     # A, parameter
        self.thermal_time = 1.0          # s, parameter
        self.lag = 0.3e-3                # s, parameter
        self.off = False                 # parameter: a fault, the commands count as 0
        self.stuck = False               # parameter: a fault, the currents do not change
        self.prepared_step = 0.0         # s, integration step that the decays below belong to
        self.lag_decay = 0.0             # of the lag over one integration step
        self.lag_decay_middle = 0.0      # in its middle, for Simpson's rule
        self.heat_decay = 0.0            # of the heat over one integration step
        self.heat_decay_half = 0.0       # over half of it

    def prepare(self, dt: float) -> None:
        """Compute the exact decays over an integration step dt (s).

        The middle one is such that Simpson's rule gives the exact mean current: Runge–Kutta takes in a changing current
        by this rule, and the lag may be shorter than the step.
        """
        if dt != self.prepared_step:
            self.prepared_step = dt
            self.lag_decay = 0.0
            self.lag_decay_middle = 0.0
            if self.lag > 0.0:
                steps = dt / self.lag
                self.lag_decay = exponential(-steps)
                mean = (1.0 - self.lag_decay) / steps
                self.lag_decay_middle = (6.0 * mean - 1.0 - self.lag_decay) / 4.0
            self.heat_decay_half = 0.0
            if self.thermal_time > 0.0:
                self.heat_decay_half = exponential(-0.5 * dt / self.thermal_time)
            self.heat_decay = self.heat_decay_half * self.heat_decay_half

    def clamp(self, heat: float) -> float:
        """Largest phase current (A) at a low-passed squared current (A²).

        It falls linearly from the peak to the continuous rating as the heat goes from 0.9 to 1.0 of the squared
        continuous rating.
        """
        if self.continuous <= 0.0 or self.thermal_time <= 0.0 or self.continuous >= self.peak:
            return self.peak
        square = self.continuous * self.continuous
        if square <= 0.0:
            return self.continuous   # below 1e-162 A its square is no number above 0
        derating = (heat / square - DERATING_START) / DERATING_RANGE
        if derating <= 0.0:
            return self.peak
        if derating >= 1.0:
            return self.continuous
        return self.peak - derating * (self.peak - self.continuous)


class CurrentAmplifier:
    """Amplifier of one motor phase: the command is clamped, then followed with a first-order lag.

    Where the bus has a voltage, `limit` goes after `advance`.
    """

    def __init__(self) -> None:
        self.open = False          # parameter: a fault, no current can flow
        self.heat = 0.0            # A², state: low-passed square of the clamped command
        self.target = 0.0          # A, the clamped command
        self.current = 0.0         # A, state and output
        self.current_start = 0.0   # A, at the start of the last integration step
        self.current_middle = 0.0  # A, in its middle, for Simpson's rule
        self.started = False       # state: the lag starts at the first clamped command
        self.saturated = False     # output
        self.voltage = 0.0         # V, at the end of the last integration step; where the bus has one
        self.current_rate = 0.0    # A/s, in a continuous model
        self.heat_rate = 0.0       # A²/s
        self.margin = 1.0          # A or V that the clamp, or the bus, leaves: its sign changes at an event

    def advance(self, command: float, rating: AmplifierRating) -> None:
        """Follow a command (A) over the integration step that the rating is prepared for."""
        if self.open:
            self.current = 0.0
            self.hold(rating)
            return
        bound = rating.clamp(self.heat)
        clamped = saturate(command, bound)
        if bound < rating.peak:
            # The clamp moves during the step: take it at the middle, which is second-order accurate.
            square = clamped * clamped
            bound = rating.clamp(square + (self.heat - square) * rating.heat_decay_half)
            clamped = saturate(command, bound)
        self.saturated = command > bound or command < -bound
        if not self.started:
            self.started = True
            self.current = clamped
        self.target = clamped
        self.current_start = self.current
        self.current_middle = clamped + (self.current - clamped) * rating.lag_decay_middle
        self.current = clamped + (self.current - clamped) * rating.lag_decay
        square = clamped * clamped
        self.heat = square + (self.heat - square) * rating.heat_decay

    def hold(self, rating: AmplifierRating) -> None:
        """Keep the current over an integration step, whatever is commanded."""
        self.started = True
        self.saturated = False
        self.voltage = 0.0
        self.target = self.current
        self.current_start = self.current
        self.current_middle = self.current
        square = self.current * self.current
        self.heat = square + (self.heat - square) * rating.heat_decay

    def limit(self, rating: AmplifierRating, winding: Winding, induced: float, bus: float) -> None:
        """Take back what the voltage of the bus (V) does not drive against an induced one (V) in the last step."""
        if self.open or rating.stuck:
            return
        lag = rating.lag
        if lag < SHORTEST_LAG:
            lag = SHORTEST_LAG
        first = winding.demanded(self.current_start, self.target, lag, induced)
        last = winding.demanded(self.current, self.target, lag, induced)
        if not (-bus <= first <= bus and -bus <= last <= bus):
            self.saturated = True
            dt = rating.prepared_step
            self.current, charge = winding.follow(self.current_start, self.target, lag, induced, bus, dt)
            # Simpson's rule gives the exact mean current, as with the lag.
            self.current_middle = (6.0 * charge / dt - self.current_start - self.current) / 4.0
            last = saturate(winding.demanded(self.current, self.target, lag, induced), bus)
        self.voltage = last

    def derive(self, command: float, rating: AmplifierRating, winding: Winding, induced: float, bus: float) -> None:
        """Compute the rates of a continuous model: i' = (i* − i)/lag as far as the bus drives it, q' = (i*² − q)/T.

        A command and an induced voltage in A and V, the voltage of the bus in V (0 = no limit). A lag of 0 is the
        shortest one.
        """
        self.current_rate = 0.0
        self.heat_rate = 0.0
        self.voltage = 0.0
        self.margin = 1.0
        self.target = self.current
        if not (self.open or rating.stuck):
            bound = rating.clamp(self.heat)
            self.target = saturate(command, bound)
            self.margin = bound - fabs(command)
            lag = rating.lag
            if lag < SHORTEST_LAG:
                lag = SHORTEST_LAG
            self.current_rate = (self.target - self.current) / lag
            if bus > 0.0:
                demanded = winding.demanded(self.current, self.target, lag, induced)
                self.voltage = saturate(demanded, bus)
                self.current_rate += (self.voltage - demanded) / winding.inductance
                if bus - fabs(demanded) < self.margin:
                    self.margin = bus - fabs(demanded)
        if rating.thermal_time > 0.0:
            self.heat_rate = (self.target * self.target - self.heat) / rating.thermal_time

    def settle(self, rating: AmplifierRating) -> bool:
        """Take in an event of a continuous model, whose rates are known; return True if the current has jumped."""
        before = self.current
        if self.open:
            self.current = 0.0
        elif not (self.started or rating.stuck):
            self.current = self.target
        self.started = True
        self.saturated = self.margin < 0.0
        return self.current != before

    def mean_square(self) -> float:
        """Mean square of the current (A²) over the last integration step."""
        return (self.current_start * self.current_start + 4.0 * self.current_middle * self.current_middle
                + self.current * self.current) / 6.0
