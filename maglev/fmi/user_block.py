"""Blocks that step a user's object, at its samples or at each communication step, in the language of blocks.

Who steps them checks the outputs, see `FmuDefinition.finite`.
"""

from typing import Any

STEPPED = 0
STEP_MISFIT = 1   # the communication step does not fit the sample time
FIRST_PORT = 2    # this and the following: which output is no finite number


class SteppedLaw:
    """An object that is stepped at each communication step."""

    def __init__(self, written: type, clock: type):
        self.law: Any = written()
        self.clock: Any = clock()

    def start(self) -> int:
        """Begin; the object computes nothing."""
        return STEPPED

    def step(self, t: float, dt: float) -> int:
        """Step the object from t to t + dt (s)."""
        self.law.step(t, dt)
        return STEPPED


class SampledLaw(SteppedLaw):
    """An object that is stepped where its sampling grid has a point."""

    def step(self, t: float, dt: float) -> int:
        """Step the object if the grid has a point at t; its outputs hold over t to t + dt (s)."""
        if not self.clock.fits(dt, self.law.sample_time):
            return STEP_MISFIT
        if self.clock.due(dt, self.law.sample_time):
            self.law.step(t)
        return STEPPED


class StartedSteppedLaw(SteppedLaw):
    """The same of an object that computes something from its parameters."""

    def start(self) -> int:
        """Let the object compute the values that follow from its parameters."""
        self.law.start()
        return STEPPED


class StartedSampledLaw(SampledLaw):
    """The same of an object with samples."""

    def start(self) -> int:
        """Let the object compute the values that follow from its parameters."""
        self.law.start()
        return STEPPED


def block_of(written: type, sampled: bool) -> type[SteppedLaw]:
    """Class of the block that steps objects of a user's class."""
    if hasattr(written, "start"):
        return StartedSampledLaw if sampled else StartedSteppedLaw
    return SampledLaw if sampled else SteppedLaw
