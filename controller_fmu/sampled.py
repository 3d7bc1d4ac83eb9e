"""Common part of all blocks that sample: they are stepped on the grid of their samples."""

from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import STEP_MISFIT, STEPPED


class Sampled:
    """A block that computes its outputs at samples; its constructor sets the attributes below."""

    clock: SampleClock
    sample_time: float   # s, parameter

    def step(self, t: float, dt: float) -> int:
        """Sample if the sampling grid has a point at t; the outputs hold over t to t + dt (s)."""
        if not self.clock.fits(dt, self.sample_time):
            return STEP_MISFIT
        if self.clock.due(dt, self.sample_time):
            self.sample()
        return STEPPED

    def sample(self) -> None:
        """Compute the outputs from the inputs: every block has its own."""
        raise NotImplementedError
