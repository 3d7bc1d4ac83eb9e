"""The pythonfmu slave of a block: prepared variable access, checks before a step, and the whole state."""

import json
import os
import re
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from ctypes import py_object, pythonapi
from math import floor, inf
from numbers import Real
from typing import Any
from xml.etree.ElementTree import ParseError, iterparse

from pythonfmu.fmi2slave import Fmi2Slave

from maglev.fmi.definition import FmuDefinition, Slot, Variable, look, put, read, reader

# Largest difference between a master's clock and the end of the step before, and the step that counts as none: see
# native/c/life.c.
CONTINUITY = 1.0e-3     # of a communication step
LARGEST_MISS = 1.0e-5   # s
ROUNDING = 1.0e-14      # of the time
NO_STEP = 1.0e-8        # s
RESOLUTION = 2.0**-51   # of the time: two of its last bits, one for each of the times that a step is the difference of
LARGEST_RATIO = 1.0e9   # of steps in a sample, or samples in a step: more fit none
FITTING = 0.999e-6      # of a step: a block that samples takes one for whole that misses it by so much

# Phases of an instance (FMI 2.0.5, figure 11), in the words of a refusal.
INSTANTIATED = "before fmi2EnterInitializationMode"
INITIALIZING = "in the initialization"
RUNNING = "after the initialization"
TERMINATED = "after fmi2Terminate"

PHASES = (INSTANTIATED, INITIALIZING, RUNNING, TERMINATED)


class Refused(ValueError):
    """A request that the FMU does not carry out; the message names the variable, its value and the expected value."""


def one_more_reference(held: object) -> None:
    """Take a reference to an object that is never given up here: pythonfmu's binary gives one up that it never had."""
    pythonapi.Py_IncRef(py_object(held))


def described_guid(resources: str | None) -> str | None:
    """GUID in the model description next to the resources of an FMU, which importers pass on; None without one.

    That they give it to fmi2Instantiate is of no use: pythonfmu's binary keeps it to itself.
    """
    if resources is None:
        return None
    try:
        with open(os.path.join(resources, os.pardir, "modelDescription.xml"), "rb") as file:
            guid: str | None = next(iterparse(file, ("start",)))[1].get("guid")
    except (OSError, ParseError, StopIteration):
        return None
    return guid


def scalar_slots(block: Any, template: Any) -> list[Slot]:
    """Every number and Boolean that a block and its parts hold, in the order of their definition.

    The names come from a template, another block of the class: CPython accesses the attributes of an object twice as
    slowly once its `__dict__` has been asked for.
    """
    slots: list[Slot] = []
    listed = isinstance(template, list)
    parts: Iterable[tuple[str | int, Any]] = enumerate(template) if listed else vars(template).items()
    for name, value in parts:
        if isinstance(value, (bool, int, float)):
            slots.append((block, name))
        else:
            slots.extend(scalar_slots(look(block, name), value))
    return slots


class BlockSlave(Fmi2Slave):
    """Executes a block; pythonfmu calls its methods and reports their exceptions.

    An exception is the only refusal that every importer notices. A step that returns False ends a simulation early
    without an error, and pythonfmu ignores the result of the end of the initialization.
    """

    # Exceptions of a block that become messages: C continues with inf or NaN where Python raises.
    raised: tuple[type[BaseException], ...] = (ArithmeticError, ValueError)

    def __init__(self, definition: FmuDefinition, guid: str | None = None, **kwargs: Any):
        super().__init__(**kwargs)
        if not self.instance_name:
            raise Refused("instance name = '', expected one")
        described = described_guid(self.resources) if guid else None
        if described not in (guid, None):
            raise Refused(f"GUID = {described}, expected {guid}: model description and code are not of the same FMU")
        if self.resources in sys.path:   # pythonfmu's binary puts it there for every instance, and never takes it out
            sys.path.remove(self.resources)
        self.definition = definition
        self.block = definition.new_block()
        self.variables = definition.variables
        self.state_slots = self.slots()
        self.real_getters: dict[tuple[int, ...], Callable[[Any], tuple[Any, ...]]] = {}
        self.boolean_getters: dict[tuple[int, ...], Callable[[Any], tuple[Any, ...]]] = {}
        self.setters: dict[tuple[int, ...], list[tuple[Any, str | int, float, float]]] = {}
        self.phase = INSTANTIATED
        self.stale = True                    # values of a block that has not started are not computed yet
        self.next_time: float | None = None  # s, where the next communication step has to start
        self.stop_time = inf                 # s, beyond which no step may go, if the importer says so
        self.sampling = definition.sampling

    def slots(self) -> list[Slot]:
        return scalar_slots(self.block, self.definition.new_block())

    def checked(self) -> int:
        """Return the status of outputs after a start or a step; 0, for the blocks of this project check their own."""
        return 0

    def refused(self, message: str) -> Refused:
        """Error to raise for a request that is not carried out.

        pythonfmu's binary gives up its references to slave, class and log on every exception, and once more when the
        instance is freed, which crashes a process that does so. One more reference for each makes that safe; on Linux
        the binary is corrected.
        """
        if sys.platform == "win32":
            for held in (self, type(self), self.log_queue):
                one_more_reference(held)
        return Refused(message)

    def allow(self, call: str, *phases: str) -> None:
        if self.phase not in phases:
            raise self.refused(f"{call} {self.phase}, expected {' or '.join(phases)}")

    # Initialization

    def setup_experiment(self, start_time: float, stop_time: float | None = None, *_: Any) -> None:
        """Take in the start time and, where it is defined, the stop time (s)."""
        self.allow("fmi2SetupExperiment", INSTANTIATED)
        if not -inf < start_time < inf:
            raise self.refused(f"start time = {start_time} s, expected a finite time")
        self.next_time = start_time
        self.stop_time = inf if stop_time is None else stop_time

    def enter_initialization_mode(self) -> None:
        self.allow("fmi2EnterInitializationMode", INSTANTIATED)
        self.phase = INITIALIZING

    def exit_initialization_mode(self) -> None:
        """Start the block."""
        self.allow("fmi2ExitInitializationMode", INITIALIZING)
        try:
            status = self.block.start() or self.checked()
        except self.raised as error:
            raise self.failed(error) from error
        self.refuse(status)
        self.phase = RUNNING
        self.stale = False
        self.setters.clear()   # fixed parameters cannot be set from here on

    def terminate(self) -> None:
        """End the run: from here on nothing can be set, nor a step be done."""
        self.allow("fmi2Terminate", RUNNING)
        self.phase = TERMINATED
        self.setters.clear()

    # Steps

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Step the block from a time over a communication step (s)."""
        self.allow("fmi2DoStep", RUNNING)
        if not 0.0 < step_size < inf:
            raise self.refused(f"communication step = {step_size} s, expected a positive, finite step")
        end = current_time + step_size
        if not -inf < end < inf:
            raise self.refused(f"communication point = {current_time} s, expected a finite time")
        rounding = ROUNDING * abs(self.next_time or 0.0)
        tolerance = min(CONTINUITY * step_size, LARGEST_MISS) + rounding
        if self.next_time is not None and not abs(current_time - self.next_time) <= tolerance:
            raise self.refused(f"communication point = {current_time} s, expected {self.next_time} s, "
                          "where the step before ended")
        # FMI 2.0.4, fmi2SetupExperiment: an error. The clock of a master that adds up its steps may have drifted.
        if end > self.stop_time + CONTINUITY * step_size + rounding:
            raise self.refused(f"communication step to {end} s, expected at most the stop time, {self.stop_time} s")
        resolution = RESOLUTION * (abs(current_time) + step_size)
        step = step_size
        if self.sampling and resolution > FITTING * step_size:
            step = self.whole_step(step_size, resolution)
        try:
            status = self.block.step(current_time, step) or self.checked()
        except self.raised as error:
            raise self.failed(error, current_time) from error
        if status and (self.definition.variable_step or step_size > NO_STEP + resolution):
            self.refuse(status, current_time, step_size)
        self.next_time = end
        return True

    def whole_step(self, size: float, resolution: float) -> float:
        """Return `size` (s), rounded to whole samples or a share of one if the difference is below the resolution.

        From 1.7e9 s on, where clocks of computers are, a difference of two times misses 0.5 ms by up to 0.24 µs.
        """
        sample = float(read(self.block, self.sampling))
        ratio = sample / size
        if not 1.0 / LARGEST_RATIO < ratio < LARGEST_RATIO:
            return size
        steps, samples = (float(floor(ratio + 0.5)), 1.0) if ratio >= 1.0 else (1.0, float(floor(size / sample + 0.5)))
        whole = samples * sample / steps
        miss = abs(size - whole)
        # Where neighbouring shares of a sample cannot be distinguished, the block refuses a step that does not fit.
        return whole if FITTING * whole < miss <= resolution and 2.0 * steps * resolution < whole else size

    def failed(self, error: BaseException, time: float | None = None) -> Refused:
        """Refusal of the start, or of a step from a time (s), in which the block raised an error."""
        return self.refused(f"start: {error}" if time is None else f"step from {time} s: {error}")

    def refuse(self, status: int, time: float = 0.0, step: float = 0.0) -> None:
        """Raise the definition's text for a status other than 0, with the values that it names."""
        if status == 0:
            return

        def value_text(match: re.Match[str]) -> str:
            name = match.group(1)
            if name in ("time", "step"):
                return repr(time if name == "time" else step)
            value = next(v.read(self.block) for v in self.variables if v.name == name)
            return repr(float(value) if isinstance(value, Real) and not isinstance(value, bool) else value)

        raise self.refused(re.sub(r"\{([\w.]+)\}", value_text, self.definition.refusals[status]))

    def beyond(self, v: Variable, value: float) -> str:
        """Words for a value that is not a finite number within the range of its variable."""
        unit = f" {v.unit}" if v.unit else ""
        return f"{v.name} = {value}{unit}, expected a number from {v.low} to {v.high}{unit}{v.hinted}"

    # Variables

    def variable(self, vr: int, boolean: bool) -> Variable:
        if not 0 <= vr < len(self.variables):
            raise self.refused(f"value reference = {vr}, expected 0 to {len(self.variables) - 1}")
        variable = self.variables[vr]
        if variable.boolean != boolean:
            raise self.refused(f"{variable.name} is {'a Boolean' if variable.boolean else 'a Real'} variable, "
                          f"expected a call for that type")
        return variable

    def prepare_getter(self, vrs: tuple[int, ...], boolean: bool) -> Callable[[Any], tuple[Any, ...]]:
        """Accessor that reads variables of the block in one call."""
        getter = reader([self.variable(vr, boolean).place for vr in vrs])
        (self.boolean_getters if boolean else self.real_getters)[vrs] = getter
        return getter

    def refresh(self) -> None:
        """Refresh the initial outputs from the values set so far."""
        with suppress(*self.raised):   # if that fails, the end of the initialization says so
            self.block.start()
            self.stale = False

    def prepare_setter(self, vrs: tuple[int, ...], boolean: bool) -> list[tuple[Any, str | int, float, float]]:
        """Return where to write variables, and their ranges."""
        self.allow("fmi2SetBoolean" if boolean else "fmi2SetReal", INSTANTIATED, INITIALIZING, RUNNING)
        slots = []
        for vr in vrs:
            v = self.variable(vr, boolean)
            if v.causality == "output":
                raise self.refused(f"{v.name} is an output, expected an input or a parameter to set")
            if self.phase == RUNNING and v.variability == "fixed":
                raise self.refused(f"{v.name} is a fixed parameter, expected to be set before the initialization ends")
            slots.append((*v.slot(self.block), *v.settable))
        self.setters[vrs] = slots
        return slots

    def write(self, vrs: list[int], values: list[Any], boolean: bool) -> None:
        """Set variables; raise, and set none, if a value is not a finite number within its range."""
        key = tuple(vrs)
        slots = self.setters.get(key)
        if slots is None:
            slots = self.prepare_setter(key, boolean)
        for vr, (_, _, low, high), value in zip(vrs, slots, values, strict=True):
            if not low <= value <= high:
                raise self.refused(self.beyond(self.variables[vr], value))
        for (owner, name, _, _), value in zip(slots, values, strict=True):
            put(owner, name, value)
        if self.phase != RUNNING:
            self.stale = True

    def get_real(self, vrs: list[int]) -> list[float]:
        if self.stale:
            self.allow("fmi2GetReal", INITIALIZING, RUNNING, TERMINATED)
            self.refresh()
        key = tuple(vrs)
        getter = self.real_getters.get(key) or self.prepare_getter(key, False)
        return list(getter(self.block))

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        if self.stale:
            self.allow("fmi2GetBoolean", INITIALIZING, RUNNING, TERMINATED)
            self.refresh()
        key = tuple(vrs)
        getter = self.boolean_getters.get(key) or self.prepare_getter(key, True)
        return list(getter(self.block))

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        self.write(vrs, values, False)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        self.write(vrs, values, True)

    def no_such_type(self, vrs: list[int], *_: Any) -> Any:
        """Raise for access to Integer and String variables, which no FMU here has."""
        if not vrs:
            return []
        raise self.refused(f"value references {vrs}: expected Real or Boolean variables, there are no others")

    get_integer = get_string = set_integer = set_string = no_such_type

    # State

    def _get_fmu_state(self) -> dict[str, Any]:
        return {"model": type(self).__module__,
                "block": [look(owner, name) for owner, name in self.state_slots],
                "slave": [self.phase, self.stale, self.next_time, self.stop_time]}

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        if state.get("model") != type(self).__module__:
            raise self.refused(f"state of model: {state.get('model')}, expected {type(self).__module__}")
        if not self.is_state(state.get("block"), state.get("slave")):
            raise self.refused("serialized state: expected one that this FMU has written")
        for (owner, name), value in zip(self.state_slots, state["block"], strict=True):
            put(owner, name, value)
        self.phase, self.stale, self.next_time, self.stop_time = state["slave"]
        self.setters.clear()

    def is_state(self, block: Any, slave: Any) -> bool:
        """Return True if this is a state from `_get_fmu_state`: a serialized state may come from anywhere."""
        numbers = (bool, int, float)
        return (isinstance(block, list) and len(block) == len(self.state_slots)
                and all(isinstance(value, numbers) for value in block) and isinstance(slave, list) and len(slave) == 4
                and slave[0] in PHASES and isinstance(slave[1], bool)
                and isinstance(slave[2], (*numbers, type(None))) and isinstance(slave[3], numbers))

    @staticmethod
    def _fmu_state_to_bytes(state: dict[str, Any]) -> bytes:
        return json.dumps(state).encode("utf-8")

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict[str, Any]:
        try:
            loaded = json.loads(state.decode("utf-8"))
        except ValueError:
            loaded = None
        # An instance raises an error when an unreadable state is set; here there is no instance.
        return loaded if isinstance(loaded, dict) else {"model": f"serialized state of {len(state)} unreadable bytes"}
