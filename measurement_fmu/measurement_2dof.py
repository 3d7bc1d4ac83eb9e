"""What the controller of the 2-DOF stage gets of its encoders."""

from controller_fmu.sample_clock import SampleClock
from measurement_fmu.measured_position import MeasuredPosition
from measurement_fmu.sampling_instant import NO_SEED, STEP_MISFIT, STEPPED, TOO_LATE, SamplingInstant


class Measurement2DOF:
    """Samples encoders, and gives what the controller gets: later, with errors, or not at all."""

    def __init__(self) -> None:
        self.seed = 0.0            # parameter: a whole number
        self.sample_time = 0.0005  # s, parameter
        self.instant = SamplingInstant()
        self.v = MeasuredPosition(0.02, 1)
        self.h = MeasuredPosition(0.0, 2)
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
        self.v.begin(self.instant)
        self.h.begin(self.instant)
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
            self.v.begin(instant)
            self.h.begin(instant)
            if self.v.encoder <= 0.0:
                return   # an importer that has not exchanged values yet: this is no measurement
            self.started = True
        if instant.late:
            instant.advance(self.key, self.number, self.sample_time)
        self.v.sample(instant, self.key, self.number, self.sample_time)
        self.h.sample(instant, self.key, self.number, self.sample_time)
        self.number += 1
