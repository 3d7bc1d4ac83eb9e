"""Buffers of a co-simulation, laid out so that a step copies few blocks and looks nothing up."""

from collections.abc import Iterable, Mapping, Sequence
from ctypes import c_double, c_int
from typing import Any, TypeAlias

import numpy as np
from fmpy.model_description import ScalarVariable

from scenarios.component import WARNING, Buffer, Component, ComponentError

KINDS = ("Real", "Integer", "Boolean")

Values: TypeAlias = "memoryview[Any]"   # of doubles, or of ints


class Track:
    """Values of variables at every communication point, row by row."""

    def __init__(self, names: list[str], kind: str, rows: int):
        self.names = names
        self.array = np.zeros((rows, len(names)), dtype=np.float64 if kind == "Real" else np.int32)
        self.view: Values = self.array.reshape(-1).data


class Link:
    """One FMU in the loop, with its buffers and the copies that fill its inputs."""

    def __init__(self, component: Component):
        self.component = component
        self.inputs: list[Buffer] = []
        self.outputs: list[Buffer] = []
        self.records: list[Track] = []                               # of the outputs, in their order
        self.connected: list[tuple[Values, Values]] = []     # input block, output block
        self.driven: list[tuple[Values, Values, int]] = []   # input block, rows of values, length of a row

    def prepare(self, step: float) -> None:
        """Gather the arguments of every call of a communication step (s), so that stepping only calls and copies."""
        component = self.component
        handle = component.handle()
        self.setters = [(component.set_functions[b.kind], (handle, *b.arguments()), b) for b in self.inputs]
        self.getters = [(component.get_functions[b.kind], (handle, *b.arguments()), b, track.view, b.view, len(b.names))
                        for b, track in zip(self.outputs, self.records, strict=True)]
        self.do_step = component.do_step
        self.time = c_double()
        self.step_arguments = (handle, self.time, c_double(step), c_int(1))

    def step(self, k: int, time: float) -> None:
        """Set the inputs of communication point k, step from its time (s), and record the outputs of point k + 1."""
        for target, rows, length in self.driven:
            target[:] = rows[k * length:(k + 1) * length]
        for target, source in self.connected:
            target[:] = source
        for function, arguments, buffer in self.setters:
            status = function(*arguments)
            if status > WARNING:
                raise self.component.failed(f"fmi2Set{buffer.kind} of {', '.join(buffer.names)}", status)
        self.time.value = time
        status = self.do_step(*self.step_arguments)
        if status > WARNING:
            raise self.component.failed("fmi2DoStep", status)
        self.read(k + 1)

    def read(self, k: int) -> None:
        """Get the outputs and record them as those of communication point k."""
        for function, arguments, buffer, rows, view, width in self.getters:
            status = function(*arguments)
            if status > WARNING:
                raise self.component.failed(f"fmi2Get{buffer.kind} of {', '.join(buffer.names)}", status)
            rows[k * width:(k + 1) * width] = view


def wire(components: Mapping[str, Component], connections: Sequence[tuple[str, str]],
         drives: Mapping[str, Sequence[float]], rows: int, step: float) -> tuple[list[Link], list[Track]]:
    """Links of the components in their order, ready for a communication step (s), and the tracks of all recorded.

    Raises
    ------
    ComponentError
        If a name does not exist, is not an output or input as it should be, or if an input has two sources.
    """
    sources: dict[str, str] = {}
    for source, target in [*connections, *((None, target) for target in drives)]:
        if target in sources:
            raise ComponentError(f"{target} has two sources, expected one connection or signal")
        sources[target] = source or ""
        kind = kind_of(endpoint(components, target, "input"))
        if source is not None and kind_of(endpoint(components, source, "output")) != kind:
            raise ComponentError(f"{source} and {target} differ in type, expected {kind} at both ends")
        if source is None and kind != "Real":
            raise ComponentError(f"{target} is of type {kind}, expected a Real input for a signal")
    links = {name: Link(component) for name, component in components.items()}
    tracks: list[Track] = []
    places: dict[str, tuple[Buffer, int]] = {}   # of each output
    for name, link in links.items():
        outputs = [v for v in link.component.description.modelVariables if v.causality == "output"]
        connected = {source.partition(".")[2] for source in sources.values() if source.partition(".")[0] == name}
        for kind in KINDS:
            of_kind = [v for v in outputs if kind_of(v) == kind]
            # Connected outputs first, so that those which go to one FMU lie side by side.
            chosen = [v for v in of_kind if v.name in connected] + [v for v in of_kind if v.name not in connected]
            if chosen:
                buffer = Buffer(kind, chosen)
                track = Track([f"{name}.{v.name}" for v in chosen], kind, rows)
                link.outputs.append(buffer)
                link.records.append(track)
                tracks.append(track)
                places.update({full: (buffer, i) for i, full in enumerate(track.names)})
    for name, link in links.items():
        tracks.extend(wire_inputs(name, link, sources, places, drives, rows))
        link.prepare(step)
    return list(links.values()), tracks


def wire_inputs(name: str, link: Link, sources: Mapping[str, str], places: Mapping[str, tuple[Buffer, int]],
                drives: Mapping[str, Sequence[float]], rows: int) -> list[Track]:
    """Give a link its input buffers and the copies that fill them; returns the track of its driven inputs."""
    mine = [(target, source) for target, source in sources.items() if target.partition(".")[0] == name]
    driven = [target for target, source in mine if not source]
    # In the order of the outputs that they come from, so that adjacent outputs make adjacent inputs.
    order = {full: i for i, full in enumerate(places)}
    connected = sorted((item for item in mine if item[1]), key=lambda item: order[item[1]])
    tracks = []
    variables = link.component.variables
    for kind in KINDS:
        from_signals = driven if kind == "Real" else []
        from_outputs = [item for item in connected if kind_of(variables[item[0].partition(".")[2]]) == kind]
        if not from_signals and not from_outputs:
            continue
        targets = [*from_signals, *(target for target, _ in from_outputs)]
        buffer = Buffer(kind, [variables[target.partition(".")[2]] for target in targets])
        link.inputs.append(buffer)
        if from_signals:
            track = Track(from_signals, kind, rows)
            for i, target in enumerate(from_signals):
                track.array[:, i] = drives[target]
            link.driven.append((buffer.view[:len(from_signals)], track.view, len(from_signals)))
            tracks.append(track)
        first = len(from_signals)
        for source_buffer, start, length in runs([places[source] for _, source in from_outputs]):
            link.connected.append((buffer.view[first:first + length], source_buffer.view[start:start + length]))
            first += length
    return tracks


def runs(places: Iterable[tuple[Buffer, int]]) -> list[tuple[Buffer, int, int]]:
    """Runs of adjacent places: buffer, first index, length."""
    found: list[tuple[Buffer, int, int]] = []
    for buffer, index in places:
        if found and found[-1][0] is buffer and found[-1][1] + found[-1][2] == index:
            found[-1] = (buffer, found[-1][1], found[-1][2] + 1)
        else:
            found.append((buffer, index, 1))
    return found


def kind_of(variable: ScalarVariable) -> str:
    """FMI type by which a variable is accessed."""
    return "Integer" if variable.type == "Enumeration" else str(variable.type)


def endpoint(components: Mapping[str, Component], name: str, causality: str) -> ScalarVariable:
    """Variable of a name `fmu.variable`; ComponentError if it does not exist or is not of that causality."""
    fmu, _, variable = name.partition(".")
    if fmu not in components:
        raise ComponentError(f"{name}: there is no FMU {fmu}, expected one of {', '.join(components)}")
    found = components[fmu].variable(variable)
    if found.causality != causality:
        raise ComponentError(f"{name} is of causality {found.causality}, expected an {causality}")
    if found.type not in (*KINDS, "Enumeration"):
        raise ComponentError(f"{name} is of type {found.type}, expected one of {', '.join(KINDS)}")
    return found
