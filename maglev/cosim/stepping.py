"""The calls of communication steps, made one after the other as fast as fmpy's C interface allows.

The moving arguments of all calls lie side by side in one buffer, so that one copy moves them to the next communication
point; their values are computed ahead, many points at a time.
"""

from collections.abc import Sequence
from ctypes import c_double
from itertools import cycle
from typing import Any

import numpy as np

from maglev.cosim.fmu import WARNING
from maglev.cosim.wiring import Call

SLOT = 8   # bytes of a moving argument: an address, a row number, or a time


class StepFailed(Exception):
    """A step that an FMU refused or the user interrupted, and its number."""

    def __init__(self, step: int, reason: BaseException):
        super().__init__(str(reason))
        self.step = step
        self.reason = reason


class Phase:
    """The calls of a communication step, bound to a buffer of their moving arguments."""

    def __init__(self, calls: Sequence[Call]):
        self.calls = calls
        memory = bytearray(SLOT * len(calls))
        self.slots = memoryview(memory).cast("Q")
        self.prepared: list[tuple[Any, tuple[Any, ...]]] = []
        for i, call in enumerate(calls):
            moving = type(call.moving).from_buffer(memory, SLOT * i)
            self.prepared.append((call.function, tuple(moving if argument is call.moving else argument
                                                       for argument in call.arguments)))

    def positions(self, first: int, last: int) -> "memoryview[int]":
        """Moving arguments at the communication points from the first to before the last, point by point."""
        table = np.empty((last - first, len(self.calls)), dtype=np.uint64)
        points = np.arange(first, last)
        for i, call in enumerate(self.calls):
            kind = np.float64 if isinstance(call.moving, c_double) else np.int64
            table[:, i] = np.asarray(call.base + points * call.stride, dtype=kind).view(np.uint64)
        return table.reshape(-1).data.cast("B").cast("Q")


def step_over(phases: Sequence[Phase], first: int, last: int) -> None:
    """Make the communication steps from the first to before the last; step k those of phase k modulo their number.

    Raises
    ------
    StepFailed
        If an FMU refuses a call, or the user interrupts.
    """
    row = 0
    turn = first % len(phases)
    turning = [(phase.slots, phase.positions(first, last), len(phase.calls), phase.prepared)
               for phase in (*phases[turn:], *phases[:turn])]
    try:
        for row, (slots, table, width, prepared) in zip(range(last - first), cycle(turning)):   # noqa: B905 - no end
            slots[:] = table[row * width:(row + 1) * width]
            for function, arguments in prepared:
                status = function(*arguments)
                if status > WARNING:
                    phase = phases[(first + row) % len(phases)]
                    call = next(call for call, bound in zip(phase.calls, phase.prepared, strict=True)
                                if bound[1] is arguments)
                    raise StepFailed(first + row, call.failed(status))
    except KeyboardInterrupt as error:
        raise StepFailed(first + row, error) from None
