"""A random function of the position along one axis, the same on every way."""

from pmlsm.normal_variate import normal_variate
from pmlsm.random_words import SHARE, random_words
from pmlsm.whole_numbers import rounded_down

SPACING = 1.2                  # of the nodes, over the correlation length: the covariance is nearly Gaussian
WEIGHT = 1.4443312345967556    # standard deviation of a weight for an rms of 1: the mean of Σ B² over a cell is 151/315
HALF_OF_WORDS = 0x80000000     # a node that no mover comes to: its word places all the others
NOWHERE = 1.0e18               # a cell that no mover is in
FURTHEST = 1.0e9               # nodes


class Track:
    """Random function n(q) = Σ w_k B(q/Δ + u − k), fixed by a seed and a stream of random words.

    B is the cubic B-spline, scaled such that n has mean 0 and variance 1 over all tracks. The nodes are Δ = 1.2 ℓ
    apart, with the correlation length ℓ. The weights w_k are normal and independent, and 0 < u < 1 places the nodes. So
    n is Gaussian, has two continuous derivatives, and its covariance is exp(−d²/2ℓ²) within 0.01. The cubic of the cell
    between two nodes is kept until the mover leaves it.
    """

    def __init__(self) -> None:
        self.seed = 0               # of the tracks of all axes
        self.stream = 0             # of the random words of this one
        self.per_metre = 0.0        # 1/Δ
        self.offset = 0.0           # u
        self.cell = NOWHERE         # k of the node below the mover
        self.value = 0.0            # cubic of that cell, in the way from its node
        self.slope = 0.0
        self.square = 0.0
        self.cube = 0.0

    def start(self, seed: int, stream: int, correlation: float) -> None:
        """Lay the track of a seed and a stream with a correlation length (m)."""
        self.seed = seed
        self.stream = stream
        self.per_metre = 1.0 / (SPACING * correlation)
        first, second = random_words(seed, stream, HALF_OF_WORDS)
        self.offset = (first + 0.5) * SHARE
        self.cell = NOWHERE

    def at(self, position: float) -> float:
        """Value n at a position (m)."""
        place = position * self.per_metre + self.offset
        way = place - self.cell
        if way < 0.0 or way >= 1.0:
            self.enter(place)
            way = place - self.cell
        return ((self.cube * way + self.square) * way + self.slope) * way + self.value

    def enter(self, place: float) -> None:
        """Compute the cubic of the cell of a place, counted in nodes."""
        if not -FURTHEST < place < FURTHEST:
            return   # the mover has run away
        node = int(rounded_down(place))
        self.cell = float(node)
        before, here, after, beyond = 0.0, 0.0, 0.0, 0.0
        for k in range(-1, 3):
            before = here
            here = after
            after = beyond
            beyond = self.weight(node + k)
        self.value = (before + 4.0 * here + after) / 6.0
        self.slope = 0.5 * (after - before)
        self.square = 0.5 * (before + after) - here
        self.cube = (beyond - before + 3.0 * (here - after)) / 6.0

    def weight(self, node: int) -> float:
        """Weight w_k of a node."""
        first, second = random_words(self.seed, self.stream, node)
        return WEIGHT * normal_variate(first)
