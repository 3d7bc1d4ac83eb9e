"""FMUs with clocks in a co-simulation: their steps, with an event wherever a clock ticks (FMI 3.0, 2.2.10).

Periodic clocks tick in their own time. A triggered clock is a Boolean port. True at an input lets it tick at the start
of the next step; true at an output says that it has ticked in the last step.
"""

from collections.abc import Callable, Mapping
from ctypes import addressof, c_bool, c_double, c_int, c_size_t, c_uint32, c_void_p, memmove, sizeof
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import parse

from fmpy.fmi1 import FMICallException
from fmpy.model_description import ModelDescription, ScalarVariable

from maglev.cosim.model_exchange import AGAIN, FAILED, MOST_EVENTS, settled

PERIODIC, TRIGGERED = ("constant", "fixed", "tunable"), "triggered"   # interval variabilities that can be run
PUNCTUAL = 1e-6   # of an interval, or of a step, by which rounding may miss its end
CHANGED = 2       # fmi3IntervalChanged


def clocks_of(description: ModelDescription) -> list[ScalarVariable]:
    return [variable for variable in description.modelVariables
            if variable.type == "Clock" or variable.intervalVariability == TRIGGERED]


class Clock:
    """A periodic clock: when it ticks next, s; an interval that its FMU tells is not given."""

    def __init__(self, reference: int, attributes: Mapping[str, str]):
        self.reference = reference
        self.given = "intervalDecimal" in attributes
        self.interval = float(attributes.get("intervalDecimal", 0.0))
        self.shift = float(attributes.get("shiftDecimal", 0.0))
        self.tunable = attributes["intervalVariability"] == "tunable"
        self.begin(0.0)

    def begin(self, time: float) -> None:
        """Count from a time (s)."""
        self.origin, self.ticks = time, 0

    @property
    def due(self) -> float:
        """When it ticks next, s; of a multiple of the interval, so that rounding does not add up."""
        return self.origin + self.ticks * self.interval


class Values:
    """Access to variables of one type; values of a clock's variables are kept here until it ticks, or since it has."""

    def __init__(self, getter: Any, setter: Any, value: Any, variables: Mapping[int, ScalarVariable],
                 free: Callable[[], bool]):
        self.call_get, self.call_set = getter, setter
        self.value = value
        self.free = free   # true if the FMU gives access to all, as in its initialization
        self.clocks = {reference: {clock.valueReference for clock in variable.clocks or ()}
                       for reference, variable in variables.items()}
        self.names = {reference: variable.name for reference, variable in variables.items()}
        self.outputs = [r for r, v in variables.items() if v.causality == "output" and self.clocks[r]]
        self.triggered = {r for r, v in variables.items() if v.intervalVariability == TRIGGERED}
        self.ticking: set[int] = set()   # triggered inputs that tick at the next event
        self.ticked: set[int] = set()    # triggered outputs that have ticked in the last step
        self.waiting: dict[int, Any] = {}
        self.held: dict[int, Any] = {}

    def put(self, handle: c_void_p, references: Any, count: c_size_t, values: c_void_p) -> int:
        """Called as fmi2SetReal: the values wait for an event."""
        if self.free() and self.triggered.isdisjoint(references):
            return int(self.call_set(handle, references, count, values))
        given = dict(zip(references, (self.value * count.value).from_address(values.value or 0), strict=True))
        self.ticking |= {r for r in self.triggered & given.keys() if given[r]}
        others = {r: value for r, value in given.items() if r not in self.triggered}
        if self.free():
            self.pass_on(self.call_set, handle, [*others], (self.value * len(others))(*others.values()))
        else:
            self.waiting |= others
        return 0

    def get(self, handle: c_void_p, references: Any, count: c_size_t, values: c_void_p) -> int:
        """Called as fmi2GetReal."""
        if self.free() and self.triggered.isdisjoint(references):
            return int(self.call_get(handle, references, count, values))
        open_now = [r for r in references if r not in self.triggered and (self.free() or not self.clocks[r])]
        ticking = dict(zip(open_now, self.read(handle, open_now), strict=True)) | self.held
        ticking |= {r: r in self.ticked for r in self.triggered}
        given = (self.value * count.value)(*(ticking.get(r, self.value().value) for r in references))
        memmove(values, given, sizeof(given))
        return 0

    def read(self, handle: c_void_p, references: list[int]) -> list[Any]:
        """Values that the FMU gives now."""
        values = (self.value * len(references))()
        self.pass_on(self.call_get, handle, references, values)
        if self.value is c_bool:   # which takes every number but 0 for true
            for reference, value in zip(references, bytes(values), strict=True):
                if value > 1:
                    raise RuntimeError(f"{self.names[reference]} = {value}, expected a Boolean, 0 or 1")
        return list(values)

    def pass_on(self, function: Any, handle: c_void_p, references: list[int], values: Any) -> None:
        if references:
            status = function(handle, (c_uint32 * len(references))(*references), c_size_t(len(references)),
                              c_void_p(addressof(values)))
            if status > 1:
                raise FMICallException(function="fmi3Get or fmi3Set", status=status)

    def hold(self, handle: c_void_p, ticking: set[int] | None = None) -> None:
        """Keep the outputs of the clocks that tick, or of all."""
        wanted = [r for r in self.outputs if ticking is None or self.clocks[r] & ticking]
        self.held.update(zip(wanted, self.read(handle, wanted), strict=True))

    def give(self, handle: c_void_p, ticking: set[int]) -> None:
        """Set what has waited for one of these clocks, or for any event."""
        ready = [r for r in self.waiting if not self.clocks[r] or self.clocks[r] & ticking]
        self.pass_on(self.call_set, handle, ready, (self.value * len(ready))(*(self.waiting.pop(r) for r in ready)))


class Ticking:
    """Steps of an instance with clocks, called as fmi2DoStep; functions that get and set values by type.

    An event happens at the start of a step, and wherever a clock ticks within it. It passes on the inputs that were
    set, and reads the outputs of the clocks that tick. A tick at the end of a step is one of the next step.
    """

    def __init__(self, instance: Any, folder: Path, description: ModelDescription, types: Mapping[str, Any],
                 getters: Mapping[str, Any], setters: Mapping[str, Any], do_step: Any, say: Callable[[str], None]):
        self.instance, self.step, self.say = instance, do_step, say
        self.handle = c_void_p(instance.component)
        self.clocks = [Clock(int(element.attrib["valueReference"]), element.attrib)
                       for element in parse(folder / "modelDescription.xml").iter("Clock")
                       if element.attrib["intervalVariability"] != TRIGGERED]
        self.told = [clock.valueReference for clock in clocks_of(description) if clock.causality == "output"]
        self.stepping = False
        self.following = float("inf")   # s, time of an event that the FMU has announced
        variables = {v.valueReference: v for v in description.modelVariables}
        self.values = {kind: Values(getters[kind], setters[kind], types[kind].value, variables,
                                     lambda: not self.stepping)
                       for kind in types}
        for kind, values in self.values.items():
            of_kind = {v.valueReference for v in variables.values()
                       if v.type == kind or (v.type, kind) == ("Enumeration", "Int64")}
            values.outputs = [r for r in values.outputs if r in of_kind]
        self.getters = {kind: values.get for kind, values in self.values.items()}
        self.setters = {kind: values.put for kind, values in self.values.items()}

    def reset(self) -> None:
        self.stepping = False
        for values in self.values.values():
            for kept in (values.waiting, values.ticking, values.ticked):
                kept.clear()

    def look(self) -> None:
        """In the initialization: ask for intervals, and for outputs before the first tick."""
        for clock in self.clocks:
            if not clock.given:
                clock.interval, _ = self.interval(clock)
                shift = (c_double * 1)()
                self.instance.getShiftDecimal((c_uint32 * 1)(clock.reference), shift)
                clock.shift = shift[0]
            if not clock.interval > 0.0:
                raise RuntimeError(f"interval of a clock = {clock.interval} s, expected one above 0 s")
        for values in self.values.values():
            values.hold(self.handle)

    def interval(self, clock: Clock) -> tuple[float, int]:
        """Interval of a clock, s, and its qualifier."""
        interval, qualifier = (c_double * 1)(), (c_int * 1)()
        self.instance.getIntervalDecimal((c_uint32 * 1)(clock.reference), interval, qualifier)
        return interval[0], qualifier[0]

    def begin(self, time: float) -> None:
        """Change to stepping after the initialization, in event mode at the start time (s), before the first tick."""
        for clock in self.clocks:
            clock.begin(time + clock.shift)
        self.settle(time)
        self.stepping = True

    def __call__(self, _handle: object, time: c_double, step: c_double, _no_set_before: object) -> int:
        now, end, slack = time.value, time.value + step.value, PUNCTUAL * step.value
        instants = 0
        for values in self.values.values():
            values.ticked.clear()
        try:
            while True:
                self.event(now)
                following = min([self.following, *(clock.due for clock in self.clocks)])
                if following <= now:
                    instants += 1
                    if instants > MOST_EVENTS:
                        raise RuntimeError(AGAIN)
                    continue
                part = end if following > end - slack else following
                status = int(self.step(self.handle, c_double(now), c_double(part - now), c_int(1)))
                if status > 1 or part == end:
                    return status
                now = part
        except FMICallException as error:
            return int(error.status)
        except RuntimeError as error:
            self.say(str(error))
            return FAILED

    def event(self, now: float) -> None:
        """Make the event at a time (s), if there is one."""
        ticking = [clock for clock in self.clocks if abs(clock.due - now) <= PUNCTUAL * clock.interval]
        active = {clock.reference for clock in ticking}.union(*(values.ticking for values in self.values.values()))
        asked = bool(getattr(self.step, "event", False)) or now >= self.following
        if not (active or asked or any(not values.clocks[r] for values in self.values.values()
                                        for r in values.waiting)):   # for any event
            return
        self.instance.enterEventMode()
        if active:
            self.instance.setClock(sorted(active), [True] * len(active))
        for values in self.values.values():
            values.give(self.handle, active)
            values.ticking.clear()
        if active:
            for values in self.values.values():
                values.hold(self.handle, active)
        for clock in ticking:
            clock.ticks += 1
        self.settle(now)
        for clock in self.clocks:
            if clock.tunable and not clock.given:
                interval, qualifier = self.interval(clock)
                if qualifier == CHANGED:
                    clock.interval = interval
                    clock.begin(now + interval)

    def settle(self, now: float) -> None:
        """End the event at a time (s)."""
        self.following = settled(self.update, now)
        self.instance.enterStepMode()

    def update(self) -> tuple[Any, ...]:
        """Make an update of the discrete states, and before it keep what the FMU's own clocks give that tick now."""
        if self.told:
            active = {r for r, ticks in zip(self.told, self.instance.getClock(self.told), strict=True) if ticks}
            for values in self.values.values():
                values.ticked |= active
                values.hold(self.handle, active)
        made: tuple[Any, ...] = self.instance.updateDiscreteStates()
        return made
