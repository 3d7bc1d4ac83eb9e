"""The calls of communication steps, made one after the other: in C where that is possible, otherwise in Python.

The loop in C is compiled with the first native FMUs. It is loaded from the user's cache, by its content, and never
taken from where FMUs or results lie. FMUs that run Python inside are C functions, too.
"""

import ctypes
import hashlib
from _ctypes import CFuncPtr
from collections.abc import Sequence
from ctypes import c_double, c_int64, c_size_t, c_uint, c_uint64, c_void_p
from functools import cache
from itertools import accumulate
from pathlib import Path
from typing import Any

from fmpy import sharedLibraryExtension

from maglev.cosim.fmi_versions import Exchange3, Step3
from maglev.cosim.wiring import Call
from maglev.files.cache import STEP_LOOP, Kept, keep, kept, key_of
from maglev.files.errors import FmuError
from maglev.fmi.compiler import FLAGS, library
from maglev.fmi.native_build import host_platform

SOURCE = Path(__file__).with_name("step_loop.c")
EARLY, END = 100, 101   # statuses of the loop in C, described there
LIBRARY = f"maglev_step_loop{sharedLibraryExtension}"


class Prepared(ctypes.Structure):
    """A call as the C loop takes it; the members are described there."""

    _fields_ = (("function", c_void_p), ("instance", c_void_p), ("references", c_void_p), ("count", c_size_t),
                ("row", c_void_p), ("row_stride", c_int64), ("time", c_double), ("time_stride", c_double),
                ("step", c_double), ("fmi3", c_int64), ("warnings", c_int64))


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
        refused, reached = (c_int64 * 2)(), c_double()
        status: int = self.function(self.prepared, self.ends, len(self.ends), first, last, origin,
                                    self.counter, refused, ctypes.byref(reached))
        if not status:
            return None
        k, call = refused[0], self.calls[refused[1]]
        if status in (EARLY, END):
            size = call.arguments[2].value
            status = call.function.discarded(status == END, reached.value, call.base + k * call.stride + size)
        return k, call, status


def prepared(call: Call) -> Prepared:
    function, instance = ctypes.cast(c_function(call), c_void_p).value, call.arguments[0].value
    fmi3 = c_function(call) is not call.function
    if isinstance(call.moving, c_double):
        step = call.arguments[2].value
        return Prepared(function, instance, None, 0, None, 0, call.base, call.stride, step, fmi3)
    _, references, count, _ = call.arguments
    return Prepared(function, instance, ctypes.addressof(references), count.value, int(call.base), int(call.stride),
                    fmi3=fmi3)


def c_function(call: Call) -> Any:
    """Return the function of a call: for FMI 3.0, the C function inside the adapter to FMI 2.0."""
    return call.function.function if isinstance(call.function, (Exchange3, Step3)) else call.function


def in_c(phases: Sequence[Sequence[Call]]) -> bool:
    """Return True if all calls are of C functions, as the C loop makes them."""
    return all(isinstance(c_function(call), CFuncPtr) for phase in phases for call in phase)


def own_loop() -> Kept | None:
    """Return the library with the loop of this installation; None if it was not built, or has changed since."""
    return kept(step_loop_key(), LIBRARY)


def build_loop() -> Kept:
    """The same, compiled if it is not there; ExportError without a compiler, OSError if it cannot be written."""
    platform, = host_platform().values()
    return own_loop() or keep_loop(library({"step_loop.c": source()}, Path(LIBRARY).stem, platform))


def keep_loop(content: bytes) -> Kept:
    """Keep a library as that of this installation; OSError if it cannot be written."""
    return keep(step_loop_key(), LIBRARY, content)


@cache
def step_loop_key() -> str:
    """Return the key of this version's loop on this machine: of its text and of the compiler's flags."""
    platform, = host_platform().values()
    return key_of(STEP_LOOP, source(), FLAGS, platform)


@cache
def step_function(loop: Kept) -> Any:
    """C function of a library; None of another version, FmuError if it has changed since the run was made ready."""
    if not loop.intact:
        raise FmuError(f"{loop.path}: has changed since the run was prepared; `maglev build --kind native` rebuilds it")
    try:
        loaded = ctypes.CDLL(str(loop.path.absolute()))
        loaded.maglev_step_loop_version.restype = c_uint64
        if loaded.maglev_step_loop_version() != version():
            return None
        function = loaded.maglev_step_over
    except (OSError, AttributeError):   # not a library of this machine, or another library
        return None
    function.restype = c_uint
    function.argtypes = [ctypes.POINTER(Prepared), ctypes.POINTER(c_int64), c_int64, c_int64, c_int64, c_int64,
                         ctypes.POINTER(c_int64), ctypes.POINTER(c_int64), ctypes.POINTER(c_double)]
    return function


@cache
def version() -> int:
    """Version of the loop: a number for its text."""
    return int.from_bytes(hashlib.sha256(SOURCE.read_bytes()).digest()[:8])


def source() -> str:
    return f"#define VERSION {version()}ull\n" + SOURCE.read_text(encoding="utf-8")


class StepFailed(Exception):
    """A step in which an FMU failed or which the user interrupted, and its number."""

    def __init__(self, step: int, reason: BaseException):
        super().__init__(str(reason))
        self.step = step
        self.reason = reason


def new_counter() -> memoryview:
    """A counter of calls: one integer of 64 bits."""
    return memoryview(bytearray(8)).cast("q")


class Stepper:
    """Makes communication steps; step k makes the calls of phase k modulo their number.

    The C loop of a library makes them if one is given, and all are calls of C functions. Both loops give the same bits,
    and count each call in the counter before they make it: another process sees which one does not return.
    """

    def __init__(self, phases: Sequence[Sequence[Call]], loop: Kept | None = None, counter: memoryview | None = None):
        self.phases = phases
        self.counter = new_counter() if counter is None else counter
        function = step_function(loop) if loop is not None and in_c(phases) else None
        self.loop = None if function is None else StepLoop(function, phases, self.counter)

    def step_over(self, first: int, last: int, origin: int = 0) -> None:
        """Make the communication steps from the first to before the last; rows begin with communication point `origin`.

        StepFailed if an FMU refuses a call, or the user interrupts.
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
        if self.loop is None:
            return
        for call, ready in zip(self.loop.calls, self.loop.prepared, strict=True):
            fmu, what = call.what
            if ready.warnings:
                fmu.messages.warned(what, ready.warnings)
