"""A smooth reference from one setpoint to the next, which waits while its input `hold` is true."""


class Generator:
    """Minimum-jerk reference of the air gap, with its rate; it stands still while `hold` is true."""

    inputs = {"hold": ""}
    outputs = {"v.reference": "m", "v.reference_rate": "m/s"}
    parameters = {"start_gap": "m", "end_gap": "m", "begin": "s", "duration": "s"}

    def __init__(self) -> None:
        self.hold = False
        self.start_gap = 20e-3
        self.end_gap = 22e-3
        self.begin = 0.1
        self.duration = 0.4
        self.moved = 0.0            # s, state: of the way
        self.v_reference = 0.0
        self.v_reference_rate = 0.0

    def start(self) -> None:
        """Begin at the first gap."""
        self.v_reference = self.start_gap

    def step(self, t: float, dt: float) -> None:
        """Go on from t to t + dt; the outputs are those at t + dt."""
        moving = t >= self.begin and not self.hold and self.moved < self.duration
        if moving:
            self.moved = min(self.moved + dt, self.duration)
        s = self.moved / self.duration
        way = self.end_gap - self.start_gap
        self.v_reference = self.start_gap + way * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        self.v_reference_rate = way / self.duration * 30.0 * s * s * (1.0 - s) ** 2 if moving else 0.0
