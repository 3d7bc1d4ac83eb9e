"""Adaptation of a regulator's constants to their estimates: within bounds, slowly, and not while the data mislead."""

from controller_fmu.constant_estimate import ConstantEstimate
from pmlsm.exponential import exponential


class Adaptation:
    """When the constants follow, and how; all of it assumed."""

    def __init__(self) -> None:
        self.active = True    # parameter: true if they follow at all
        self.range = 0.6      # parameter: largest distance from where they begin, relative
        self.time = 0.5       # s, parameter: time constant with which they follow
        self.pause = 0.1      # s, parameter: how long data mislead after a limit or a stop
        self.waiting = 0.0    # s, state: rest of the pause
        self.frozen = False   # output: true if the constants do not change

    def judge(self, misleading: bool, sample_time: float) -> bool:
        """Note if the data of a sample mislead; return True if the constants must not change."""
        if misleading:
            self.waiting = self.pause
        elif self.waiting > 0.0:
            self.waiting -= sample_time
        self.frozen = misleading or self.waiting > 0.0 or not self.active
        return self.frozen

    def share(self, sample_time: float) -> float:
        """Share of the way to the estimates that the constants go in a sample (s)."""
        return 1.0 - exponential(-sample_time / self.time)


class Travel:
    """Range of an axis, or of a motor's gap, within which only the motors push, and no stop does."""

    def __init__(self, lower: float, upper: float):
        self.lower = lower   # m, parameter
        self.upper = upper   # m, parameter

    def ends(self, measured: float) -> bool:
        """Return True if a measured position (m) is at a stop."""
        return measured <= self.lower or measured >= self.upper


def followed(value: float, estimate: ConstantEstimate, share: float, largest: float) -> float:
    """A constant after a share of the way to its estimate, or to the bound that this is beyond.

    The bounds are about where it began; `largest` is their distance from there, relative.
    """
    target = estimate.value
    low = (1.0 - largest) * estimate.guess
    high = (1.0 + largest) * estimate.guess
    if target < low:
        target = low
    elif target > high:
        target = high
    return value + share * (target - value)
