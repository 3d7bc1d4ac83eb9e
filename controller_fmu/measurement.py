"""Measurements of the encoders, as the controller of any stage receives them."""

from controller_fmu.measured_position import MeasuredPosition
from controller_fmu.sample_clock import SampleClock
from controller_fmu.sampled import Sampled
from controller_fmu.sampling_instant import NO_SEED, STEPPED, TOO_LATE, SamplingInstant
from pmlsm.stage_description import StageDescription


class Measurement(Sampled):
    """Samples encoders, and gives what the controller gets: later, with errors, or not at all."""

    def __init__(self, stage: StageDescription):
        gaps = [stage.vertical.start for _ in stage.motors if stage.rotations]   # where the platform tilts
        starts = [axis.start for axis in stage.measured] + gaps
        self.seed = 0.0                      # parameter: a whole number
        self.sample_time = stage.sample_time   # s, parameter
        self.instant = SamplingInstant()
        self.encoders = [MeasuredPosition(start, number) for number, start in enumerate(starts, 1)]
        # Encoders that measure an air gap: that of the mover, or those of the motors.
        self.gaps = [len(stage.measured) + number
                     for number in range(len(gaps))] or [stage.measured.index(stage.vertical)]
        self.clock = SampleClock()
        self.key = 0           # the seed
        self.number = 0        # state: of the sample
        self.started = False   # state: a measurement has come in

    def start(self) -> int:
        """Take in the seed and the delay; until the first sample the outputs equal the encoders."""
        self.key = int(self.seed)
        if self.key != self.seed:
            return NO_SEED
        if not self.instant.prepare(self.sample_time):
            return TOO_LATE
        self.begin()
        return STEPPED

    def begin(self) -> None:
        """Begin at rest where the encoders are."""
        for encoder in self.encoders:
            encoder.begin(self.instant)

    def sample(self) -> None:
        """Take in a sample of each encoder."""
        instant = self.instant
        if not self.started:
            self.begin()
            for number in self.gaps:
                if self.encoders[number].encoder <= 0.0:
                    return   # an importer that has not exchanged values yet: this is no measurement
            self.started = True
        if instant.late:
            instant.advance(self.key, self.number, self.sample_time)
        for encoder in self.encoders:
            encoder.sample(instant, self.key, self.number, self.sample_time)
        self.number += 1
