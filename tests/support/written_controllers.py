"""Controllers as Python files, and a short run for them."""

from pathlib import Path

LOOPS = Path(__file__).parents[2] / "scenarios" / "loops"

TRIAL = """
extends = "{loop}"
name = "trial"
title = "A step of 1 mm"
stop_time = "0.4 s"
[fmus.plant.start]
"v.position_start" = "20 mm"
"h.position_start" = "0 mm"
[[signals]]
to = "controller.v.reference"
kind = "steps"
unit = "mm"
times = [0, 0.1]
values = [20, 21]
[[signals]]
to = "controller.h.reference"
kind = "steps"
unit = "mm"
times = [0, 0.2]
values = [0, 1]
"""

# The law of examples/pd_controller_python in another shape: attributes for its dict, methods for its comprehensions.
PD = '''"""PD controller of the 2-DOF stage."""

from math import cos, pi, sin

POLE_PITCH = 57.15e-3
LARGEST = 6.0


def limited(current: float) -> float:
    """Limit a current (A)."""
    if current > LARGEST:
        return LARGEST
    if current < -LARGEST:
        return -LARGEST
    return current


class Rate:
    """Filtered rate of a measurement."""

    def __init__(self) -> None:
        self.last = 0.0
        self.rate = 0.0

    def update(self, now: float, dt: float, known: bool) -> None:
        """Take in a measurement (m)."""
        before = self.last if known else now
        follow = dt / (1.5e-3 + dt)
        self.rate = self.rate + follow * ((now - before) / dt - self.rate)
        self.last = now


class PD:
    """PD on both axes with the holding current as feed-forward."""

    inputs = {"v.measured": "m", "h.measured": "m", "v.reference": "m", "h.reference": "m"}
    outputs = {"motor.i_a_cmd": "A", "motor.i_b_cmd": "A",
               "motor.i_c_cmd": "A"}
    parameters = {"bandwidth": "rad/s", "damping": ""}

    def __init__(self) -> None:
        self.sample_time = 0.5e-3
        self.bandwidth = 60.0
        self.damping = 0.9
        self.v_measured = 20e-3
        self.v_reference = 20e-3
        self.h_measured = 0.0
        self.h_reference = 0.0
        self.motor_i_a_cmd = 0.0
        self.motor_i_b_cmd = 0.0
        self.motor_i_c_cmd = 0.0
        self.gap = Rate()
        self.travel = Rate()
        self.known = False

    def step(self, t: float) -> None:
        """Compute the commands."""
        self.gap.update(self.v_measured, self.sample_time, self.known)
        self.travel.update(self.h_measured, self.sample_time, self.known)
        self.known = True
        w = self.bandwidth
        damping = 2.0 * self.damping * w
        gap_demand = -w * w * (self.v_measured - self.v_reference) - damping * self.gap.rate
        travel_demand = -w * w * (self.h_measured - self.h_reference) - damping * self.travel.rate
        holding = -0.25 + -415.0 * (self.v_reference - 20e-3)
        i_d = limited(holding + (gap_demand - 1435.0 * (self.v_measured - self.v_reference)) / 3.432)
        i_q = limited(travel_demand / -6.68)
        angle = pi / POLE_PITCH * (self.h_measured - POLE_PITCH / 2.0)
        self.motor_i_a_cmd = cos(angle) * i_d - sin(angle) * i_q
        self.motor_i_b_cmd = cos(angle - 2.0 * pi / 3.0) * i_d - sin(angle - 2.0 * pi / 3.0) * i_q
        self.motor_i_c_cmd = cos(angle - -2.0 * pi / 3.0) * i_d - sin(angle - -2.0 * pi / 3.0) * i_q
'''


def trial(folder: Path) -> Path:
    """Write the scenario of a short run of the 2-DOF stage; returns its path."""
    path = folder / "trial.toml"
    path.write_text(TRIAL.format(loop=LOOPS / "2dof.toml"))
    return path


def controller(folder: Path, *changes: tuple[str, str], name: str = "pd.py") -> Path:
    """Write the PD controller with changes of its text, each of a text that is in it once; returns its path."""
    text = PD
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / name
    path.write_text(text)
    return path


def line_of(path: Path, part: str) -> int:
    """Number of the only line of a file that has a text in it."""
    line, = (number for number, text in enumerate(path.read_text().splitlines(), 1) if part in text)
    return line


# The plant of this project as a user's class: of parts that the FMU has, without the FMU around them.
PLANT = '''"""The 2-DOF stage as a Python file."""

from maglev.descriptions.packaged import PACKAGED_STAGES
from plant_fmu.stage import Stage as OneStage


class Stage:
    """Steps the blocks of the plant."""

    inputs = {"motor.i_a_cmd": "A", "motor.i_b_cmd": "A", "motor.i_c_cmd": "A"}
    outputs = {"v.encoder": "m", "v.position": "m", "v.velocity": "m/s", "h.encoder": "m", "h.position": "m",
               "h.velocity": "m/s", "motor.i_a": "A", "motor.i_b": "A", "motor.i_c": "A", "at_stop": ""}
    parameters = {"v.position_start": "m", "h.position_start": "m", "v.mass": "kg", "C3": "m/(s2.A.T)"}

    def __init__(self) -> None:
        self.stage = OneStage(PACKAGED_STAGES["2dof"])
        self.v, self.h = self.stage.axes
        self.motor, = self.stage.motors
        self.C3 = 30.9
        self.at_stop = False

    def start(self) -> None:
        """Place the mover."""
        self.stage.magnetics.coils = self.C3
        self.stage.start()

    def step(self, t: float, dt: float) -> None:
        """Move."""
        self.stage.step(t, dt)
        self.at_stop = self.stage.at_stop
'''

SENSOR = '''"""A sensor between plant and controller."""


class Sensor:
    """Rounds to a resolution of its own."""

    inputs = {"v.encoder": "m", "h.encoder": "m"}
    outputs = {"v.measured": "m", "h.measured": "m"}
    parameters = {"resolution": "m"}

    def __init__(self) -> None:
        self.resolution = 0.0
        self.v_encoder = 0.0
        self.h_encoder = 0.0
        self.v_measured = 0.0
        self.h_measured = 0.0

    def rounded(self, value: float) -> float:
        """Nearest multiple of the resolution."""
        if self.resolution <= 0.0:
            return value
        return self.resolution * int(value / self.resolution + (0.5 if value >= 0.0 else -0.5))

    def start(self) -> None:
        """Measure what the plant begins with."""
        self.step(0.0, 0.0)

    def step(self, t: float, dt: float) -> None:
        """Measure."""
        self.v_measured = self.rounded(self.v_encoder)
        self.h_measured = self.rounded(self.h_encoder)
'''

GENERATOR = '''"""A reference from a class."""


class Steps:
    """The steps of the short run."""

    outputs = {"v.reference": "m", "h.reference": "m"}
    parameters = {"height": "m"}

    def __init__(self) -> None:
        self.height = 1e-3
        self.v_reference = 0.02
        self.h_reference = 0.0

    def step(self, t: float, dt: float) -> None:
        """Give the references at the end of the step."""
        self.v_reference = 0.021 if t + dt > 0.1 - 1e-9 else 0.02
        self.h_reference = self.height if t + dt > 0.2 - 1e-9 else 0.0
'''

# What extends the short run: the three blocks take the places of connections, of signals, and of a model.
WIRED = {"sensor": """
[fmus.sensor]
file = "sensor.py"
inputs = { "v.encoder" = "plant.v.encoder", "h.encoder" = "plant.h.encoder" }
[fmus.controller.inputs]
"v.measured" = "sensor.v.measured"
"h.measured" = "sensor.h.measured"
""", "generator": """
[fmus.generator]
file = "generator.py"
[fmus.controller.inputs]
"v.reference" = "generator.v.reference"
"h.reference" = "generator.h.reference"
""", "plant": """
[fmus.plant]
file = "plant.py"
start = { "v.position_start" = "20 mm", "h.position_start" = 0 }
"""}


def blocks(folder: Path) -> Path:
    """Write the plant, the sensor and the generator, and a scenario for each, `sensor.toml`; returns the folder."""
    for name, text in {"plant": PLANT, "sensor": SENSOR, "generator": GENERATOR}.items():
        (folder / f"{name}.py").write_text(text)
        (folder / f"{name}.toml").write_text(f'extends = "trial.toml"\nname = "{name}"\n{WIRED[name]}')
    trial(folder)
    return folder
