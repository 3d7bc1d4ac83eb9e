"""The linear loop with its limit, simulated: which states come back to rest, and how."""

from dataclasses import dataclass

import numpy as np

from maglev.analysis.axis_loop import AxisLoop
from maglev.analysis.certificate import LARGEST_STEP, Certificate
from maglev.files.arrays import Array, Bools
from maglev.runs.measuring import last_with, overshoots, settling_times

HORIZON = 20.0       # s, after which a state that is not back is taken for lost
LOOK = 500           # samples between two looks at who is back or lost
LOST = 30.0          # m, m/s, or of a tilt rad, rad/s
STEPS = 40           # steps that are tried at a time, of either sign
BAND = 1e-4          # m, of settling: the specification of the thesis (section 5.5)
SHOWN = 5.0          # s, of a response


@dataclass(frozen=True, eq=False)
class Response:
    """Answer to a step of the reference at 0 s."""

    step: float   # m
    time: Array   # s; shape (k,)
    position: Array   # m from where the step began; shape (k,)
    command: Array   # A, of the first current that moves the axis; shape (k,)

    @property
    def overshoot(self) -> float:
        """Farthest way beyond the reference, as a share of the step."""
        off = self.position - self.step
        return float(overshoots(off.max(), off.min(), np.array(self.step)))

    @property
    def settling(self) -> float:
        """Time to the last sample with an error beyond 0.1 mm, s; inf if that is the last of the response."""
        outside = last_with(np.abs(self.position - self.step) > BAND, 0, np.array(-1.0))
        return float(settling_times(self.time, outside, 0, len(self.time)))


class Samples:
    """Step many states of a loop, one sample after the other."""

    def __init__(self, loop: AxisLoop, gains: Array):
        self.K, self.lower, self.upper = loop.K, loop.lower[:, None], loop.upper[:, None]
        self.A: Array = np.eye(len(loop.A)) + loop.sample_time * loop.A
        self.B: Array = loop.sample_time * loop.injected(gains)

    def after(self, states: Array) -> tuple[Array, Array]:
        """States after one sample, shape (n, c), and the limited commands, A, as deviations, shape (m, c)."""
        wanted = self.K @ states
        # np.clip takes five times as long for as few.
        command = np.minimum(np.maximum(wanted, self.lower), self.upper)
        return self.A @ states - self.B @ (wanted - command), command


def comes_back(loop: AxisLoop, certificate: Certificate, states: Array) -> Bools:
    """Return True for each state, a column of an array of shape (n, c), that comes back into the certified ellipsoid.
    """
    samples = Samples(loop, certificate.gains)
    back = np.zeros(states.shape[1], bool)
    going = np.arange(states.shape[1])
    for _ in range(int(np.ceil(HORIZON / (LOOK * loop.sample_time)))):
        # Positions and velocities are the first states.
        inside = certificate.level(states) <= 1.0
        back[going[inside]] = True
        stay = ~inside & (np.abs(states[:2 * len(loop.axes)]) < LOST).all(axis=0)
        going, states = going[stay], states[:, stay]
        if len(going) == 0:
            break
        for _ in range(LOOK):
            states, _ = samples.after(states)
    return back


def largest_step(loop: AxisLoop, certificate: Certificate) -> float:
    """Largest step of the reference, m, below which steps of either sign come back; LARGEST_STEP if all do.

    Steps in a geometric sequence are tried, then, between the first that does not come back and that before it, again.
    """
    low, high = min(0.5 * certificate.step, 0.5 * LARGEST_STEP), LARGEST_STEP
    for _ in range(2):
        steps = np.geomspace(low, high, STEPS)
        both = comes_back(loop, certificate, np.outer(loop.at_step, np.concatenate([steps, -steps])))
        back = both[:STEPS] & both[STEPS:]
        if back.all():
            return float(steps[-1])
        first = int(np.argmin(back))
        if first == 0:
            return 0.0
        low, high = steps[first - 1], steps[first]
    return float(low)


def respond(loop: AxisLoop, gains: Array, step: float) -> Response:
    samples, count = Samples(loop, gains), int(SHOWN / loop.sample_time)
    state = -step * loop.at_step[:, None]
    position, command = np.zeros(count), np.zeros(count)
    for k in range(count):
        position[k] = step + state[0, 0]
        state, now = samples.after(state)
        command[k] = loop.at_rest + now[0, 0]
    return Response(step, np.asarray(loop.sample_time * np.arange(count), dtype=np.float64), position, command)
