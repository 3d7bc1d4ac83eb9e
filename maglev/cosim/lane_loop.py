"""Whole runs of native FMUs side by side, one in each lane of a vector register, with the bits of single runs.

The FMUs' blocks are translated once more, for lanes: values that differ between runs become vectors. These are
differing start values, values that `start` and `step` compute from them, and values that connections pass on. The
library is compiled here, for the widest vectors that this processor has; its key has their name, so that a cache that
another processor filled has none that this one cannot run.
"""

import platform
import re
from collections.abc import Iterator, Mapping, Sequence
from ctypes import CDLL, POINTER, addressof, byref, c_double, c_int64, c_void_p, create_string_buffer
from pathlib import Path
from typing import Any, NamedTuple

from maglev.cosim.block_loop import (
    DONE,
    HERE,
    LOOP_FILE,
    PARTS_INLINED,
    BlockLoop,
    Moved,
    Part,
    c_type,
    filled_in,
    fmus_of,
    indented,
    of_parts,
)
from maglev.cosim.fmu import Fmu
from maglev.cosim.wiring import Call, Track, Wiring
from maglev.descriptions.own_fmus import definition, installed, own_build
from maglev.files.cache import BLOCK_LOOPS, Kept, digest_at, keep_here, kept, key_of
from maglev.files.installed import code
from maglev.fmi.block_code import c_path
from maglev.fmi.compiler import FLAGS, library
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.native_build import host_platform, layer_names
from maglev.language.blocks import METHODS
from maglev.language.lanes import LanesText, helper_text
from maglev.language.program import Function, Struct
from maglev.language.statements import Program
from maglev.user.blocks import built_definition

SOURCE = HERE / "lane_loop.c"
ALIGNED = 64   # bytes, of the longest vectors


class Vectors(NamedTuple):
    """Vectors of a processor: so many numbers in a register, and zig's name of the processors that have them."""

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
    """The widest vectors of a processor with so many flags, of this one without them."""
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
    """Initial differences between runs: start values by full name, and True if their signals differ."""

    names: frozenset[str]
    signals: bool


class LanePart:
    """An FMU in the loop: its block as a typed program, and the values that differ between lanes."""

    def __init__(self, number: int, fmu: Fmu, own: FmuDefinition):
        self.own, self.variables = own, own.native_variables
        self.part = Part(number, self.variables)
        self.block = self.part.block
        program = Program(own.new_block(), (*installed().packages, "maglev.fmi"), layer_names())
        self.layout = program.layout
        self.methods = [program.method(name, types) for name, types in METHODS.items()]
        self.varying: set[tuple[str, str]] = set()
        self.text: LanesText | None = None

    def attribute(self, place: str) -> tuple[str, str]:
        """Struct and member of a place such as "motors[0].i_a"."""
        kind: Any = self.layout.root
        owner, name = kind, ""
        for part in place.split("."):
            name, *indices = re.findall(r"[^\[\]]+", part)
            owner, kind = kind, self.layout.fields[kind.name][name]
            for _ in indices:
                kind = kind.item
        assert isinstance(owner, Struct)
        return owner.name, name

    def varies(self, place: str) -> bool:
        return self.attribute(place) in self.varying

    def make_vary(self, place: str) -> bool:
        """Note that lanes differ in a place; return True if that is new."""
        new = not self.varies(place)
        self.varying.add(self.attribute(place))
        return new

    def translate(self, width: int) -> None:
        self.text = LanesText(self.layout, self.methods, self.varying, width, f"lanes{self.part.number}_")
        self.varying = self.text.varying

    def path(self, place: str) -> str:
        return f"all.{self.block}.{c_path(place)}"


class LaneCode:
    """C of a wiring in lanes."""

    def __init__(self, wiring: Wiring, parts: Mapping[int, LanePart], varied: Varied, width: int):
        self.calls, = wiring.phases
        self.tracks, self.parts, self.varied, self.width = wiring.tracks, parts, varied, width
        self.rows: set[tuple[int, int]] = set()   # values of outputs that lanes differ in
        for full in varied.names:
            name, _, variable = full.partition(".")
            for call in self.calls:
                if call.what[0].name == name:
                    part = parts[id(call.what[0])]
                    part.make_vary(next(known.place for known in part.variables if known.name == variable))
        translated: dict[int, int] = {}
        while True:
            for key, part in parts.items():
                if translated.get(key) != len(part.varying):
                    part.translate(width)
                    translated[key] = len(part.varying)
            if not sum(self.carry(call) for call in self.calls):
                break

    def transfers(self, call: Call) -> Iterator[tuple[bool, LanePart, Any, int, int]]:
        """Values that a call gets or sets: True for a get, the part, the variable, the track and its column."""
        fmu, part = call.what[0], self.parts[id(call.what[0])]
        _, references, count, _ = call.arguments
        where, track = next((where, track) for where, track in enumerate(self.tracks)
                            if 0 <= call.base - track.address < track.array.nbytes)
        first = (int(call.base) - track.address) % track.stride // track.item
        getting = any(call.function is function for function in fmu.get_functions.values())
        for column, reference in enumerate(references[:count.value], first):
            yield getting, part, part.variables[reference], where, column

    def carry(self, call: Call) -> bool:
        """Pass on differences between lanes; return True if there are more than before."""
        if isinstance(call.moving, c_double):
            return False
        more = False
        for getting, part, variable, where, column in self.transfers(call):
            if getting:
                if part.varies(variable.place) and (where, column) not in self.rows:
                    self.rows.add((where, column))
                    more = True
            elif self.row_varies(where, column):
                more = part.make_vary(variable.place) or more
        return more

    def row_varies(self, where: int, column: int) -> bool:
        signals = self.tracks[where].signals is not None
        return self.varied.signals if signals else (where, column) in self.rows

    def value(self, where: int, column: int) -> str:
        """C of a value of a track: of all lanes, or of one value that they have in common."""
        track = self.tracks[where]
        if track.signals is None:
            return f"all.row{where}_{column}"
        if self.varied.signals:
            return f"lanes_from(row{where}, {column} * points + k)"
        return f"row{where}[{column} * points + k]"

    def lines(self, number: int, call: Call) -> Iterator[str]:
        """C of a call of a step."""
        if isinstance(call.moving, c_double):
            yield from self.step_lines(number, self.parts[id(call.what[0])])
            return
        for getting, part, variable, where, column in self.transfers(call):
            value, path = self.value(where, column), part.path(variable.place)
            if getting:
                yield f"{value} = {path};"
                continue
            varies = self.row_varies(where, column)
            signals = self.tracks[where].signals is not None
            if not variable.boolean:
                low, high = (repr(float(end)) for end in (variable.low, variable.high))
                low, high = (end.replace("inf", "INFINITY") for end in (low, high))
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
        call = (f"{clone.name}(&all.{part.block}, calls[{number}].time + (double)k * calls[{number}].time_stride, "
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

    def outputs(self) -> Iterator[tuple[int, int, Track]]:
        for where, track in enumerate(self.tracks):
            if track.signals is None:
                for column in range(len(track.names)):
                    yield where, column, track

    def text(self, observer: str, seen: Mapping[str, str]) -> str:
        """The C file."""
        members, load, copy = list[str](), list[str](), list[str]()
        for part in self.parts.values():
            assert part.text is not None
            members.append(f"struct {part.text.struct_name(part.layout.root)} {part.block};")
            load.append(f"    const {part.part.type} *const {part.block} = "
                        f"(const {part.part.type} *)instances[{part.part.number}]->state->block;")
            load += part.text.load(f"all->{part.block}", f"(*{part.block})")
            copy += part.text.copied(f"all->{part.block}")
        for where, column, track in self.outputs():
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
        places = {name: (where, column) for where, track in enumerate(self.tracks)
                  for column, name in enumerate(track.names)}
        see = [f"seen[lane].{member} = {self.seen(*places[name])};" for member, name in seen.items()]
        signals = [line for where, track in enumerate(self.tracks) if track.signals is not None
                   for line in self.signal_lines(where)]
        texts = [part.text for part in self.parts.values() if part.text is not None]
        return filled_in(
            SOURCE, **of_parts(part.part for part in self.parts.values()), observer=observer, width=self.width,
            members=indented(members, 4), load="\n".join(load), copy="\n".join(copy),
            lanes="\n".join([helper_text(texts), *(text.structs() + text.functions_text() for text in texts)]),
            see=indented(see, 16), signals=indented(signals, 4).lstrip(),
            step=indented((line for number, call in enumerate(self.calls) for line in self.lines(number, call)), 8))

    def same(self, member: str, value: str, track: Track) -> str:
        if track.item != 8:
            return f"{member} == {value}"
        return f"__builtin_memcmp(&{member}, &{value}, sizeof {member}) == 0"

    def signal_lines(self, where: int) -> Iterator[str]:
        if not self.varied.signals:
            yield f"const double *const row{where} = rows[0][{where}];"
            return
        yield f"const double *row{where}[LANES];"
        yield f"LANES_LOOP row{where}[_lane] = rows[_lane < count ? _lane : 0][{where}];"

    def seen(self, where: int, column: int) -> str:
        track = self.tracks[where]
        if track.signals is not None:
            return f"row{where}{'[lane]' if self.varied.signals else ''}[{column} * points + k]"
        varies = (where, column) in self.rows
        sign = "-" if varies and track.item != 8 else ""
        return f"(double){sign}all.row{where}_{column}{'[lane]' if varies else ''}"


class Taken:
    """Runs in lanes: memory of the C, and rows with the arrays that they point to."""

    def __init__(self) -> None:
        self.memory: Any = None
        self.rows: list[tuple[Any, list[Any]]] = []

    def address(self, size: int) -> int:
        """Address of so many bytes, as vectors need it."""
        if self.memory is None:
            self.memory = create_string_buffer(size + ALIGNED)
        return -(-addressof(self.memory) // ALIGNED) * ALIGNED


class LaneLoop:
    """The function for a wiring that makes several runs side by side."""

    def __init__(self, made: Kept, loop: BlockLoop, width: int, apart: bool):
        self.width = width
        self.loop = loop
        self.apart = apart   # true if every run has signals of its own
        library = CDLL(str(made.path.absolute()))
        self.take_in, self.function = library["maglev_lanes_take"], library["maglev_lanes"]
        self.take_in.restype = c_int64
        self.take_in.argtypes = [c_void_p, POINTER(c_void_p), POINTER(c_void_p), c_int64]
        self.function.restype = None
        self.function.argtypes = [c_void_p, c_int64, POINTER(Moved), POINTER(c_void_p), c_int64, POINTER(c_int64),
                                  POINTER(c_void_p), POINTER(c_int64)]
        self.size: int = self.take_in(None, None, None, 0)

    def take(self, taken: Taken) -> int:
        """Put initialised instances, whose first row is there, into the next lane: DONE, REFUSED or OTHERWISE.

        OTHERWISE if they differ in values that the lanes have in common.
        """
        arrays = [track.array if track.signals is None else track.signals.copy() if self.apart else track.signals
                  for track in self.loop.tracks]
        rows = (c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
        status: int = self.take_in(taken.address(self.size), self.loop.instances, rows, len(taken.rows))
        if status == DONE:
            taken.rows.append((rows, arrays))
        return status

    def run(self, taken: Taken, steps: int, ended: c_int64, observers: Sequence[Any]) -> list[int]:
        """Make all steps of the runs that are taken, each of which has a struct observer.

        Returns how each ends, see `BlockLoop.run`.
        """
        count = len(taken.rows)
        status = (c_int64 * count)()
        self.function(taken.address(self.size), count, self.loop.moved,
                      (c_void_p * count)(*(addressof(own) for own, _ in taken.rows)), steps, byref(ended),
                      (c_void_p * count)(*(addressof(each) for each in observers)), status)
        return [*status]


def lane_loop(loop: BlockLoop, wiring: Wiring, observer: str, seen: Mapping[str, str], varied: Varied,
              build: bool = False) -> LaneLoop | None:
    """The loop in lanes for a wiring that has a loop, compiled now if it was not before and `build` asks for it.

    None if no such loop is there, or possible: signals that are Booleans, or an FMU whose block is not known here. For
    the others, and errors, see `block_loop`.
    """
    fmus = fmus_of(wiring.phases[0])
    if any(track.signals is not None and track.item != 8 for track in wiring.tracks):
        return None
    vectors, (host,) = widest(), host_platform().values()
    host = host._replace(flags=(*host.flags, *PARTS_INLINED, f"-mcpu={vectors.processor}"))
    place = key_of(BLOCK_LOOPS, sorted(loop.sources.items()), FLAGS, host, code(), sorted(varied.names), varied.signals,
                   vectors.width, [digest_at(fmu.path) for fmu in fmus])
    name = f"maglev_lanes_{vectors.processor}{host.ending}"
    path = kept(place, name)
    if path is None and build:
        parts = {}
        for number, fmu in enumerate(fmus):
            own = known_definition(fmu)
            if own is None:
                return None
            parts[id(fmu)] = LanePart(number, fmu, own)
        text = LaneCode(wiring, parts, varied, vectors.width).text(observer, seen)
        path = keep_here(place, name, library({**loop.sources, LOOP_FILE: text}, Path(name).stem, host))
    return None if path is None else LaneLoop(path, loop, vectors.width, varied.signals)


def known_definition(fmu: Fmu) -> FmuDefinition | None:
    """Definition of an FMU that this installation builds, or that this process has built of a user's class."""
    build = own_build(fmu.path)
    return built_definition(fmu.path) if build is None else definition(build.name)
