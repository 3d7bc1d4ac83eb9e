"""PID of one axis, acting on a current (Figs. 4.6, 5.6), designed by pole placement."""

from controller_fmu.reference_prefilter import LARGEST_ANGLE, ReferencePrefilter
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver


class PIDAxis:
    """u = kp e + ki ∫e + kd ė, with e and ė against the filtered reference.

    The thesis tuned its gains by hand and prints none. Assumed: those that give the linearised axis a real pole and a
    complex pair. They are computed at the initialisation as long as the gains are left as they are; gains that are set
    are used as they are set.
    """

    def __init__(self, pole: float, pair_real: float, pair_imaginary: float, position: float):
        self.pole = pole                         # rad/s, parameter: real pole of the design
        self.pair_real = pair_real               # rad/s, parameter: real part of its pair of poles
        self.pair_imaginary = pair_imaginary     # rad/s, parameter: imaginary part
        self.kp = 0.0                            # A/m, parameter: gain of the error
        self.ki = 0.0                            # A/(m s), parameter: of its integral
        self.kd = 0.0                            # A s/m, parameter: of its rate
        self.prefilter = 0.0                     # rad/s, parameter: corner of the reference pre-filter, 0 = off
        self.reference = position                # m, input
        self.reference_rate = 0.0                # m/s, input
        self.measured = position                 # m, input
        self.observer = VelocityObserver()
        self.filter = ReferencePrefilter()
        self.integral = 0.0                      # m s, state
        self.error = 0.0                         # m, output: measured − reference
        self.deviation = 0.0                     # m: measured − filtered reference, the e of the law
        self.deviation_rate = 0.0                # m/s
        self.designed_kp = 0.0                   # of the last design
        self.designed_ki = 0.0
        self.designed_kd = 0.0

    def design(self, stiffness: float, gain: float) -> None:
        """Place the poles of δ'' = stiffness δ + gain u (1/s², m/(s² A)): s³ + a1 s² + a2 s + a3."""
        square = self.pair_real * self.pair_real + self.pair_imaginary * self.pair_imaginary
        a1 = -self.pole - 2.0 * self.pair_real
        a2 = square + 2.0 * self.pole * self.pair_real
        a3 = -self.pole * square
        kp = -(a2 + stiffness) / gain
        ki = -a3 / gain
        kd = -a1 / gain
        if self.kp == self.designed_kp and self.ki == self.designed_ki and self.kd == self.designed_kd:
            self.kp = kp
            self.ki = ki
            self.kd = kd
        self.designed_kp = kp
        self.designed_ki = ki
        self.designed_kd = kd

    def filterable(self, sample_time: float) -> bool:
        """Return True if the pre-filter is stable at a sample time (s)."""
        return self.prefilter * sample_time <= LARGEST_ANGLE

    def start(self, current: float) -> None:
        """Begin at the measurement, with the integral such that the first command is this current (A).

        The rate of the error is not compensated.
        """
        self.observer.seed(self.measured)
        self.filter.seed(self.reference)
        self.integral = 0.0
        if self.ki != 0.0:
            self.integral = (current - self.kp * (self.measured - self.reference)) / self.ki

    def sample(self, observer_filter: ObserverFilter, sample_time: float) -> None:
        """Take in measurement and reference."""
        self.observer.update(self.measured, observer_filter, sample_time)
        self.filter.update(self.reference, self.reference_rate, self.prefilter, sample_time)
        self.error = self.measured - self.reference
        self.deviation = self.measured - self.filter.position
        self.deviation_rate = self.observer.velocity - self.filter.rate

    def current(self) -> float:
        """Current that the law commands (A)."""
        return self.kp * self.deviation + self.ki * self.integral + self.kd * self.deviation_rate

    def update(self, sample_time: float, held: bool) -> None:
        """Advance the integral by one sample (s), unless it is held."""
        if not held:
            self.integral += sample_time * self.deviation
