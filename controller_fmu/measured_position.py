"""One encoder as the controller reads it, with its assumed errors, each off at zero."""

from controller_fmu.interpolation_error import InterpolationError
from controller_fmu.sampling_instant import SLOTS, SamplingInstant
from pmlsm.normal_variate import normal_variate
from pmlsm.random_words import SHARE, random_words


class MeasuredPosition:
    """Measured = position at the sampling instant + interpolation error + offset + drift + white noise; or as before.

    It stays as it was at a sample that is lost, and while it is frozen.
    """

    def __init__(self, position: float, stream: int):
        self.encoder = position    # m, input
        self.noise = 0.0           # m, parameter: standard deviation
        self.offset = 0.0          # m, parameter
        self.drift = 0.0           # m/s, parameter
        self.lost = 0.0            # parameter: probability of a sample to be lost
        self.frozen = False        # parameter
        self.interpolation = InterpolationError()
        self.stream = stream       # of its random words
        self.samples = [0.0 for _ in range(SLOTS)]   # m, state: the last ones of the encoder, a ring
        self.drifted = 0.0         # m, state
        self.measured = position   # m, state and output

    def begin(self, instant: SamplingInstant) -> None:
        """Begin at rest where the encoder is."""
        self.measured = self.encoder
        if instant.late:
            for slot in range(SLOTS):
                self.samples[slot] = self.encoder

    def sample(self, instant: SamplingInstant, seed: int, number: int, sample_time: float) -> None:
        """Take in a sample, all of the block at one instant; by the seed, the number of the sample and its time (s)."""
        value = self.encoder
        if instant.late:
            self.samples[instant.newest] = value
            value = self.samples[instant.slot]
            if instant.fraction > 0.0:
                value += instant.fraction * (self.samples[instant.earlier] - value)
        error = self.interpolation.at(value) + self.offset + self.drifted
        self.drifted += self.drift * sample_time
        arrives = not self.frozen
        if self.noise > 0.0 or self.lost > 0.0:
            first, second = random_words(seed, self.stream, number)
            error += self.noise * normal_variate(first)
            if second * SHARE < self.lost:
                arrives = False
        if arrives:
            self.measured = value + error if error != 0.0 else value
