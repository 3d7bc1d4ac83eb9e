"""A plant: an active magnetic bearing, which holds a rotor on two axes between pairs of electromagnets.

    maglev run levitate.toml --plot
    maglev build bearing.py                   # as an FMU; with --kind native one that needs no Python

The flux linkage is the only state of a magnet. Current and force follow from it, without saturation.
The equations are those of Schweitzer and Maslen, Magnetic Bearings (2009), chapter 4; the numbers are typical.
"""

from pmlsm.sine_cosine import sine_cosine

GRAVITY = 9.81            # m/s²
CORE = 1.13e-5            # μ0 N² A, H m: 150 turns around 4 cm²
RESISTANCE = 1.0          # Ohm
LARGEST_VOLTAGE = 150.0   # V, of the amplifiers
AMPLIFIER = 80.0          # V/A, their gain on the error of the current
PARTS = 4                 # integration steps of a communication step


class State:
    """A state under the classical Runge–Kutta method, which takes four slopes a step."""

    def __init__(self, value: float):
        self.value = value
        self.rate = 0.0
        self.begun = value
        self.ended = value

    def begin(self) -> None:
        """Begin a step."""
        self.begun = self.value
        self.ended = self.value

    def advance(self, weight: float, ahead: float) -> None:
        """Add the slope with its weight (s), and move on to the place of the next one, `ahead` (s) of the beginning."""
        self.ended += weight * self.rate
        self.value = self.begun + ahead * self.rate

    def finish(self) -> None:
        """Go to the end of the step."""
        self.value = self.ended


class Magnet:
    """An electromagnet and its amplifier, by which the current follows a command."""

    def __init__(self) -> None:
        self.i_cmd = 0.0         # A, input
        self.i = 0.0             # A, output
        self.force = 0.0         # N, towards the magnet
        self.flux = State(0.0)   # V s, linkage of all turns

    def act(self, gap: float) -> None:
        """Compute current, force and rate of the flux at an air gap (m)."""
        flux = self.flux.value
        self.i = 2.0 * gap * flux / CORE
        self.force = flux * flux / CORE
        voltage = AMPLIFIER * (self.i_cmd - self.i)
        if voltage > LARGEST_VOLTAGE:
            voltage = LARGEST_VOLTAGE
        elif voltage < -LARGEST_VOLTAGE:
            voltage = -LARGEST_VOLTAGE
        self.flux.rate = voltage - RESISTANCE * self.i


class Axis:
    """One axis: a magnet on either side of the rotor, which moves along it."""

    def __init__(self, start: float):
        self.position_start = start   # m, parameter
        self.force = 0.0              # N, input: from outside
        self.position = start         # m, output: against the middle
        self.plus = Magnet()          # draws to larger positions
        self.minus = Magnet()
        self.place = State(start)     # m
        self.speed = State(0.0)       # m/s

    def start(self) -> None:
        """Begin at rest, without flux."""
        self.place.value = self.position_start
        self.speed.value = 0.0
        self.plus.flux.value = 0.0
        self.minus.flux.value = 0.0

    def begin(self) -> None:
        """Begin a step."""
        self.place.begin()
        self.speed.begin()
        self.plus.flux.begin()
        self.minus.flux.begin()

    def act(self, load: float, mass: float, air_gap: float) -> None:
        """Compute all rates under a load (N)."""
        self.position = self.place.value
        self.plus.act(air_gap - self.position)
        self.minus.act(air_gap + self.position)
        self.place.rate = self.speed.value
        self.speed.rate = (self.plus.force - self.minus.force + self.force + load) / mass

    def advance(self, weight: float, ahead: float) -> None:
        """Add the slopes."""
        self.place.advance(weight, ahead)
        self.speed.advance(weight, ahead)
        self.plus.flux.advance(weight, ahead)
        self.minus.flux.advance(weight, ahead)

    def finish(self) -> None:
        """Go to the end of the step."""
        self.place.finish()
        self.speed.finish()
        self.plus.flux.finish()
        self.minus.flux.finish()


class Bearing:
    """Active magnetic bearing: a rotor between two pairs of electromagnets, x across and y upwards."""

    inputs = {
        "x.plus.i_cmd": "A", "x.minus.i_cmd": "A", "x.force": "N",
        "y.plus.i_cmd": "A", "y.minus.i_cmd": "A", "y.force": "N"}
    outputs = {
        "x.position": "m", "x.plus.i": "A", "x.minus.i": "A",
        "y.position": "m", "y.plus.i": "A", "y.minus.i": "A", "touched": ""}
    parameters = {
        "x.position_start": "m", "y.position_start": "m", "mass": "kg", "air_gap": "m", "clearance": "m",
        "turning": "rad/s", "eccentricity": "m"}

    def __init__(self) -> None:
        self.mass = 4.0             # kg
        self.air_gap = 0.4e-3       # m, of each magnet where the rotor is in the middle
        self.clearance = 0.2e-3     # m, from the middle to the bearing on which the rotor lies without current
        self.turning = 0.0          # rad/s, speed of the rotor
        self.eccentricity = 1.0e-6  # m, of its centre of mass: the unbalance
        self.x = Axis(0.0)
        self.y = Axis(-0.15e-3)
        self.touched = False        # true if the rotor was beyond the clearance, where nothing holds it

    def start(self) -> None:
        """Place the rotor."""
        self.x.start()
        self.y.start()
        self.act(0.0)

    def step(self, t: float, dt: float) -> None:
        """Move from t to t + dt (s) with the commands held."""
        h = dt / PARTS
        for part in range(PARTS):
            begin = t + part * h
            self.x.begin()
            self.y.begin()
            self.add_slopes(begin, h / 6.0, h / 2.0)
            self.add_slopes(begin + h / 2.0, h / 3.0, h / 2.0)
            self.add_slopes(begin + h / 2.0, h / 3.0, h)
            self.add_slopes(begin + h, h / 6.0, 0.0)
            self.x.finish()
            self.y.finish()
        self.act(t + dt)
        x = self.x.position
        y = self.y.position
        self.touched = x * x + y * y > self.clearance * self.clearance

    def add_slopes(self, time: float, weight: float, ahead: float) -> None:
        """Add the slopes at a time (s)."""
        self.act(time)
        self.x.advance(weight, ahead)
        self.y.advance(weight, ahead)

    def act(self, time: float) -> None:
        """Compute all rates at a time (s): the unbalance turns with the rotor."""
        sine, cosine = sine_cosine(self.turning * time)
        unbalance = self.mass * self.eccentricity * self.turning * self.turning
        self.x.act(unbalance * cosine, self.mass, self.air_gap)
        self.y.act(unbalance * sine - self.mass * GRAVITY, self.mass, self.air_gap)
