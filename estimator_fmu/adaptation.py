"""How the constants of a regulator follow their estimates: within bounds, slowly, and not while the data mislead."""

from pmlsm.elementary.exponential import exponential


class Adaptation:
    """When the constants follow, and how; all of it assumed."""

    def __init__(self) -> None:
        self.active = True    # parameter: whether they do at all
        self.range = 0.6      # parameter: largest distance from where they begin, relative
        self.time = 0.5       # s, parameter: time constant with which they follow
        self.pause = 0.1      # s, parameter: how long data mislead after a limit or a stop
        self.waiting = 0.0    # s, state: what is left of the pause
        self.frozen = False   # output: whether the constants stay as they are

    def judge(self, misleading: bool, sample_time: float) -> bool:
        """Take in whether the data of a sample mislead; whether the constants stay as they are."""
        if misleading:
            self.waiting = self.pause
        elif self.waiting > 0.0:
            self.waiting -= sample_time
        self.frozen = misleading or self.waiting > 0.0 or not self.active
        return self.frozen

    def share(self, sample_time: float) -> float:
        """Share of the way to the estimates that the constants go in a sample (s)."""
        return 1.0 - exponential(-sample_time / self.time)


class AdaptedConstant:
    """A constant of the regulator's model."""

    def __init__(self, nominal: float):
        self.nominal = nominal   # parameter: where it begins, and the middle of its bounds
        self.value = nominal     # state and output

    def begin(self) -> None:
        """Begin at the nominal value."""
        self.value = self.nominal

    def follow(self, estimate: float, share: float, largest: float) -> None:
        """Go a share of the way to an estimate, or to the bound that it is beyond; `largest` is relative."""
        low = (1.0 - largest) * self.nominal
        high = (1.0 + largest) * self.nominal
        if estimate < low:
            estimate = low
        elif estimate > high:
            estimate = high
        self.value += share * (estimate - self.value)


class Travel:
    """Where the guides let an axis, or a motor's gap, go: beyond, a stop pushes and not the motors alone."""

    def __init__(self, lower: float, upper: float):
        self.lower = lower   # m, parameter
        self.upper = upper   # m, parameter

    def ends(self, measured: float) -> bool:
        """Whether a measured position (m) is at a stop."""
        return measured <= self.lower or measured >= self.upper
