"""Block that steps a user's object at its samples, or at each communication step, and checks its outputs."""

from math import isfinite
from numbers import Real
from operator import attrgetter
from typing import Any

STEPPED = 0
STEP_MISFIT = 1   # the communication step does not fit the sample time
FIRST_PORT = 2    # this and the following: which output is no finite number


class SampledBlock:
    """A user's object as a block: the Python counterpart of the C from `native_block`."""

    def __init__(self, written: type, clock: type, ports: tuple[str, ...], sampled: bool):
        self.law = written()
        self.sampled = sampled
        self.clock = clock()
        self.ports = [attrgetter(port) for port in ports]   # Real outputs
        self.starts = hasattr(written, "start")

    def start(self) -> int:
        """Let the object compute the values that follow from its parameters."""
        if self.starts:
            self.law.start()
        return self.check()

    def step(self, t: float, dt: float) -> int:
        """Step the object if the sampling grid has a point at t; its outputs hold over t to t + dt (s).

        One without samples is stepped from t to t + dt.
        """
        if not self.sampled:
            self.law.step(t, dt)
            return self.check()
        if not self.clock.fits(dt, self.law.sample_time):
            return STEP_MISFIT
        if self.clock.due(dt, self.law.sample_time):
            self.law.step(t)
            return self.check()
        return STEPPED

    def check(self) -> int:
        """Status of the first output that is no finite number."""
        for number, port in enumerate(self.ports, FIRST_PORT):
            value: Any = port(self)
            if not (isinstance(value, (float, Real)) and isfinite(value)):
                return number
        return STEPPED
