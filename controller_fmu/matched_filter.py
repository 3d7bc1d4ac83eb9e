"""The delay of the velocity observer, for signals that are compared with the measured velocity."""

from controller_fmu.velocity_observer import ObserverFilter


class MatchedFilter:
    """The observer's two filters (Fig. 4.7) for a column of A(y, u).

    v' = A θ + b holds for filtered signals as it does for others, if the same filters act on both sides.
    """

    def __init__(self) -> None:
        self.once = 0.0     # state
        self.output = 0.0   # state and output

    def seed(self, value: float) -> None:
        """Begin at rest at a value."""
        self.once = value
        self.output = value

    def update(self, value: float, observer_filter: ObserverFilter) -> float:
        """Take in a value, return the filtered one."""
        self.once += observer_filter.share1 * (value - self.once)
        self.output += observer_filter.share2 * (self.once - self.output)
        return self.output
