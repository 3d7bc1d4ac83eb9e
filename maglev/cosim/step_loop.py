"""The step loop in C: compiled with the native FMUs, it lies in their folder and makes the calls of runs.

FMUs that run Python inside are C functions, too: those with a folder `native` in or beside theirs are stepped by it. A
library that is missing, or of another version, is not used: the loop of `stepping` does the same in Python.
"""

import hashlib
from _ctypes import CFuncPtr
from collections.abc import Iterable, Sequence
from ctypes import CDLL, POINTER, Structure, addressof, c_double, c_int64, c_size_t, c_uint, c_uint64, c_void_p, cast
from functools import cache
from itertools import accumulate
from pathlib import Path
from typing import Any

from fmpy import sharedLibraryExtension

from maglev.cosim.versions.fmi import Exchange3, Step3
from maglev.cosim.wiring import Call

SOURCE = Path(__file__).with_name("step_loop.c")
LIBRARY = f"maglev_step_loop{sharedLibraryExtension}"


class Prepared(Structure):
    """A call as the C loop takes it, which says what the members are."""

    _fields_ = (("function", c_void_p), ("instance", c_void_p), ("references", c_void_p), ("count", c_size_t),
                ("row", c_void_p), ("row_stride", c_int64), ("time", c_double), ("time_stride", c_double),
                ("step", c_double), ("fmi3", c_int64))


class StepLoop:
    """Calls of a co-simulation, phase by phase, and the C function that makes them."""

    def __init__(self, function: Any, phases: Sequence[Sequence[Call]], counter: memoryview):
        self.function = function
        self.counter = c_int64.from_buffer(counter)
        self.calls = [call for phase in phases for call in phase]
        self.prepared = (Prepared * len(self.calls))(*map(prepared, self.calls))
        self.ends = (c_int64 * len(phases))(*accumulate(map(len, phases)))

    def step_over(self, first: int, last: int, origin: int) -> tuple[int, Call, int] | None:
        """Make steps as a `Stepper` does; step, call and status of a refusal if there is one."""
        refused = (c_int64 * 2)()
        status = self.function(self.prepared, self.ends, len(self.ends), first, last, origin,
                               self.counter, refused)
        return (refused[0], self.calls[refused[1]], status) if status else None


def prepared(call: Call) -> Prepared:
    """A call of a C function as the C loop takes it."""
    function, instance = cast(c_function(call), c_void_p).value, call.arguments[0].value
    fmi3 = c_function(call) is not call.function
    if isinstance(call.moving, c_double):
        step = call.arguments[2].value
        return Prepared(function, instance, None, 0, None, 0, call.base, call.stride, step, fmi3)
    _, references, count, _ = call.arguments
    return Prepared(function, instance, addressof(references), count.value, int(call.base), int(call.stride),
                    fmi3=fmi3)


def c_function(call: Call) -> Any:
    """What a call calls: of FMI 3.0, the C function in what makes it look like one of FMI 2.0."""
    return call.function.function if isinstance(call.function, (Exchange3, Step3)) else call.function


def folders_for(fmu: Path) -> tuple[Path, ...]:
    """Folders in which the C loop may lie that steps an FMU."""
    folder = fmu.absolute().parent
    return folder, folder.parent, folder / "native", folder.parent / "native"


def compiled(phases: Sequence[Sequence[Call]], folders: Iterable[Path], counter: memoryview) -> StepLoop | None:
    """The calls under the C loop of the first folder that has one; None if none has, or a call is not of C.

    The loop counts them in the counter, an integer of 64 bits.
    """
    if not all(isinstance(c_function(call), CFuncPtr) for phase in phases for call in phase):
        return None
    functions = (step_function(folder / LIBRARY) for folder in dict.fromkeys(folders))
    return next((StepLoop(function, phases, counter) for function in functions if function is not None), None)


def step_function(path: Path) -> Any:
    """C function of a library; None if there is none of this version."""
    try:
        library = CDLL(str(path.absolute()))
        library.maglev_step_loop_version.restype = c_uint64
        if library.maglev_step_loop_version() != version():
            return None
        function = library.maglev_step_over
    except (OSError, AttributeError):   # no library of this machine, or another one
        return None
    function.restype = c_uint
    function.argtypes = [POINTER(Prepared), POINTER(c_int64), c_int64, c_int64, c_int64, c_int64,
                         POINTER(c_int64), POINTER(c_int64)]
    return function


@cache
def version() -> int:
    """Version of the loop: a number for its text."""
    return int.from_bytes(hashlib.sha256(SOURCE.read_bytes()).digest()[:8])


def source() -> str:
    """Text to compile."""
    return f"#define VERSION {version()}ull\n" + SOURCE.read_text(encoding="utf-8")
