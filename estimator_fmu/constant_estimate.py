"""Whether the estimate of a constant has converged."""

INFORMED = 10.0   # times the weight of the start value that the data must weigh; assumed


class ConvergenceRule:
    """What is asked of every constant; assumed."""

    def __init__(self) -> None:
        self.tolerance = 0.01   # parameter: band that the estimate keeps to, relative
        self.time = 5.0         # s, parameter: for how long


class ConstantEstimate:
    """Watches an estimate: it has converged when data decide it, and when it has stayed in a narrow band for a time."""

    def __init__(self) -> None:
        self.anchor = 0.0         # state: middle of the band
        self.kept = 0.0           # s, state: time in the band
        self.converged = False    # output

    def watch(self, value: float, uncertainty: float, weight: float, rule: ConvergenceRule, sample_time: float) -> None:
        """Take in an estimate.

        Parameters
        ----------
        value : float
            The estimate.
        uncertainty : float
            Its diagonal element of Σ⁻¹.
        weight : float
            Its diagonal element of Q0.
        rule : ConvergenceRule
        sample_time : float
            s.
        """
        distance = value - self.anchor
        band = rule.tolerance * (self.anchor if self.anchor > 0.0 else -self.anchor)
        if distance > band or distance < -band:
            self.anchor = value
            self.kept = 0.0
        else:
            self.kept += sample_time
        self.converged = self.kept >= rule.time and uncertainty * weight * INFORMED < 1.0
