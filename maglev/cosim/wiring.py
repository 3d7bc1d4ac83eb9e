"""Calls of a communication step, prepared so that stepping only moves pointers and calls.

Every output is read straight into the row of its recording, and every input is set straight from the row of the output
or signal that feeds it. So a step copies nothing and looks nothing up. Only an FMU with units of its own has buffers of
its own, and calls that convert between these and the rows.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from ctypes import c_double, c_int, c_int64, c_size_t, c_uint32, c_void_p
from itertools import chain, product
from math import lcm
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from fmpy.model_description import ScalarVariable

from maglev.cosim import Order
from maglev.cosim.elements import of_variable
from maglev.cosim.fmi_versions import FMI2, FMI3
from maglev.cosim.fmu import Fmu, kind_of
from maglev.cosim.port_map import Scale
from maglev.files.errors import FmuError, few, shortened

REALS = ("Real", "Float32")   # types that can be connected with each other, and driven
KINDS = (*FMI2.types, *(kind for kind in FMI3.types if kind not in FMI2.types))

Drives = Mapping[str, Sequence[float] | npt.NDArray[np.float64]]   # values of inputs at every communication point

Allocate = Callable[[tuple[int, int], type], npt.NDArray[Any]]   # from shape and type to an array of zeros


class Track:
    """Values of variables of one FMI type, where the FMUs read and write: a row for each communication point.

    The rows are those of a block of some hundred points, and used again by the next one: they stay in the processor's
    cache. Signals have all their values, shape (names, points), in `signals`.
    """

    def __init__(self, names: list[str], item: type, rows: int, allocate: Allocate = np.zeros,
                 drives: Drives | None = None, boolean: bool = False):
        self.names = names
        self.boolean = boolean
        self.signals: npt.NDArray[Any] | None = None
        if drives is not None:
            self.signals = np.array([drives[name] for name in names], item)
        self.array = allocate((rows, len(names)), item)
        self.address = self.array.ctypes.data
        self.item = self.array.itemsize
        self.stride = self.item * len(names)   # bytes from one row to the next

    def first_wrong(self, first: int, last: int) -> tuple[int, str] | None:
        """First of the rows from `first` to `last` that has another value of a Boolean output than 0 and 1, and it."""
        if not self.boolean:
            return None
        rows = self.array[first:last + 1]
        if not np.bitwise_or.reduce(rows, axis=None, initial=0) >> 1:   # also of -1
            return None
        row, column = np.argwhere(rows >> 1)[0]
        return first + int(row), f"{self.names[column]} = {self.array[first + row, column]}, expected a Boolean, 0 or 1"

    def begin(self, origin: int) -> None:
        """Begin a block with the communication point `origin`, the last one of the block before."""
        if self.signals is not None:
            block = self.signals[:, origin:origin + len(self.array)].T
            self.array[:len(block)] = block
        elif origin > 0:
            self.array[0] = self.array[-1]


class Call(NamedTuple):
    """A call of an FMU's function at every communication point k: its moving argument is base + k stride.

    The argument is the address of a row, the time of the point (s), or, of a conversion, the number of a row. Rows are
    counted from point 0 on, see `with_rows_from`.
    """

    moving: Any        # c_void_p, c_double or c_int64, one of the arguments
    base: float
    stride: float
    function: Any
    arguments: tuple[Any, ...]
    what: tuple[Fmu, str]   # for messages

    def at(self, k: int) -> None:
        """Call at a communication point; FmuError if the FMU refuses."""
        self.moving.value = self.base + k * self.stride
        fmu, call = self.what
        fmu.require(call, self.function(*self.arguments))

    def with_rows_from(self, origin: int) -> "Call":
        """The call in a block whose rows begin with another communication point."""
        return self if isinstance(self.moving, c_double) else self._replace(base=self.base - origin * self.stride)

    def failed(self, status: int) -> FmuError:
        """Error for a status beyond a warning."""
        fmu, call = self.what
        return fmu.failed(call, status)


class Wiring(NamedTuple):
    """A prepared co-simulation: the calls before the first step, those of each step, and their recording.

    Communication step k makes the calls of phase k modulo the number of phases: one, unless an FMU has longer steps.
    `begin` has, by FMU in the order of their initialization, the calls by which it gets there what others begin with;
    `final` are the calls after the last step.
    """

    initial: list[Call]
    phases: list[list[Call]]
    tracks: list[Track]
    begin: dict[str, list[Call]]
    final: list[Call]


class Rate(NamedTuple):
    """Steps of an FMU: one in `every` communication steps, or `parts` in one."""

    every: int = 1
    parts: int = 1


class Place(NamedTuple):
    """Place of a value: its track, its column there, and the position of its FMU in the order; -1 for a signal."""

    track: Track
    column: int
    order: int


def wire(fmus: Mapping[str, Fmu], connections: Sequence[tuple[str, str]],
         drives: Drives, rows: int, step: float, order: Order = "sequential",
         rates: Mapping[str, Rate] | None = None, allocate: Allocate = np.zeros) -> Wiring:
    """Prepare a co-simulation of the FMUs in their order.

    Connections go from an output to an input or a tunable parameter, both `fmu.variable`. Blocks have `rows` rows, and
    the communication step is in s. `allocate` makes the arrays for the recording. In sequential order an FMU gets this
    step's outputs of the FMUs before it (Gauss-Seidel), in "jacobi" all get those of the step before.

    `rates` are the steps of FMUs, by name, whose steps are not the communication steps. If a step spans several
    communication steps, the first FMU steps in the first of them, the others in the last. So the first computes from
    its inputs at the start the outputs that it holds, and the others give their results at the end.

    FmuError if a name does not exist, is not an output, or an input or parameter, as it should be, or has two sources.
    """
    sources = input_sources(fmus, connections, drives)
    places: dict[str, Place] = {}   # of each output and signal
    sets: list[list[Call]] = []
    gets: list[list[Call]] = []
    for number, (name, fmu) in enumerate(fmus.items()):
        gets.append([])
        for track, variables in output_tracks(name, fmu, sources, rows, allocate):
            places.update({full: Place(track, column, number) for column, full in enumerate(track.names)})
            gets[-1] += value_calls(fmu, "Get", variables, track, 0, 1)
    for (name, fmu), kinds in product(fmus.items(), (REALS, ("Boolean",))):
        driven = [target for target in drives if target.partition(".")[0] == name
                  and kind_of(fmu.variable(target.partition(".")[2])) in kinds]
        if driven:
            track = Track(driven, fmu.fmi.types[kinds[0]].recorded, rows, allocate, drives)
            places.update({target: Place(track, column, -1) for column, target in enumerate(driven)})
    for number, (name, fmu) in enumerate(fmus.items()):
        sets.append(list(input_calls(number, name, fmu, sources, places, order)))
    every = {name: rates[name].every if rates and name in rates else 1 for name in fmus}
    phases = []
    for phase in range(lcm(*every.values())):
        stepping = [(phase if number == 0 else phase + 1) % length == 0 for number, length in enumerate(every.values())]
        setting = [calls if now else [] for calls, now in zip(sets, stepping, strict=True)]
        steps = [list(step_calls(fmu, step, number, (rates or {}).get(name, Rate()))) if stepping[number] else []
                 for number, (name, fmu) in enumerate(fmus.items())]
        one_by_one = chain(*zip(setting, steps, gets, strict=True))
        phases.append(list(chain(*((*setting, *steps, *gets) if order == "jacobi" else one_by_one))))
    # A step reads the outputs at its end, the initial calls those of the first point: one row before.
    initial = [call._replace(base=call.base - call.stride) for each in gets for call in each]
    begin = {}
    for name, feeding in beginning(fmus, sources).items():
        known = {target: source for target, source in sources.items()
                 if owner(source) in feeding and (owner(source) != name or source == target)}
        begin[name] = [*(call for call in initial if call.what[0].name in feeding - {name}),
                       *input_calls(0, name, fmus[name], known, places, "jacobi")]
    final = [Call(c_double(), 0.0, 0.0, fmu.terminate, (fmu.handle(),), (fmu, f"{fmu.fmi.prefix}Terminate"))
             for fmu in fmus.values()]
    return Wiring(initial, phases, list({id(place.track): place.track for place in places.values()}.values()), begin,
                  final)


def beginning(fmus: Mapping[str, Fmu], sources: Mapping[str, str]) -> dict[str, set[str]]:
    """FMUs in the order of their initialization, each with the FMUs whose initial outputs it is given then.

    A measurement begins with the initial outputs of its plant. Which initial outputs depend on inputs is in the model
    structure of an FMU (InitialUnknowns, FMI 2.0.4, section 2.2.8).

    FMUs, in the order of stepping. An FMU whose initial outputs depend on no input is given none, and waits for no
    others; the others wait for their signals. Of a circle the FMU that steps first comes last: it samples what the
    others begin with. `sources` are those of the fed inputs; a signal is named as its input.
    """
    waiting = list(fmus)
    feeding = {name: {owner(source) for target, source in sources.items() if owner(target) == name} - {name}
               if begins_with_inputs(fmu) else set() for name, fmu in fmus.items()}
    found: dict[str, set[str]] = {}
    while waiting:
        free = next((name for name in waiting if not feeding[name] & {*waiting}), waiting[len(waiting) > 1])
        waiting.remove(free)
        found[free] = feeding[free] & {*found} | ({free} if begins_with_inputs(fmus[free]) else set())
    return found


def owner(full: str) -> str:
    """FMU of a variable `fmu.variable`."""
    return full.partition(".")[0]


def begins_with_inputs(fmu: Fmu) -> bool:
    """Return True if an initial output of an FMU depends on an input; without a list of dependencies, on any."""
    inputs = {of_variable(variable) for variable in fmu.description.modelVariables if variable.causality == "input"}
    return any(inputs if unknown.dependencies is None else
               inputs & {known.valueReference for known in unknown.dependencies}
               for unknown in fmu.description.initialUnknowns if unknown.variable.causality == "output")


def input_sources(fmus: Mapping[str, Fmu], connections: Sequence[tuple[str, str]],
                  drives: Drives) -> dict[str, str]:
    """Source of each fed input, `fmu.variable`; a signal is named as the input that it drives."""
    sources: dict[str, str] = {}
    for pair in connections:
        if isinstance(pair, str) or len(pair) != 2:
            raise FmuError(f"connection {shortened(pair)}, expected a pair: an output and the input that it goes to")
    for source, target in [*connections, *((target, target) for target in drives)]:
        if target in sources:
            raise FmuError(f"{target} has two sources, expected one connection or signal")
        sources[target] = source
        kind = kind_of(endpoint(fmus, target, "input", "parameter"))
        given = kind if source == target else kind_of(endpoint(fmus, source, "output"))
        if given != kind and not {given, kind} <= {*REALS}:
            raise FmuError(f"{source} and {target} differ in type, expected {kind} at both ends")
        if source == target and kind not in (*REALS, "Boolean"):
            raise FmuError(f"{target} is of type {kind}, expected a Real or Boolean input for a signal")
    return sources


def output_tracks(name: str, fmu: Fmu, sources: Mapping[str, str], rows: int,
                  allocate: Allocate) -> Iterator[tuple[Track, list[ScalarVariable]]]:
    """Tracks of an FMU's outputs, one for each FMI type that occurs."""
    wanted = list(sources.values())
    for kind in fmu.fmi.types:
        variables = [v for v in fmu.description.modelVariables
                     if v.causality == "output" and kind_of(v) == kind]
        # Connected outputs first, in the order of the connections: those that go to one FMU lie side by side.
        variables.sort(key=lambda v: wanted.index(f"{name}.{v.name}") if f"{name}.{v.name}" in wanted else len(wanted))
        if variables:
            yield Track([f"{name}.{v.name}" for v in variables], fmu.fmi.types[kind].recorded, rows, allocate,
                        boolean=kind == "Boolean"), variables


def input_calls(number: int, name: str, fmu: Fmu, sources: Mapping[str, str],
                places: Mapping[str, Place], order: Order) -> Iterator[Call]:
    """Calls that set an FMU's inputs, one for each run of values that lie side by side."""
    fed = [(fmu.variables[target.partition(".")[2]], places[source]) for target, source in sources.items()
           if target.partition(".")[0] == name]
    tracks = list({id(place.track): None for place in places.values()})   # in an order that is no matter of memory
    fed.sort(key=lambda item: (tracks.index(id(item[1].track)), item[1].column))
    runs: list[list[tuple[ScalarVariable, Place]]] = []
    for variable, place in fed:
        before = runs[-1][-1][1] if runs else None
        if before is None or place.track is not before.track or place.column != before.column + 1 \
                or kind_of(runs[-1][-1][0]) != kind_of(variable):
            runs.append([])
        runs[-1].append((variable, place))
    for run in runs:
        _, (track, column, source) = run[0]
        # Outputs of this step from FMUs before this one are in the next row already.
        ahead = 1 if order == "sequential" and 0 <= source < number else 0
        yield from value_calls(fmu, "Set", [variable for variable, _ in run], track, column, ahead)


def value_calls(fmu: Fmu, verb: str, variables: Sequence[ScalarVariable], track: Track, column: int,
                ahead: int) -> Iterator[Call]:
    """The call of `value_call`; with a conversion after or before it if the FMU does not count in SI units.

    Or if its values are of another size, as Booleans and many numbers of FMI 3.0 are.
    """
    call = value_call(fmu, verb, variables, track, column, ahead)
    own: npt.NDArray[Any] = np.zeros(len(variables), fmu.fmi.types[kind_of(variables[0])].item)   # in the FMU's units
    if not any(v.name in fmu.scales for v in variables) and own.dtype == track.array.dtype:
        yield call
        return
    rows = track.array[:, column:column + len(variables)]
    scales = [fmu.scales.get(v.name, Scale(1.0, 1.0)) for v in variables]
    up, down, offset = np.array(scales).T
    row = c_int64()

    def to_si(at: c_int64) -> int:
        rows[at.value] = own * down / up + offset
        return 0

    def to_own(at: c_int64) -> int:
        own[:] = (rows[at.value] - offset) * up / down
        return 0

    call = call._replace(base=own.ctypes.data, stride=0)
    conversion = Call(row, ahead, 1, to_si if verb == "Get" else to_own, (row,), (fmu, "a conversion of units"))
    yield from (call, conversion) if verb == "Get" else (conversion, call)


def value_call(fmu: Fmu, verb: str, variables: Sequence[ScalarVariable], track: Track, column: int,
               ahead: int) -> Call:
    """Call that gets or sets variables in the columns of a track from `column` on, `ahead` rows after point k."""
    kind = kind_of(variables[0])
    references = (c_uint32 * len(variables))(*(v.valueReference for v in variables))
    values = c_void_p()
    functions = fmu.get_functions if verb == "Get" else fmu.set_functions
    arguments = (fmu.handle(), references, c_size_t(len(variables)), values)
    what = f"{fmu.fmi.name(verb, kind)} of {few([v.name for v in variables])}"
    return Call(values, track.address + column * track.item + ahead * track.stride, track.stride, functions[kind],
                arguments, (fmu, what))


def step_calls(fmu: Fmu, step: float, number: int, rate: Rate) -> Iterator[Call]:
    """Calls that step an FMU, which is at a place in the order, in one communication step (s) from point k."""
    # A long step of an FMU after the first is made at its end.
    behind = rate.every - 1 if number > 0 else 0
    own = step * rate.every / rate.parts
    for part in range(rate.parts):
        time = c_double()
        yield Call(time, part * own - behind * step, step, fmu.do_step,
                   (fmu.handle(), time, c_double(own), c_int(1)), (fmu, f"{fmu.fmi.prefix}DoStep"))


def endpoint(fmus: Mapping[str, Fmu], name: str, *causalities: str) -> ScalarVariable:
    """Variable of a name `fmu.variable`; FmuError if it does not exist or is of another causality."""
    owner, _, variable = name.partition(".")
    if owner not in fmus:
        raise FmuError(f"{name}: there is no FMU {owner}, expected one of {', '.join(fmus)}")
    found = fmus[owner].variable(variable)
    if found.causality not in causalities:
        raise FmuError(f"{name} is of causality {found.causality}, expected an {' or '.join(causalities)}")
    if found.type not in (*KINDS, "Enumeration"):
        raise FmuError(f"{name} ({fmus[owner].source.name}) is of type {found.type}, expected one of "
                       f"{', '.join(KINDS)}")
    return found
