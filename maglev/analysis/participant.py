"""One FMU, or a user's class, stepped by itself from a point of its past, any number of times.

Its state is saved by its own means (fmi2GetFMUstate, or a copy of the object). Without such means it is made again and
gets the inputs of its past once more.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from maglev.cosim.fmu import Fmu
from maglev.cosim.master import FmuSetup
from maglev.cosim.open import open_fmu, read_description
from maglev.cosim.port_map import apply
from maglev.cosim.wiring import Call, Rate, Track, step_calls, value_calls
from maglev.files.arrays import Array
from maglev.files.errors import FmuError, LinearModelError

FOREVER = 1e6      # s, stop time that is given at the initialization
OFTEN = 500        # steps between two signs of life
REPEATED = 1e-12   # relative difference at which the same inputs count as having given the same outputs

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
        description = read_description(self.setup.name, self.setup.source)
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
