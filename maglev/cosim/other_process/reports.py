"""What is said between the two processes of a co-simulation apart."""

from collections.abc import Sequence
from typing import NamedTuple

from maglev.cosim.master import FmuSetup
from maglev.cosim.order import Order
from maglev.cosim.wiring import Drives

COUNTER = "calls"   # file with the number of calls that were begun
TRACK = "track"     # files of the arrays, TRACK0.float64 and so on


class Job(NamedTuple):
    """A run, as of `Master`."""

    setups: Sequence[FmuSetup]
    connections: Sequence[tuple[str, str]]
    step: float
    order: Order
    stop_time: float
    drives: Drives


class Stage(NamedTuple):
    """A call of an FMU, by its name; as a report: what is done with it now, while no calls are counted."""

    fmu: str
    doing: str


STARTING = Stage("the process of the run", "its start")
ENDING = Stage("the process of the run", "its end")


class Wired(NamedTuple):
    """Report: the calls before the first step, those of each phase, and the columns of each array."""

    initial: list[Stage]
    phases: list[list[Stage]]
    columns: list[list[str]]


class Stepped(NamedTuple):
    """Report: progress."""

    done: int
    steps: int


class Finished(NamedTuple):
    """Report: the recording is complete; notes as of `Recording`."""

    notes: tuple[str, ...]


class Failed(NamedTuple):
    """Report: an FMU refused a call, after so many rows; with the traceback of that."""

    message: str
    rows: int
    traceback: str
