"""Velocity from measured positions: the "high-gain observer" of Fig. 4.7."""

from pmlsm.exponential import exponential


class ObserverFilter:
    """Time constants of the observers of a controller or an estimator, and the filter coefficients of a sample.

    The thesis draws an approximate derivative and a low-pass filter; the time constants are assumed.
    """

    def __init__(self, time: float = 1.0e-3):
        self.time1 = time     # s, parameter: approximate derivative
        self.time2 = time     # s, parameter: low-pass filter
        self.share1 = 0.0     # a1, of the distance that a filter goes within one sample
        self.share2 = 0.0     # a2

    def prepare(self, sample_time: float) -> None:
        """Compute the filter shares of a sample time (s); a filter with time constant 0 follows at once."""
        self.share1 = 1.0
        if self.time1 > 0.0:
            self.share1 = 1.0 - exponential(-sample_time / self.time1)
        self.share2 = 1.0
        if self.time2 > 0.0:
            self.share2 = 1.0 - exponential(-sample_time / self.time2)


class VelocityObserver:
    """Filtered derivative of a measured position."""

    def __init__(self) -> None:
        self.position = 0.0   # m, state: low-passed measurement
        self.velocity = 0.0   # m/s, state and output

    def seed(self, measured: float) -> None:
        """Begin at rest at a measured position (m)."""
        self.position = measured
        self.velocity = 0.0

    def update(self, measured: float, observer_filter: ObserverFilter, sample_time: float) -> None:
        """Take in a measured position (m)."""
        # The share over the sample time, not 1/time1, is the exact gain of the sampled derivative.
        change = observer_filter.share1 * (measured - self.position)
        self.position += change
        self.velocity += observer_filter.share2 * (change / sample_time - self.velocity)
