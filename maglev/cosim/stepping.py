"""The calls of communication steps, made one after the other: in C where that is possible, otherwise in Python."""

from collections.abc import Sequence

from maglev.cosim.step_loop import StepLoop, in_c, step_function
from maglev.cosim.wires.wiring import Call
from maglev.errors import FmuError
from maglev_files.cache import Kept


class StepFailed(Exception):
    """A step that an FMU refused or the user interrupted, and its number."""

    def __init__(self, step: int, reason: BaseException):
        super().__init__(str(reason))
        self.step = step
        self.reason = reason


def new_counter() -> memoryview:
    """A counter of calls: one integer of 64 bits."""
    return memoryview(bytearray(8)).cast("q")


class Stepper:
    """Makes communication steps; step k makes the calls of phase k modulo their number.

    The C loop of a library makes them if one is given, and all are calls of C functions. Both loops give the same, bit
    for bit, and count each call in the counter before they make it: who looks on from another process sees which one
    does not return.
    """

    def __init__(self, phases: Sequence[Sequence[Call]], loop: Kept | None = None, counter: memoryview | None = None):
        self.phases = phases
        self.counter = new_counter() if counter is None else counter
        function = step_function(loop) if loop is not None and in_c(phases) else None
        self.loop = None if function is None else StepLoop(function, phases, self.counter)

    def step_over(self, first: int, last: int, origin: int = 0) -> None:
        """Make the communication steps from the first to before the last; rows begin with communication point `origin`.

        Raises
        ------
        StepFailed
            If an FMU refuses a call, or the user interrupts.
        """
        k, counter = first, self.counter
        try:
            if self.loop is None:
                phases = [[call.with_rows_from(origin) for call in phase] for phase in self.phases]
                for k in range(first, last):
                    for moving, base, stride, function, arguments, (fmu, what) in phases[k % len(phases)]:
                        counter[0] += 1
                        moving.value = base + k * stride
                        status = function(*arguments)
                        if status:
                            fmu.require(what, status)
            elif (refusal := self.loop.step_over(first, last, origin)) is not None:
                k, call, status = refusal
                raise call.failed(status)
        except (FmuError, KeyboardInterrupt) as error:
            raise StepFailed(k, error) from None

    def tell_warnings(self) -> None:
        """Tell each FMU which of its calls have returned a warning, and how often."""
        for call, number in self.loop.warnings() if self.loop is not None else ():
            fmu, what = call.what
            fmu.messages.warned(what, number)
