"""Whole runs of native FMUs as one C function with the FMUs' blocks, one run in each lane of a vector register.

The blocks are translated once more, for lanes: values that differ between runs become vectors. These are differing
start values, values that `start` and `step` compute from them, and values that connections pass on. The function begins
with the initialised instances and with their first row, and has the operations of the calls: the bits are the same. It
writes a row of chosen columns at each communication point, and reports a run that an FMU would refuse; then the calls
are made, and give the error.

Groups of lanes lie one after the other. Environments run in them by a few points at a time, and begin again one by one.

The library is compiled here, for the widest vectors of this processor. Its key has their name, so that a shared cache
never gives a library that this processor cannot run.
"""

import platform
import re
from collections.abc import Iterator, Mapping, Sequence
from ctypes import CDLL, POINTER, Structure, addressof, c_double, c_int64, c_void_p, create_string_buffer
from itertools import chain, count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from maglev.cosim.fmu import Fmu
from maglev.cosim.native_blocks import HERE, PARTS_INLINED, Part, filled_in, indented, native_parts
from maglev.cosim.step_loop import in_c
from maglev.cosim.wiring import Call, Track, Wiring
from maglev.descriptions.own_fmus import definition, installed, own_build
from maglev.files.arrays import Array
from maglev.files.cache import BLOCK_LOOPS, Kept, keep_here, kept, key_of
from maglev.files.installed import code
from maglev.fmi.block_code import c_path
from maglev.fmi.compiler import FLAGS, library
from maglev.fmi.definition import FmuDefinition, Variable
from maglev.fmi.native_build import host_platform, layer_names
from maglev.language.blocks import METHODS
from maglev.language.c_text import c_literal
from maglev.language.constants import Place, assigned, place_of
from maglev.language.lanes import LanesText, helper_text
from maglev.language.program import Function, functions_of
from maglev.language.statements import Program
from maglev.user.blocks import Variables, built_definition
from maglev.user.source import FmuFile

SOURCE = HERE / "lane_loop.c"
LOOP_FILE = "loop.c"
DONE, REFUSED, OTHERWISE = range(3)   # results of functions: RUN_DONE and so on of lane_loop.c
ALIGNED = 64   # bytes, of the longest vectors


class Vectors(NamedTuple):
    """Vectors of a processor: numbers in a register, and zig's name of the processors that have them."""

    width: int
    processor: str
    needed: frozenset[str]   # flags of the processor, as Linux names them


# Wider ones first. Every processor of x86-64 and of 64-bit ARM has two numbers in a register.
LEVEL_3 = frozenset({"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe"})
WIDER = (Vectors(8, "x86_64_v4", LEVEL_3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}),
         Vectors(4, "x86_64_v3", LEVEL_3))
NARROW = Vectors(2, "baseline", frozenset())
MOST_LANES = WIDER[0].width


def widest(flags: frozenset[str] | None = None) -> Vectors:
    """Return the widest vectors of a processor with these flags; of this processor without flags."""
    found = processor_flags() if flags is None else flags
    return next((each for each in WIDER if each.needed <= found), NARROW)


def processor_flags() -> frozenset[str]:
    """Flags of this processor, if it is one of x86-64 and Linux lists them."""
    if platform.machine() not in ("x86_64", "AMD64"):
        return frozenset()
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace")
    except OSError:
        return frozenset()
    found = re.search(r"^flags\s*:(.*)$", text, re.MULTILINE)
    return frozenset(found[1].split()) if found else frozenset()


class Varied(NamedTuple):
    """Differences between runs: start values by full name, and True if their signals, or their beginnings, differ."""

    names: frozenset[str]
    signals: bool
    beginnings: bool = False


class Moved(Structure):
    """Arguments of a call that move from step to step, as the C function takes them."""

    _fields_ = (("time", c_double), ("time_stride", c_double), ("size", c_double))


class Transfer(NamedTuple):
    """A value that a call gets from a part or sets in it, and its column of a track."""

    getting: bool
    part: Part
    variable: Any
    track: int
    column: int


class LanePart:
    """An FMU in the loop: its block as a typed program, and the values that differ between lanes.

    These are all that a method assigns if runs begin at different times.
    """

    def __init__(self, part: Part, own: FmuDefinition, beginnings: bool):
        self.own, self.part, self.block = own, part, part.block
        program = Program(own.new_block(), (*installed().packages, "maglev.fmi"), layer_names())
        self.layout = program.layout
        self.methods = [program.method(name, types) for name, types in METHODS.items()]
        self.varying = {place for function in functions_of(self.methods) for place in assigned(function)} \
            if beginnings else set[Place]()
        self.text: LanesText | None = None

    def varies(self, place: str) -> bool:
        return place_of(self.layout, place) in self.varying

    def make_vary(self, place: str) -> bool:
        """Note that lanes differ in a place; return True if that is new."""
        new = not self.varies(place)
        self.varying.add(place_of(self.layout, place))
        return new

    def translate(self, width: int) -> LanesText:
        self.text = LanesText(self.layout, self.methods, self.varying, width, f"lanes{self.part.number}_")
        self.varying = self.text.varying
        return self.text

    def path(self, place: str) -> str:
        return f"all->{self.block}.{c_path(place)}"


class LaneCode:
    """C of a wiring in lanes."""

    def __init__(self, wiring: Wiring, native: Mapping[int, Part], varied: Varied, width: int):
        self.calls, = wiring.phases
        self.tracks, self.native, self.varied, self.width = wiring.tracks, native, varied, width
        self.transfers = [[*self.transfers_of(call)] for call in self.calls]
        self.places = {name: (where, column) for where, track in enumerate(self.tracks)
                       for column, name in enumerate(track.names)}
        self.rows: set[tuple[int, int]] = set()   # values of outputs that lanes differ in
        self.used = {(each.track, each.column) for each in chain(*self.transfers) if not each.getting}
        self.parts: dict[int, LanePart] = {}      # by number

    def transfers_of(self, call: Call) -> Iterator[Transfer]:
        if isinstance(call.moving, c_double):
            return
        fmu, part = call.what[0], self.native[id(call.what[0])]
        _, references, count, _ = call.arguments
        where, track = next((where, track) for where, track in enumerate(self.tracks)
                            if 0 <= call.base - track.address < track.array.nbytes)
        first = (int(call.base) - track.address) % track.stride // track.item
        getting = any(call.function is function for function in fmu.get_functions.values())
        for column, reference in enumerate(references[:count.value], first):
            yield Transfer(getting, part, part.variables[reference], where, column)

    @property
    def form(self) -> object:
        """Calls, tracks and differences between runs, from which the C follows."""
        return ([[(call.what[0].name, each.getting, each.variable.name, each.track, each.column) for each in transfers]
                 or call.what[0].name for call, transfers in zip(self.calls, self.transfers, strict=True)],
                [(track.names, track.item, track.signals is None) for track in self.tracks],
                sorted(self.varied.names), self.varied[1:], self.width)

    def translate(self, own: Mapping[int, FmuDefinition]) -> None:
        """Translate the blocks of FMUs, whose definitions are by identity."""
        for key, part in self.native.items():
            self.parts[part.number] = LanePart(part, own[key], self.varied.beginnings)
        for full in self.varied.names:
            if (found := self.variable(full)) is not None:
                lane_part, variable = found
                lane_part.make_vary(variable.place)
        translated: dict[int, int] = {}
        while True:
            for key, lane_part in self.parts.items():
                if translated.get(key) != len(lane_part.varying):
                    lane_part.translate(self.width)
                    translated[key] = len(lane_part.varying)
            if not sum(map(self.carry, chain(*self.transfers))):
                break

    def variable(self, full: str) -> tuple[LanePart, Variable] | None:
        """Return a variable by its full name, with its part; None if there is no such FMU."""
        name, _, variable = full.partition(".")
        number = next((self.native[id(call.what[0])].number for call in self.calls if call.what[0].name == name), None)
        if number is None:
            return None
        part = self.parts[number]
        return part, next(known for known in part.part.variables if known.name == variable)

    def carry(self, transfer: Transfer) -> bool:
        """Pass on a difference between lanes; return True if there are more than before."""
        part, place = self.parts[transfer.part.number], (transfer.track, transfer.column)
        if not transfer.getting:
            return self.row_varies(*place) and part.make_vary(transfer.variable.place)
        new = part.varies(transfer.variable.place) and place not in self.rows
        self.rows |= {place} if new else set()
        return new

    def row_varies(self, where: int, column: int) -> bool:
        signals = self.tracks[where].signals is not None
        return self.varied.signals if signals else (where, column) in self.rows

    def value(self, where: int, column: int) -> str:
        """C of a value of a track: of all lanes, or of one value that they have in common."""
        track = self.tracks[where]
        if track.signals is None:
            return f"all->row{where}_{column}"
        if self.varied.signals:
            return f"lanes_from(row{where}, {column} * points + k)"
        return f"row{where}[{column} * points + k]"

    def lines(self, number: int) -> Iterator[str]:
        """C of a call of a step."""
        call = self.calls[number]
        if isinstance(call.moving, c_double):
            yield from self.step_lines(number, self.parts[self.native[id(call.what[0])].number])
            return
        for getting, native, variable, where, column in self.transfers[number]:
            part = self.parts[native.number]
            value, path = self.value(where, column), part.path(variable.place)
            if getting:
                if (where, column) in self.used:
                    yield f"{value} = {path};"
                continue
            varies = self.row_varies(where, column)
            signals = self.tracks[where].signals is not None
            if not variable.boolean:
                low, high = map(c_literal, variable.settable)
                yield (f"refused |= ~(({value} >= lanes_of_float({low})) & ({value} <= lanes_of_float({high})));"
                       if varies else f"refused |= lanes_of_bool(!({value} >= {low} && {value} <= {high}));")
            given = f"{value} != 0" if variable.boolean and signals else value
            if variable.boolean and signals and varies:
                given = f"({value} != lanes_of_float(0.0))"
            if part.varies(variable.place) and not varies:
                given = f"lanes_of_{'bool' if variable.boolean else 'float'}({given})"
            yield f"{path} = {given};"

    def step_lines(self, number: int, part: LanePart) -> Iterator[str]:
        assert part.text is not None
        clone = part.text.roots[-1]
        function: Function = clone.function
        failing = ", &failure" if function.fails else ""
        call = (f"{clone.name}(&all->{part.block}, calls[{number}].time + (double)k * calls[{number}].time_stride, "
                f"calls[{number}].size{failing})")
        yield "{"
        if function.fails:
            yield "    lanes_int failure = {0};"
        if not function.results:
            yield f"    {call};"
        elif clone.results_vary[0]:
            yield f"    refused |= {call} != lanes_of_int(0);"
        else:
            yield f"    refused |= lanes_of_bool({call} != 0);"
        if function.fails:
            yield "    refused |= failure != lanes_of_int(0);"
        for _, place in part.own.finite:
            yield (f"    refused |= ~lanes_isfinite({part.path(place)});" if part.varies(place) else
                   f"    refused |= lanes_of_bool(!isfinite({part.path(place)}));")
        yield "}"

    def text(self, seen: Sequence[str], amounts: Sequence[str], changing: Sequence[str]) -> str:
        """The C file, which writes the variables `seen`, 0 for one without a name, and takes the sizes of `amounts`.

        Variables that are `changing` can be given other values. The blocks must be translated before.
        """
        self.used |= {self.places[name] for name in (*seen, *amounts) if name}
        members, load, copy = list[str](), list[str](), list[str]()
        texts = [part.text for part in self.parts.values() if part.text is not None]
        for part, text in zip(self.parts.values(), texts, strict=True):
            members.append(f"struct {text.struct_name(part.layout.root)} {part.block};")
            load.append(f"    const {part.part.type} *const {part.block} = "
                        f"(const {part.part.type} *)instances[{part.part.number}]->state->block;")
            load += text.load(f"all->{part.block}", f"(*{part.block})")
            copy += text.copied(f"all->{part.block}")
        for where, track in enumerate(self.tracks):
            for column in range(len(track.names)):
                if track.signals is not None or (where, column) not in self.used:
                    continue
                member, given = f"row{where}_{column}", f"((const {c_type(track)} *)rows[{where}])[{column}]"
                varies = (where, column) in self.rows
                kind = ("lanes_float" if track.item == 8 else "lanes_int") if varies else (
                    "double" if track.item == 8 else "int64_t")
                members.append(f"{kind} {member};")
                value = given if track.item == 8 else f"({given} != 0)"
                if varies:
                    load.append(f"    all->{member}[lane] = {'' if track.item == 8 else '-(int64_t)'}{value};")
                    copy.append(f"    all->{member}[to] = all->{member}[from];")
                else:
                    load += [f"    if (lane == 0) all->{member} = {value};",
                             f"    same = same && {self.same(f'all->{member}', value, track)};"]
        signals = [line for where, track in enumerate(self.tracks) if track.signals is not None
                   for line in self.signal_lines(where)]
        ready = (f"!ready(&instances[{part.number}]->state->progress)" for part in self.native.values())
        return filled_in(
            SOURCE, includes="\n".join(f'#include "{part.header}"' for part in self.native.values()),
            not_ready=" || ".join(ready), width=self.width, tracks=len(self.tracks), columns=len(seen),
            amounts=len(amounts), changes=indented(map(self.change, count(), changing), 4),
            members=indented(members, 4), load="\n".join(load), copy=indented(copy, 8),
            lanes="\n".join([helper_text(texts), *(text.structs() + text.functions_text() for text in texts)]),
            see=indented([*(f"lanes_put(seen + {number} * LANES, {self.seen(name)});"
                            for number, name in enumerate(seen)),
                          *(f"lanes_take_size(sizes + {2 * number} * LANES, sizes + {2 * number + 1} * LANES, "
                            f"{self.seen(name)});" for number, name in enumerate(amounts))], 8),
            signals=indented(signals, 4).lstrip(),
            step=indented((line for number in range(len(self.calls)) for line in self.lines(number)), 8))

    def change(self, number: int, full: str) -> str:
        """C of another value of a variable in which lanes differ."""
        found = self.variable(full)
        assert found is not None
        part, variable = found
        value = "-(int64_t)(value != 0.0)" if variable.boolean else "value"
        return f"case {number}: {part.path(variable.place)}[lane] = {value}; break;"

    def same(self, member: str, value: str, track: Track) -> str:
        if track.item != 8:
            return f"{member} == {value}"
        return f"__builtin_memcmp(&{member}, &{value}, sizeof {member}) == 0"

    def signal_lines(self, where: int) -> Iterator[str]:
        if not self.varied.signals:
            kind = c_type(self.tracks[where])
            yield f"const {kind} *const row{where} = (const {kind} *)rows[{where}];"
            return
        yield f"const double *row{where}[LANES];"
        yield f"LANES_LOOP row{where}[_lane] = (const double *)rows[_lane * TRACKS + {where}];"

    def seen(self, name: str) -> str:
        """C of a variable of all lanes, as numbers."""
        if not name:
            return "lanes_of_float(0.0)"
        where, column = self.places[name]
        value = self.value(where, column)
        if not self.row_varies(where, column):
            return f"lanes_of_float((double){value})"
        return value if self.tracks[where].item == 8 else (
            f"lanes_select({value}, lanes_of_float(1.0), lanes_of_float(0.0))")


def c_type(track: Track) -> str:
    """C type of a value of a track: a Real, or a Boolean of FMI 2.0 or 3.0."""
    return {8: "double", 4: "int32_t", 1: "bool"}[track.item]


class Taken:
    """Runs in groups of lanes: memory of the C, and the status of each run, shape (lanes,).

    `rows` are the addresses of the first row of each track, shape (lanes, tracks), which belongs to `tracks` of the
    lane. `signals`, by number of the track, are those that runs have of their own, shape (lanes, names, points).
    """

    def __init__(self, loop: "LaneLoop", groups: int):
        lanes = groups * loop.width
        self.memory: Any = create_string_buffer(groups * loop.size + ALIGNED)
        self.address = -(-addressof(self.memory) // ALIGNED) * ALIGNED   # as vectors need it
        self.status = np.full(lanes, REFUSED, np.int64)
        self.rows = np.zeros((lanes, len(loop.tracks)), np.uintp)
        self.tracks: dict[int, list[Track]] = {}
        self.signals: dict[int, Array] = {}
        for where, track in enumerate(loop.tracks):
            if track.signals is not None and loop.apart:
                own = self.signals[where] = np.zeros((lanes, *track.signals.shape))
                self.rows[:, where] = own.ctypes.data + np.arange(lanes) * own.strides[0]


class LaneLoop:
    """The function for a wiring that makes runs side by side, as many as it has lanes, or several groups of so many."""

    def __init__(self, made: Kept, wiring: Wiring, native: Mapping[int, Part], width: int, apart: bool):
        self.width = width
        self.apart = apart   # true if every run has signals of its own
        self.tracks = wiring.tracks
        self.addresses = [(track.array if track.signals is None else track.signals).ctypes.data
                          for track in self.tracks]
        calls, = wiring.phases
        fmus = {id(call.what[0]): call.what[0] for call in calls}
        self.instances = (c_void_p * len(fmus))(*(fmus[key].handle() for key in native))
        self.moved = (Moved * len(calls))(*(
            Moved(call.base, call.stride, call.arguments[2].value) if isinstance(call.moving, c_double) else Moved()
            for call in calls))
        library = CDLL(str(made.path.absolute()))
        self.take_in, self.function = library["maglev_lanes_take"], library["maglev_lanes"]
        self.change_in = library["maglev_lanes_change"]
        self.take_in.restype = c_int64
        self.take_in.argtypes = [c_void_p, POINTER(c_void_p), c_void_p, c_int64]
        self.change_in.restype = self.function.restype = None
        self.change_in.argtypes = [c_void_p, c_int64, c_int64, c_double]
        self.function.argtypes = [c_void_p, c_int64, POINTER(Moved), c_void_p, c_int64, c_int64, c_int64, c_void_p,
                                  c_void_p, c_void_p]
        self.size: int = self.take_in(None, None, None, 0)   # bytes of a group

    def begin(self, groups: int = 1) -> Taken:
        """Return memory for runs in so many groups of lanes, without a run."""
        return Taken(self, groups)

    def take(self, taken: Taken, lane: int) -> int:
        """Put initialised instances, whose first row is there, into a lane: DONE, REFUSED or OTHERWISE.

        OTHERWISE if they differ in values that the lanes of a group have in common. Lane 0 of a group is the first.
        """
        taken.tracks[lane] = self.tracks
        for where, track in enumerate(self.tracks):
            if where in taken.signals:
                taken.signals[where][lane] = track.signals
            else:
                taken.rows[lane, where] = self.addresses[where]
        group, within = divmod(lane, self.width)
        status: int = self.take_in(taken.address + group * self.size, self.instances, taken.rows[lane].ctypes.data,
                                   within)
        taken.status[lane] = DONE if status == DONE else REFUSED
        return status

    def change(self, taken: Taken, lane: int, number: int, value: float) -> None:
        """Give a variable, by its number among the changing ones, another value in a lane."""
        group, within = divmod(lane, self.width)
        self.change_in(taken.address + group * self.size, within, number, value)

    def run(self, taken: Taken, first: int, last: int, seen: Array, sizes: Array, group: int = 0) -> None:
        """Write a row of `seen`, shape (groups, points, columns, lanes), at each point from `first`, and step.

        Groups are those from number `group` on. Update sums and largest sizes of amounts in `sizes`, shape (groups,
        amounts, 2, lanes). `last` is the last point of all. A run that an FMU would refuse has the status REFUSED.
        """
        groups, points, _, width = seen.shape
        assert seen.flags.c_contiguous and sizes.flags.c_contiguous and width == self.width == sizes.shape[-1]
        lane = group * width
        self.function(taken.address + group * self.size, groups, self.moved, taken.rows[lane:].ctypes.data, first,
                      first + points, last, seen.ctypes.data, sizes.ctypes.data, taken.status[lane:].ctypes.data)


def lane_loop(wiring: Wiring, seen: Sequence[str], amounts: Sequence[str], varied: Varied, build: bool = False,
              written: Mapping[str, Variables] | None = None, changing: Sequence[str] = ()) -> LaneLoop | None:
    """Return the loop for a wiring, or None if it cannot run in lanes; `build` compiles a loop that is not yet
    compiled.

    It writes the values of the recorded variables `seen`, 0 for an empty name, and adds up the sizes of the `amounts`.
    Those of `varied` that are `changing` can be given other values. It needs native FMUs that this installation builds,
    or `written` ones by name that this process has built, with steps of one length and without clocks. Signals that
    vary must be numbers.
    ExportError from the compiler; OSError if the result cannot be kept.
    """
    fmus = {id(call.what[0]): call.what[0] for call in wiring.phases[0]}
    native = native_parts(fmus.values(), written) if len(wiring.phases) == 1 and in_c(wiring.phases) else None
    booleans = any(track.signals is not None and track.item != 8 for track in wiring.tracks)
    if native is None or (varied.signals and booleans):
        return None
    files, parts = native
    vectors, (host,) = widest(), host_platform().values()
    host = host._replace(flags=(*host.flags, *PARTS_INLINED, f"-mcpu={vectors.processor}"))
    text = LaneCode(wiring, parts, varied, vectors.width)
    if not {*seen, *amounts} - {""} <= {*text.places}:
        return None
    sha256s = [sha256 for fmu in fmus.values() for _, sha256 in fmu.source.digests()]
    place = key_of(BLOCK_LOOPS, sorted(files.items()), sha256s, text.form, [*seen], [*amounts], [*changing],
                   SOURCE.read_text(encoding="utf-8"), FLAGS, host, code())
    name = f"maglev_lanes_{vectors.processor}{host.ending}"
    path = kept(place, name)
    if path is None and build:
        known = {key: own for key, fmu in fmus.items() if (own := known_definition(fmu)) is not None}
        if len(known) < len(fmus):
            return None
        text.translate(known)
        loop = text.text(seen, amounts, changing)
        path = keep_here(place, name, library({**files, LOOP_FILE: loop}, Path(name).stem, host))
    return None if path is None else LaneLoop(path, wiring, parts, vectors.width, varied.signals)


def known_definition(fmu: Fmu) -> FmuDefinition | None:
    """Definition of an FMU that this installation builds, or that this process has built of a user's class."""
    if not isinstance(fmu.source, FmuFile):
        return None
    build = own_build(fmu.source.path)
    return built_definition(fmu.source.path) if build is None else definition(build.name)
