"""What the controller of the 5-DOF stage gets of its encoders."""

from controller_fmu.sample_clock import SampleClock
from measurement_fmu.measured_position import MeasuredPosition
from measurement_fmu.sampling_instant import NO_SEED, STEP_MISFIT, STEPPED, TOO_LATE, SamplingInstant


class Measurement5DOF:
    """Samples encoders, and gives what the controller gets: later, with errors, or not at all."""

    def __init__(self) -> None:
        self.seed = 0.0            # parameter: a whole number
        self.sample_time = 0.0002  # s, parameter
        self.instant = SamplingInstant()
        self.x = MeasuredPosition(0.0, 1)
        self.z = MeasuredPosition(0.0, 2)
        self.alpha1 = MeasuredPosition(0.025, 3)
        self.alpha2 = MeasuredPosition(0.025, 4)
        self.beta1 = MeasuredPosition(0.025, 5)
        self.beta2 = MeasuredPosition(0.025, 6)
        self.clock = SampleClock()
        self.key = 0           # the seed
        self.number = 0        # state: of the sample
        self.started = False   # state: a measurement has come in

    def start(self) -> int:
        """Take in the seed and the delay; until the first sample the encoders are given as they are."""
        self.key = int(self.seed)
        if self.key != self.seed:
            return NO_SEED
        if not self.instant.prepare(self.sample_time):
            return TOO_LATE
        self.x.begin(self.instant)
        self.z.begin(self.instant)
        self.alpha1.begin(self.instant)
        self.alpha2.begin(self.instant)
        self.beta1.begin(self.instant)
        self.beta2.begin(self.instant)
        return STEPPED

    def step(self, t: float, dt: float) -> int:
        """Sample if the sampling grid has a point at t; the measurements hold over t to t + dt (s)."""
        if not self.clock.fits(dt, self.sample_time):
            return STEP_MISFIT
        if self.clock.due(dt, self.sample_time):
            self.sample()
        return STEPPED

    def sample(self) -> None:
        """Take in a sample of each encoder."""
        instant = self.instant
        if not self.started:
            self.x.begin(instant)
            self.z.begin(instant)
            self.alpha1.begin(instant)
            self.alpha2.begin(instant)
            self.beta1.begin(instant)
            self.beta2.begin(instant)
            if (self.alpha1.encoder <= 0.0 or self.alpha2.encoder <= 0.0 or self.beta1.encoder <= 0.0
                    or self.beta2.encoder <= 0.0):
                return   # an importer that has not exchanged values yet: this is no measurement
            self.started = True
        if instant.late:
            instant.advance(self.key, self.number, self.sample_time)
        self.x.sample(instant, self.key, self.number, self.sample_time)
        self.z.sample(instant, self.key, self.number, self.sample_time)
        self.alpha1.sample(instant, self.key, self.number, self.sample_time)
        self.alpha2.sample(instant, self.key, self.number, self.sample_time)
        self.beta1.sample(instant, self.key, self.number, self.sample_time)
        self.beta2.sample(instant, self.key, self.number, self.sample_time)
        self.number += 1
