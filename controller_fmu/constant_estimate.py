"""The estimate of a constant: where it begins, its weight, and whether it has converged."""

INFORMED = 10.0   # times the weight of the start value that the data must weigh; assumed


class ConvergenceRule:
    """Condition that every constant has to meet to count as converged; assumed."""

    def __init__(self) -> None:
        self.tolerance = 0.01   # parameter: band that the estimate keeps to, relative
        self.time = 5.0         # s, parameter: for how long


class ConstantEstimate:
    """An estimate: it has converged when data decide it, and when it has stayed in a narrow band for a time."""

    def __init__(self, guess: float, weight: float):
        self.guess = guess        # parameter: first guess
        self.weight = weight      # parameter: its diagonal element of Q0
        self.value = guess        # state and output
        self.anchor = 0.0         # state: middle of the band
        self.kept = 0.0           # s, state: time in the band
        self.converged = False    # output

    def begin(self) -> None:
        """Begin at the guess."""
        self.value = self.guess

    def watch(self, uncertainty: float, rule: ConvergenceRule, sample_time: float) -> None:
        """Judge the estimate after a sample (s), by its diagonal element of Σ⁻¹."""
        distance = self.value - self.anchor
        band = rule.tolerance * (self.anchor if self.anchor > 0.0 else -self.anchor)
        if distance > band or distance < -band:
            self.anchor = self.value
            self.kept = 0.0
        else:
            self.kept += sample_time
        self.converged = self.kept >= rule.time and uncertainty * self.weight * INFORMED < 1.0
