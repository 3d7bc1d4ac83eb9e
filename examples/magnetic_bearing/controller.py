"""Controller of the magnetic bearing: state feedback with an integral on each axis, around a current in all magnets."""

GAIN = 141.0          # N/A, of the control current, at a bias of 2 A in the middle: 4 F/i
STIFFNESS = 7.06e5    # N/m, of the magnets, which draw the rotor from the middle: 4 F/s
MASS = 4.0            # kg


class Axis:
    """One axis: computes the currents of its two magnets from the position."""

    def __init__(self) -> None:
        self.reference = 0.0    # m, input
        self.measured = 0.0     # m, input
        self.plus_cmd = 0.0     # A, output
        self.minus_cmd = 0.0    # A, output
        self.before = 0.0       # m, at the sample before
        self.rate = 0.0         # m/s, filtered
        self.integral = 0.0     # m s

    def control(self, bias: float, w: float, dt: float) -> None:
        """Put the poles of the error at -w and at w exp(±26° about the negative axis)."""
        self.rate += 0.5 * ((self.measured - self.before) / dt - self.rate)
        self.before = self.measured
        error = self.measured - self.reference
        self.integral += dt * error
        demand = -2.8 * w * self.rate - 2.8 * w * w * error - w * w * w * self.integral   # m/s²
        current = (MASS * demand - STIFFNESS * self.measured) / GAIN
        if current > bias:
            current = bias
        elif current < -bias:
            current = -bias
        self.plus_cmd = bias + current
        self.minus_cmd = bias - current


class Levitation:
    """Levitates the rotor of the magnetic bearing."""

    inputs = {"x.measured": "m", "x.reference": "m", "y.measured": "m", "y.reference": "m"}
    outputs = {"x.plus_cmd": "A", "x.minus_cmd": "A", "y.plus_cmd": "A", "y.minus_cmd": "A"}
    parameters = {"bias": "A", "bandwidth": "rad/s"}

    def __init__(self) -> None:
        self.sample_time = 0.1e-3   # s
        self.bias = 2.0             # A
        self.bandwidth = 250.0      # rad/s
        self.x = Axis()
        self.y = Axis()
        self.begun = False

    def step(self, t: float) -> None:
        """Set the currents."""
        if not self.begun:
            self.begun = True
            self.x.before = self.x.measured
            self.y.before = self.y.measured
        self.x.control(self.bias, self.bandwidth, self.sample_time)
        self.y.control(self.bias, self.bandwidth, self.sample_time)
