"""Differences of FMI 2.0 and 3.0 in a co-simulation: names, types and arguments of functions; and messages."""

import ctypes
import re
from collections import deque
from collections.abc import Callable, Mapping
from ctypes import addressof, byref, c_bool, c_double, c_int, c_size_t, c_uint32, c_void_p, create_string_buffer
from itertools import count
from math import nan
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.logging import addLoggerProxy
from fmpy.model_description import ModelDescription

from maglev.cosim.clocks import PUNCTUAL, Ticking, clocks_of
from maglev.cosim.model_exchange import ENDS, Integration, SolverInterface
from maglev.files.errors import in_one_line
from maglev.files.session import SESSION

Listener = Callable[[int, bytes], None]   # called with status and text of a message

OWN_TOOL = "Maglev FMUs"   # generationTool of this project

WARNING = 1   # fmi2Warning, fmi3Warning; a higher status is a failure
DISCARD = 2   # fmi2Discard, fmi3Discard


class Listening(NamedTuple):
    """Receiver of an FMU's messages, the environment that it gets, and True if it claims to be of this project."""

    listener: Listener
    environment: Any
    own: bool


class Listeners:
    """Receivers of the messages of FMI 2.0 by the names of the instances, each of which has a name of its own."""

    def __init__(self) -> None:
        self.by_name: dict[bytes | None, Listening] = {}
        self.numbers = count(1)

    def key(self, name: str) -> bytes:
        """Return a new name for an instance of an FMU with this name."""
        return f"{name}#{next(self.numbers)}".encode()


class Type(NamedTuple):
    """A type of variables: the end of the functions' names, and the type of a value in C, in arrays, in recordings."""

    function: str
    value: Any
    item: type
    recorded: type


class Fmi:
    """FMI 2.0: `types` are those that can be recorded and connected, by the names that they have here."""

    prefix: ClassVar = "fmi2"
    types: ClassVar[Mapping[str, Type]] = {
        "Real": Type("Real", c_double, np.float64, np.float64), "Integer": Type("Integer", c_int, np.int32, np.int32),
        "Boolean": Type("Boolean", c_int, np.int32, np.int32)}

    def instantiated(self, description: ModelDescription, folder: Path, name: bytes, listener: Listener) -> Any:
        """Load an unpacked FMU and instantiate it; fmpy's object of it."""
        identifier = description.coSimulation.modelIdentifier
        # FMI 2.0 has no folder for Linux on ARM, where fmpy would load the binary for Intel; FMI 3.0's name is allowed.
        own = folder.absolute() / "binaries" / fmpy.platform_tuple / f"{identifier}{fmpy.sharedLibraryExtension}"
        kind = fmi2.FMU2Model if isinstance(description.coSimulation, SolverInterface) else fmi2.FMU2Slave
        instance = kind(guid=description.guid, unzipDirectory=str(folder), modelIdentifier=identifier,
                        instanceName=name.decode(), libraryPath=str(own) if own.is_file() else None)
        own_tool = (description.generationTool or "").startswith(OWN_TOOL)
        listening = Listening(listener, create_string_buffer(name), own_tool)
        SESSION.get(Listeners).by_name[name] = listening
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.componentEnvironment = addressof(listening.environment)
        callbacks.logger = LOGGER
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        addLoggerProxy(byref(callbacks))
        # Logging stays on: an FMU says why it refuses only there.
        instance.instantiate(callbacks=callbacks, loggingOn=True)
        return instance

    def name(self, verb: str, kind: str) -> str:
        """Name of a function that gets or sets values of a type."""
        return f"{self.prefix}{verb}{self.types[kind].function}"

    def functions(self, instance: Any, verb: str) -> dict[str, Any]:
        """C functions that get or set values, by type."""
        return {kind: function_of(instance, self.name(verb, kind)) for kind in self.types}

    def do_step(self, instance: Any, description: ModelDescription, say: Callable[[str], None]) -> Any:
        """The C function that makes a communication step, or a wrapper of it; for FMUs without one, a solver."""
        if isinstance(instance, fmi2.FMU2Model):
            return Integration(instance, description, instance.newDiscreteStates, say)
        return function_of(instance, "fmi2DoStep")

    def initialised(self, instance: Any, start_time: float, stop_time: float, set_values: Callable[[], None],
                    give_inputs: Callable[[], None], ticking: Ticking | None) -> None:
        instance.setupExperiment(startTime=start_time, stopTime=stop_time)
        set_values()
        instance.enterInitializationMode()
        give_inputs()
        instance.exitInitializationMode()


class Exchange3:
    """A function of FMI 3.0 that gets or sets values, called as one of FMI 2.0: each variable has one value."""

    def __init__(self, function: Any):
        self.function = function

    def __call__(self, instance: c_void_p, references: Any, count: c_size_t, values: Any) -> int:
        status: int = self.function(instance, references, count, values, count)
        return status


class Step3:
    """fmi3DoStep called as fmi2DoStep: a step that is not made to its end is a discarded one, and `say` is told why."""

    def __init__(self, function: Any, say: Callable[[str], None]):
        self.function = function
        self.say = say
        self.flags = (c_bool(), c_bool(), c_bool())   # event, end, early return
        self.last = c_double()                        # s, where it has come to
        self.places = (c_bool(True), *map(byref, self.flags), byref(self.last))

    @property
    def event(self) -> bool:
        """Return True if the last step has ended in an event."""
        return bool(self.flags[0].value)

    def __call__(self, instance: c_void_p, time: c_double, step: c_double, _no_set_before: c_int) -> int:
        for flag in self.flags:   # not every FMU sets all
            flag.value = False
        self.last.value = nan
        status: int = self.function(instance, time, step, *self.places)
        end = time.value + step.value
        early = self.flags[2].value and not abs(self.last.value - end) <= PUNCTUAL * step.value
        if status <= WARNING and (self.flags[1].value or early):
            return self.discarded(self.flags[1].value, self.last.value, end)
        return status

    def discarded(self, ends: bool, last: float, end: float) -> int:
        """Status of a step to a time (s) from which an FMU asks for the end, or has returned early (s)."""
        self.say(ENDS if ends else f"it returned early, at lastSuccessfulTime = {last:.9g} s, expected {end:.9g} s")
        return DISCARD


class Fmi3(Fmi):
    """FMI 3.0, with event mode where there are clocks; without early return and intermediate update."""

    prefix: ClassVar = "fmi3"
    types: ClassVar[Mapping[str, Type]] = {
        "Real": Type("Float64", c_double, np.float64, np.float64),
        "Integer": Type("Int32", ctypes.c_int32, np.int32, np.int32),
        "Boolean": Type("Boolean", c_bool, np.uint8, np.uint8),
        "Int64": Type("Int64", ctypes.c_int64, np.int64, np.int64),
        "UInt64": Type("UInt64", ctypes.c_uint64, np.uint64, np.uint64),
        "Float32": Type("Float32", ctypes.c_float, np.float32, np.float64),
        "Int8": Type("Int8", ctypes.c_int8, np.int8, np.int64),
        "UInt8": Type("UInt8", ctypes.c_uint8, np.uint8, np.int64),
        "Int16": Type("Int16", ctypes.c_int16, np.int16, np.int64),
        "UInt16": Type("UInt16", ctypes.c_uint16, np.uint16, np.int64),
        "UInt32": Type("UInt32", ctypes.c_uint32, np.uint32, np.int64)}

    def instantiated(self, description: ModelDescription, folder: Path, name: bytes, listener: Listener) -> Any:
        def listen(_environment: object, status: int, _category: bytes, message: bytes) -> None:
            listener(status, message)

        kind = FMU3Model if isinstance(description.coSimulation, SolverInterface) else FMU3Slave
        instance = kind(guid=description.guid, unzipDirectory=str(folder),
                        modelIdentifier=description.coSimulation.modelIdentifier, instanceName=name.decode())
        clocked = {"eventModeUsed": True} if clocks_of(description) else {}
        instance.instantiate(loggingOn=True, logMessage=listen, **clocked)
        return instance

    def functions(self, instance: Any, verb: str) -> dict[str, Any]:
        return {kind: Exchange3(function) for kind, function in super().functions(instance, verb).items()}

    def do_step(self, instance: Any, description: ModelDescription, say: Callable[[str], None]) -> Any:
        if isinstance(instance, FMU3Model):
            return Integration(instance, description, instance.updateDiscreteStates, say)
        return Step3(function_of(instance, "fmi3DoStep"), say)

    def initialised(self, instance: Any, start_time: float, stop_time: float, set_values: Callable[[], None],
                    give_inputs: Callable[[], None], ticking: Ticking | None) -> None:
        set_values()
        instance.enterInitializationMode(startTime=start_time, stopTime=stop_time)
        give_inputs()
        if ticking is not None:
            ticking.look()
        instance.exitInitializationMode()
        if ticking is not None:
            ticking.begin(start_time)


def function_of(instance: Any, name: str) -> Any:
    """A C function, an object of our own without argument types: C objects as arguments need no conversion."""
    function = instance.dll[name]
    function.restype = c_uint32   # a status below zero, which FMI does not know, is then beyond a warning
    return function


def take_message(environment: int | None, instance: bytes | None, status: int, _category: bytes,
                 message: bytes | None) -> None:
    """Pass a message on to its listener: fmpy's proxy, which formats messages, passes those of all FMUs to here.

    Some FMUs give another name than their instance has, or none. The environment tells them apart; where that is lost,
    too, it was one of those that are not of this project, and all of them are listened to.
    """
    by_name = SESSION.get(Listeners).by_name
    every = [*by_name.values()]
    told = ([by_name[instance]] if instance in by_name
            else [each for each in every if environment == addressof(each.environment)]
            or [each for each in every if not each.own] or every)
    for each in told:
        each.listener(status, message or b"")


LOGGER = fmi2.fmi2CallbackLoggerTYPE(take_message)

FMI2, FMI3 = Fmi(), Fmi3()


def fmi_of(description: ModelDescription) -> Fmi:
    return FMI2 if description.fmiVersion == "2.0" else FMI3


MOST_MESSAGES = 20      # of an FMU that are kept
LONGEST_MESSAGE = 500   # characters of one of them

# Exceptions as pythonfmu's binary reports them; the text is for people.
PYTHON_EXCEPTION = re.compile(r"""^Fatal py exception encountered: \[\w+\] \w+ \w+\((["'])(.*)\1\)$""")


class Messages:
    """Messages of one FMU, whose status is not fmi2OK."""

    def __init__(self) -> None:
        self.latest: deque[str] = deque(maxlen=MOST_MESSAGES)   # since somebody asked
        self.counts: dict[str, int] = {}   # of the first different ones
        self.others = 0                    # messages beyond these
        self.warnings: dict[str, int] = {}   # calls that returned one, with their numbers

    def add(self, text: str) -> None:
        text = PYTHON_EXCEPTION.sub(r"\2", in_one_line(text))
        text = text if len(text) <= LONGEST_MESSAGE else text[:LONGEST_MESSAGE] + "…"
        self.latest.append(text)
        if text in self.counts or len(self.counts) < MOST_MESSAGES:
            self.counts[text] = self.counts.get(text, 0) + 1
        else:
            self.others += 1

    def told(self, status: int, message: bytes) -> None:
        """Take in a message of an FMU, with its status."""
        if status != 0:
            self.add((message or b"").decode("utf-8", "replace"))

    def warned(self, call: str, number: int = 1) -> None:
        self.warnings[call] = self.warnings.get(call, 0) + number

    def take(self) -> str:
        """The latest messages, which are not given again."""
        text = "; ".join(self.latest)
        self.latest.clear()
        return text

    def summary(self) -> str:
        """All messages since the beginning, each text once with its number; empty if there are none.

        Of calls that returned a warning it is said only where no text came with it.
        """
        counts = self.counts or {f"a warning from {call}, without a text": number
                                 for call, number in self.warnings.items()}
        texts = [text if number == 1 else f"{text} ({number} times)" for text, number in counts.items()]
        return "; ".join([*texts, *([f"and {self.others} more messages"] if self.others else [])])
