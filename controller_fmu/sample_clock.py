"""The sampling grid of a controller or an estimator."""

TOLERANCE = 1.0e-6    # on the number of communication steps in a sample
MOST_STEPS = 1.0e9    # in a sample; more are no step that anybody means, and would not fit an integer


class SampleClock:
    """Tells at which communication steps a controller or estimator samples: the first, then one every sample time."""

    def __init__(self) -> None:
        self.checked_step = 0.0   # s, communication step that was checked last
        self.divides = False      # true if it divides the sample time
        self.remaining = 0.0      # s, state: time until the next sample

    def fits(self, dt: float, sample_time: float) -> bool:
        """Return True if a communication step dt (s) divides the sample time (s) and does not step over a sample."""
        if dt != self.checked_step:
            self.checked_step = dt
            steps = sample_time / dt
            self.divides = False
            if steps < MOST_STEPS:
                whole = int(steps + 0.5)
                self.divides = whole >= 1 and whole - TOLERANCE * whole < steps < whole + TOLERANCE * whole
        # A step that is longer than those before it must not move the samples off their grid.
        return self.divides and (self.remaining < 0.5 * dt or dt < self.remaining * (1.0 + TOLERANCE))

    def due(self, dt: float, sample_time: float) -> bool:
        """Count the communication step dt (s); return True if a sample falls on its start."""
        sample = self.remaining < 0.5 * dt
        if sample:
            self.remaining = sample_time
        self.remaining -= dt
        return sample
