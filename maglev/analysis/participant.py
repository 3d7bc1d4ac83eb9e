"""One FMU, or a user's class, stepped by itself from a point of its past, any number of times.

Its state is saved by its own means (fmi2GetFMUstate, or a copy of the object). Without such means it is made again and
gets the inputs of its past once more.

The derivatives of its outputs are central differences of its responses, with estimated errors. An input is pushed by ±
a size for one sample, and the difference of the responses is taken. Six sizes find a function without a derivative: a
rounding, a dead zone or a step changes with the size, a kink with the sign. A push some samples later finds a law that
samples more slowly than its loop, which is no linear system at the loop's samples. Richardson's extrapolation uses the
largest two sizes at which the law is smooth; its distance from the smaller of them estimates the error.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from maglev.cosim.fmu import Fmu
from maglev.cosim.master import FmuSetup
from maglev.cosim.open import describe, open_fmu
from maglev.cosim.port_map import apply
from maglev.cosim.wiring import Call, Rate, Track, step_calls, value_calls
from maglev.files.arrays import Array
from maglev.files.errors import FmuError, LinearModelError

FOREVER = 1e6      # s, stop time that is given at the initialization
OFTEN = 500        # steps between two signs of life
REPEATED = 1e-12   # relative difference at which the same inputs count as having given the same outputs

SIZES = (20.0, 10.0, 2.0, 1.0, 0.2, 0.1)   # of a push, in units of the input's scale
LARGE = (100.0, 1000.0)                    # of one that has no response to these
WINDOW = 40         # samples, in which all sizes are compared
LATER = 8           # samples by which a push comes later at most
SAME = 1e-2         # relative difference of responses that differ only by their curvature
KINK = 5e-2         # relative difference of the responses to a push and to a pull where there is a derivative
ROUND_OFF = 1e-15   # relative to the outputs: below it a response is nothing

Sign = Callable[[], object]   # a sign of life for who waits in another process


def no_sign() -> None:
    """Give no sign of life: nobody waits."""


class Participant:
    """An FMU that takes a row of Real inputs and gives a row of Real outputs at each step (s); a context manager.

    `means` says how it gets back to a point: "its saved state" or "its past run again". `sign` is called every `OFTEN`
    steps. FmuError if it cannot be
    loaded, lacks a variable, or refuses its start values.
    """

    def __init__(self, setup: FmuSetup, inputs: Sequence[str], outputs: Sequence[str], step: float,
                 sign: Sign = no_sign):
        self.setup, self.inputs, self.outputs, self.size = setup, tuple(inputs), tuple(outputs), step
        self.sign = sign
        self.means = ""
        self.past: list[list[float]] = []   # inputs of every step until the point
        self.saved: Any = None
        self.begin()

    def __enter__(self) -> "Participant":
        return self

    def __exit__(self, *_: object) -> None:
        self.fmu.close()

    def begin(self) -> None:
        description = describe(self.setup.name, self.setup.source)
        scales = {} if self.setup.ports is None else apply(self.setup.ports, description)
        self.fmu: Fmu = open_fmu(self.setup.name, self.setup.source, description, scales)
        self.given, self.setting = self.row("Set", self.inputs)
        self.got, self.getting = self.row("Get", self.outputs)
        self.stepping, = step_calls(self.fmu, self.size, 0, Rate())
        self.fmu.initialise(self.setup.start, 0.0, FOREVER)
        self.count = 0   # steps since then

    def row(self, verb: str, names: Sequence[str]) -> tuple[Array, list[Call]]:
        """A row of values, SI, and the calls that set the variables to it, or get them into it."""
        variables = [self.fmu.variable(name) for name in names]
        for variable in variables:
            if variable.type != "Real":
                raise FmuError(f"{self.setup.name}.{variable.name} is of type {variable.type}, expected a Real")
        track = Track([*names], np.float64, 1)
        return track.array[0], [*value_calls(self.fmu, verb, variables, track, 0, 0)]

    def step(self, inputs: Sequence[float]) -> list[float]:
        """Outputs of a step with inputs, SI; FmuError if it refuses."""
        self.given[:] = inputs
        for call in self.setting:
            call.at(0)
        self.stepping.at(self.count)
        self.count += 1
        if self.count % OFTEN == 0:
            self.sign()
        return self.outputs_now()

    def outputs_now(self) -> list[float]:
        """Return the present outputs, SI."""
        for call in self.getting:
            call.at(0)
        numbers: list[float] = self.got.tolist()
        return numbers

    def mark(self, past: Array, last: Sequence[float]) -> None:
        """Take the present as the point to return to.

        `past` are the inputs of every step so far, shape (steps, inputs), `last` the outputs of the last one.
        """
        self.past = past.tolist()
        self.last = list(last)
        self.saved = self.state()
        self.means = "its saved state" if self.saved is not None else "its past run again"

    def state(self) -> Any:
        """State of the FMU; None if it has no means to give it."""
        if not self.fmu.description.coSimulation.canGetAndSetFMUstate:
            return None
        try:
            return self.fmu.instance.getFMUState()
        except Exception:   # fmpy raises whatever the status is, and its exceptions cannot be copied; this one can
            return None

    def back(self) -> None:
        """Return to the point that was marked."""
        fmu = self.fmu
        if self.saved is None:
            fmu.close()
            self.begin()
            answer = self.last
            for inputs in self.past:
                answer = self.step(inputs)
            if not np.allclose(answer, self.last, rtol=REPEATED, atol=REPEATED):
                raise LinearModelError(f"{self.setup.name} ({self.setup.source.name}) gave other outputs for the same "
                                       "inputs, expected a deterministic controller")
        else:
            fmu.instance.setFMUState(self.saved)
        self.count = len(self.past)

    def response(self, inputs: Array) -> Array:
        """Outputs (steps, outputs) to inputs (steps, inputs) from the point that was marked."""
        self.back()
        return np.array([self.step(row) for row in inputs.tolist()])


@dataclass(frozen=True, eq=False)
class Derivative:
    """Response of all outputs to one sample of one input, per unit of it."""

    name: str   # the input
    # by Richardson's extrapolation, A/m for a command by a measurement; zeros where it has none; shape (samples,
    # outputs)
    response: Array
    coarse: Array   # by the smaller of the two sizes alone; shape (samples, outputs)
    error: float   # how much larger a difference between the two can be than a response is, relative to the largest one
    holds_to: float   # largest push at which it was the same within 1 %, m; more was not tried than the largest
    verdict: str = ""   # reason if the derivative does not exist, otherwise empty


def derivative(part: Participant, base: Array, number: int, scale: float, samples: int,
               check: bool = True) -> Derivative:
    """Derivative of a participant's outputs with respect to one of its inputs, from the point that it has marked.

    While nothing is pushed its inputs are those of `base`, shape (inputs,); sizes of pushes are in units of `scale`,
    which is in the input's unit. Without `check` the largest two sizes are taken. FmuError if it refuses a step.
    """
    pushes = [scale * size for size in SIZES]
    first, holds_to = 0, pushes[0]
    if check:
        smooth, why = look(part, base, number, pushes)
        why = why or varying(part, base, number, pushes[smooth or 0])
        if smooth is None or why:
            nothing = np.zeros((samples, len(part.outputs)))
            return Derivative(part.inputs[number], nothing, nothing, np.inf, 0.0, why)
        first, holds_to = smooth, pushes[smooth]
    large, small = (central(part, base, number, pushes[first + k], samples) for k in (0, 1))
    ratio = (pushes[first] / pushes[first + 1]) ** 2
    best = (ratio * small - large) / (ratio - 1.0)
    most = float(np.abs(best).max())
    error = float(np.abs(best - small).max()) / most if most else 0.0
    return Derivative(part.inputs[number], best, small, error, holds_to)


def central(part: Participant, base: Array, number: int, push: float, samples: int, later: int = 0) -> Array:
    """Central difference of the responses, from then on, to a push of one sample and to its opposite."""
    up, down = (part.response(pushed(base, number, size, samples + later, later))[later:] for size in (push, -push))
    return (up - down) / (2.0 * push)


def pushed(base: Array, number: int, push: float, samples: int, later: int = 0) -> Array:
    """Inputs that are held except for one sample of one of them."""
    rows = np.tile(base, (samples, 1))
    rows[later, number] += push
    return rows


def varying(part: Participant, base: Array, number: int, push: float) -> str:
    """Return the reason why this is no linear system at these samples: a later push has another response; empty if
    equal.
    """
    now = central(part, base, number, push, WINDOW)
    for later in range(1, LATER + 1):
        then = central(part, base, number, push, WINDOW, later)
        if np.abs(then - now).max() > KINK * max(np.abs(now).max(), np.abs(then).max()) > ROUND_OFF / push:
            return f"a push {later} samples later has another response: it samples more slowly, or varies with time"
    return ""


def look(part: Participant, base: Array, number: int, pushes: Sequence[float]) -> tuple[int | None, str]:
    """Return the number of the first push from which the derivative holds, even; or None, and the reason."""
    rest = part.response(pushed(base, number, 0.0, WINDOW))
    up, down = ([(part.response(pushed(base, number, sign * push, WINDOW)) - rest) / push for push in pushes]
                for sign in (1.0, -1.0))
    slopes = [0.5 * (u - d) for u, d in zip(up, down, strict=True)]
    sizes = [float(np.abs(slope).max()) for slope in slopes]
    nothing = [ROUND_OFF * max(1.0, float(np.abs(rest).max())) / push for push in pushes]
    if all(size <= small for size, small in zip(sizes, nothing, strict=True)):
        for size in LARGE:
            push = pushes[0] / SIZES[0] * size
            if np.abs(part.response(pushed(base, number, push, WINDOW)) - rest).max() > nothing[0] * pushes[0]:
                return None, f"no response to {length(pushes[0])}, one to {length(push)}: a rounding or a dead zone"
        return 0, ""   # it does not depend on this input
    if sizes[-1] <= nothing[-1]:
        silent = max(push for push, size, small in zip(pushes, sizes, nothing, strict=True) if size <= small)
        return None, f"no response to {length(silent)}, one to more: a rounding or a dead zone"
    kinks = [float(np.abs(u + d).max()) / max(size, 1e-300) for u, d, size in zip(up, down, sizes, strict=True)]
    same = [float(np.abs(slopes[k] - slopes[k + 1]).max()) / max(sizes[k], sizes[k + 1], 1e-300)
            for k in range(len(slopes) - 1)]
    if same[-1] > SAME:
        growth = sizes[-1] / sizes[-3] / (pushes[-3] / pushes[-1])
        if 0.5 < growth < 2.0:
            return None, f"a step: {length(pushes[-1])} change it as much as {length(pushes[-3])}"
        return None, (f"the slope changes with the size, by {100.0 * same[-1]:.2g} % from {length(pushes[-2])} to "
                      f"{length(pushes[-1])}: rounding, noise, or an iteration that ends early")
    if kinks[-1] > KINK:
        return None, f"a kink: up and down differ by {100.0 * kinks[-1]:.2g} %"
    first = len(pushes) - 2
    while first > 0 and same[first - 1] <= SAME and kinks[first - 1] <= KINK:
        first -= 1
    return first - first % 2, ""


def length(push: float) -> str:
    """A push of a length in µm (or an angle in µrad, a current in µA), to read."""
    return f"{1e6 * push:.3g} µ"
