"""Second-order pre-filter of a reference (Figs. 4.6, 5.6), critically damped: unit gain at rest, no overshoot."""

LARGEST_ANGLE = 0.8   # rad, corner frequency times sample time; the discrete filter is unstable from 2 (√2 − 1) on


class ReferencePrefilter:
    """r_f'' = ω² (r − r_f) − 2 ω r_f', by semi-implicit Euler; its form is assumed."""

    def __init__(self) -> None:
        self.position = 0.0   # m, state and output: filtered reference
        self.rate = 0.0       # m/s, state and output

    def seed(self, reference: float) -> None:
        """Begin at rest at a reference (m)."""
        self.position = reference
        self.rate = 0.0

    def update(self, reference: float, reference_rate: float, corner: float, sample_time: float) -> None:
        """Take in a reference (m) and its rate (m/s); a corner frequency (rad/s) of 0 passes them through."""
        if corner > 0.0:
            acceleration = corner * corner * (reference - self.position) - 2.0 * corner * self.rate
            self.rate += sample_time * acceleration
            self.position += sample_time * self.rate
        else:
            self.position = reference
            self.rate = reference_rate
