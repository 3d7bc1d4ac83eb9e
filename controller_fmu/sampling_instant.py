"""When the encoders were read: a constant delay, and one that changes from sample to sample. Assumed."""

from pmlsm.random_words import SHARE, random_words

SLOTS = 128           # samples that are kept of an encoder
LATEST = 126          # samples, that a reading can be late: one more is kept, to interpolate
NEARLY_WHOLE = 1.0e-6   # of a sample, by which a delay may miss a whole number of them
STREAM = 0            # of the random words; the encoders have the others

STEPPED = 0       # status of a measurement's `start` and `step`
STEP_MISFIT = 1   # the communication step does not fit the sample time
TOO_LATE = 2      # the delay is longer than the recorded past
NO_SEED = 3       # the seed is no whole number


class SamplingInstant:
    """All encoders are read at one instant, which lies before the sample by delay + jitter · u, 0 < u < 1.

    Between two samples the position is taken as a straight line.
    """

    def __init__(self) -> None:
        self.delay = 0.0      # s, parameter
        self.jitter = 0.0     # s, parameter
        self.late = False     # true if there is a delay or jitter
        self.newest = 0       # state: slot of the sample that came last
        self.slot = 0         # of the sample after the instant
        self.earlier = 0      # slot of the one before it
        self.fraction = 0.0   # of a sample, from the later one back to the instant

    def prepare(self, sample_time: float) -> bool:
        """Return True if the delay and the jitter are short enough for a sample time (s)."""
        self.late = self.delay > 0.0 or self.jitter > 0.0
        return self.delay + self.jitter <= LATEST * sample_time

    def advance(self, seed: int, number: int, sample_time: float) -> None:
        """Move to the next sample, by the seed and the number of the sample."""
        self.newest = (self.newest + 1) & (SLOTS - 1)
        age = self.delay
        if self.jitter > 0.0:
            first, second = random_words(seed, STREAM, number)
            age += self.jitter * ((first + 0.5) * SHARE)
        samples = age / sample_time
        whole = int(samples + NEARLY_WHOLE)
        fraction = samples - whole
        self.fraction = fraction if fraction > NEARLY_WHOLE else 0.0
        self.slot = (self.newest - whole) & (SLOTS - 1)
        self.earlier = (self.slot - 1) & (SLOTS - 1)
