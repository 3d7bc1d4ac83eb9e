"""A whole run of native FMUs of this installation as one C function, with the FMUs' blocks in it.

The calls of a step go through FMI: a function for each, a table for each variable, checks. FMUs of this installation
carry their blocks as C, so that whoever runs them often compiles these into the calls' place. The function begins with
the initialised instances and with their first row, and has the operations of the calls: its bits are theirs. What comes
of a run is up to C that is given: it sees chosen columns at each communication point. A run that an FMU would refuse is
said to be one; then the calls are made, and say what is wrong.

Nearly all that the runs of a batch begin with are parameters and what follows from them, which they have in common but
for a few. As constants in the C these take no memory, and what they switch off is left out: a flexible mode, a rough
rail, a noise. Every operation that is left has the operands that it had, so that the bits of a run stay.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from ctypes import CDLL, POINTER, Array, Structure, addressof, byref, c_double, c_int64, c_void_p, create_string_buffer
from functools import lru_cache
from pathlib import Path
from string import Template
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt
from fmpy import sharedLibraryExtension

from fmi_export.definition import Variable
from fmi_export.language.c_text import c_literal
from fmi_export.native.block_code import BLOCK, c_path, prefixed
from fmi_export.native.build import PREFIX, SOURCES, host_platform
from fmi_export.native.compiler import FLAGS, library
from maglev.cosim.fmu import Fmu
from maglev.cosim.step_loop import in_c
from maglev.cosim.wires.wiring import Call, Track, Wiring
from maglev.own_fmus import definition, files_in, own_build
from maglev.user_controllers.blocks import Variables
from maglev_files.cache import BLOCK_LOOPS, Kept, digest_at, keep_here, kept, key_of

HERE = Path(__file__).parent   # with the C around the blocks
LIBRARY = f"maglev_block_loop{sharedLibraryExtension}"
FUNCTION = "maglev_whole_run"
# Parts of blocks become part of their callers up to this size; an FMU's step takes no longer without it.
PARTS_INLINED = ("-mllvm", "-inline-threshold=1000")
# A call would put blocks into memory, and a place that is computed where branches are merged.
INLINED = ("-Dnoinline=always_inline", "-mllvm", "-inline-threshold=1000000", "-mllvm", "-sink-common-insts=false")
# The run, which needs no FMU, over it how it begins with FMUs' instances, and the function that does both.
RUN_FILE, LOOP_FILE, FUNCTION_FILE = "whole_run.h", "loop.c", "loop_function.c"
EXPORT_FILE = "export.h"
DONE, REFUSED, ENDED, OTHERWISE = range(4)   # what the function returns: RUN_DONE and so on of whole_run.h

INSTANCE = {"instance.h", "model.h"}   # what an instance is

Words = npt.NDArray[np.uint64]
WORD = np.dtype(np.uint64).itemsize


class Common(NamedTuple):
    """What a run of several begins with, in words, and the places of those that others begin with otherwise."""

    words: Words
    places: tuple[int, ...]

    @classmethod
    def of(cls, words: Words, before: Self | None = None) -> Self:
        """Of runs, shape (runs, words), and of those before."""
        first = words[0] if before is None else before.words
        places = {*(before.places if before is not None else ()), *np.flatnonzero((words != first).any(0)).tolist()}
        return cls(first, tuple(sorted(places)))

    def holds(self, words: Words) -> bool:
        """Whether runs, shape (runs, words), differ at these places alone."""
        return not np.delete((words != self.words).any(0), self.places).any()

    def code(self, calls: Iterable[Structure]) -> str:
        """C of it, for behind that of the run; `calls` are the struct moved of the loop."""
        moved = ", ".join(f"{{{', '.join(repr(getattr(call, name)) for name, *_ in call._fields_)}}}" for call in calls)
        return filled_in(
            HERE / "common_beginning.h", begins=", ".join(map(str, self.words.tobytes())), calls=moved,
            count=max(1, len(self.places)),
            places="\n".join(f"    __builtin_memcpy((char *)beginning + {WORD * place}, own + {k}, {WORD});"
                             for k, place in enumerate(self.places)),
            words="\n".join(f"    __builtin_memcpy(own + {k}, (const char *)beginning + {WORD * place}, {WORD});"
                            for k, place in enumerate(self.places)))


def words_of(beginnings: Sequence[bytes]) -> Words:
    """What runs begin with, shape (runs, words)."""
    return np.frombuffer(b"".join(beginnings), np.uint64).reshape(len(beginnings), -1)


class Moved(Structure):
    """What moves in a call from step to step, as the C function takes it."""

    _fields_ = (("time", c_double), ("time_stride", c_double), ("size", c_double))


class Part(NamedTuple):
    """An FMU in the loop: its place among the instances, and its variables by their value references."""

    number: int
    variables: Variables

    @property
    def block(self) -> str:
        return f"block{self.number}"

    @property
    def header(self) -> str:
        """Name of the header with its C, whose names begin with the block's."""
        return f"{self.block}.h"

    @property
    def type(self) -> str:
        return f"{self.block}_Block"

    @property
    def step(self) -> str:
        """Name of the function that steps it."""
        return f"{self.block}_step_block"

    def value(self, variable: Variable) -> str:
        return f"{self.block}.{c_path(variable.place)}"


class BlockLoop:
    """The function for a wiring, on its instances and rows, and what it is made of: C files by name."""

    def __init__(self, loop: Kept, wiring: Wiring, sources: Mapping[str, str]):
        self.sources = sources
        library = CDLL(str(loop.path.absolute()))
        self.functions, self.beginning = [stepping_function(library)], library[f"{FUNCTION}_begin"]
        self.beginning.restype = c_int64
        self.beginning.argtypes = [POINTER(c_void_p), POINTER(c_void_p), c_void_p]
        self.size: int = self.beginning(None, None, None)   # bytes of what a run begins with
        calls, = wiring.phases
        fmus = fmus_of(calls)
        self.instances = (c_void_p * len(fmus))(*(fmu.handle() for fmu in fmus))
        self.moved = (Moved * len(calls))(*(
            Moved(call.base, call.stride, call.arguments[2].value) if isinstance(call.moving, c_double) else Moved()
            for call in calls))
        self.tracks = wiring.tracks

    def run(self, steps: int, ended: c_int64, observer: Structure) -> int:
        """Make all steps, from initialised instances whose first row is there: DONE, or REFUSED, or ENDED.

        ENDED is soon after `ended` is no longer 0. `observer` is the struct of the C that observes.
        """
        for function in self.functions:
            status: int = function(self.instances, self.moved, self.rows(), steps, byref(ended), addressof(observer))
            if status != OTHERWISE:
                break
        return status

    def specialise(self, common: Common, build: bool) -> None:
        """Have runs that begin as these have it by a function of their own, compiled now if `build` asks for it.

        Other runs go as before. Errors as of `block_loop`.
        """
        function = filled_in(HERE / "common_function.c", common=common.code(self.moved))
        path = loop_of({**self.sources, FUNCTION_FILE: function}, build, INLINED)
        if path is not None:
            self.functions.insert(0, stepping_function(CDLL(str(path.path.absolute()))))

    def begin(self) -> bytes:
        """What a run begins with, as the C has it, from initialised instances; empty where one would be REFUSED."""
        room = create_string_buffer(self.size)
        written = self.beginning(self.instances, self.rows(), room)
        return room.raw[:written]

    def rows(self) -> Array[c_void_p]:
        return (c_void_p * len(self.tracks))(*(
            (track.array if track.signals is None else track.signals).ctypes.data for track in self.tracks))


def stepping_function(library: CDLL) -> Any:
    function = library[FUNCTION]
    function.restype = c_int64
    function.argtypes = [POINTER(c_void_p), POINTER(Moved), POINTER(c_void_p), c_int64, POINTER(c_int64), c_void_p]
    return function


def block_loop(wiring: Wiring, observer: str, seen: Mapping[str, str], build: bool = False,
               written: Mapping[str, Variables] | None = None) -> BlockLoop | None:
    """The loop for a wiring, compiled now if it was not before and `build` asks for it.

    `observer` is C with a struct seen, a struct observer and a function observe; `seen` has the recorded variable, by
    full name, for each member of the struct seen that it reads. None where there is no loop, or can be none: the FMUs
    are native ones that this installation builds, or `written` ones by name, all of them with steps of one length and
    none with clocks, and all that is seen is recorded. ExportError of the compiler; OSError if the result cannot be
    kept.
    """
    sources = loop_sources(wiring, observer, seen, written or {})
    if sources is None:
        return None
    path = loop_of(sources, build)
    return None if path is None else BlockLoop(path, wiring, sources)


def loop_of(sources: Mapping[str, str], build: bool, flags: Sequence[str] = PARTS_INLINED) -> Kept | None:
    """Library of C files, compiled now if it was not before and `build` asks for it; errors as of `block_loop`."""
    platform, = host_platform().values()
    platform = platform._replace(flags=(*platform.flags, *flags))
    place = key_of(BLOCK_LOOPS, sorted(sources.items()), FLAGS, platform)
    path = kept(place, LIBRARY)
    if path is None and build:
        path = keep_here(place, LIBRARY, library(sources, Path(LIBRARY).stem, platform))
    return path


def fmus_of(calls: Iterable[Call]) -> list[Fmu]:
    """FMUs of calls, each once, in the order of the calls."""
    return list({id(call.what[0]): call.what[0] for call in calls}.values())


def loop_sources(wiring: Wiring, observer: str, seen: Mapping[str, str],
                 written: Mapping[str, Variables]) -> dict[str, str] | None:
    """C files by name; None where there are none for this wiring, see `block_loop`."""
    if len(wiring.phases) != 1 or not in_c(wiring.phases):
        return None
    calls, = wiring.phases
    places = {name: (number, column) for number, track in enumerate(wiring.tracks)
              for column, name in enumerate(track.names)}
    if not {*seen.values()} <= {*places}:
        return None
    collected = native_parts(fmus_of(calls), written)
    if collected is None:
        return None
    files, parts = collected
    steps = [line for number, call in enumerate(calls) for line in call_lines(number, call, parts, wiring.tracks)]
    members, copy, begin = zip(*beginnings(wiring.tracks, parts.values()), strict=True)
    signals = [f"const {item_of(track)} *const row{number} = (const {item_of(track)} *)rows[{number}];"
               for number, track in enumerate(wiring.tracks) if track.signals is not None]
    run = filled_in(
        HERE / RUN_FILE, observer=observer, step=indented(steps, 8), members=indented(members, 4),
        includes="\n".join(sorted({f'#include "{part.header}"' for part in parts.values()})),
        begin=indented((*begin, *signals), 4),
        see=indented((f"seen.{member} = (double){value_at(*places[name], wiring.tracks)};"
                      for member, name in seen.items()), 8))
    ready = " || ".join(f"!ready(&instances[{part.number}]->state->progress)" for part in parts.values())
    return {**files, RUN_FILE: run, LOOP_FILE: filled_in(HERE / LOOP_FILE, copy=indented(copy, 8), ready=ready),
            FUNCTION_FILE: filled_in(HERE / FUNCTION_FILE)}


def beginnings(tracks: Sequence[Track], parts: Iterable[Part]) -> Iterator[tuple[str, str, str]]:
    """C of each block and each row of outputs: as a member of struct beginning, written to that, and a copy of it."""
    for part in parts:
        declared = f"{part.type} {part.block}"
        yield (f"{declared};", f"beginning->{part.block} = *(const {part.type} *)"
               f"instances[{part.number}]->state->block;", f"{declared} = beginning->{part.block};")
    for number, track in enumerate(tracks):
        if track.signals is None:
            item, row = item_of(track), f"row{number}"
            loop = f"for (int i = 0; i < {len(track.names)}; ++i)"
            declared = f"{item} {row}[{len(track.names)}];"
            yield (declared, f"{loop} beginning->{row}[i] = ((const {item} *)rows[{number}])[i];",
                   f"{declared} {loop} {row}[i] = beginning->{row}[i];")


def native_parts(fmus: Iterable[Fmu], written: Mapping[str, Variables] | None = None
                 ) -> tuple[dict[str, str], dict[int, Part]] | None:
    """C files of blocks by name, and FMUs by identity, where each is a native one of this installation, or written."""
    parts: dict[int, Part] = {}
    files: dict[str, str] = {PREFIX: "/* Everything is one translation unit: no name is shared. */\n",
                             EXPORT_FILE: filled_in(HERE / EXPORT_FILE)}
    for number, fmu in enumerate(fmus):
        build, variables = own_build(fmu.path), (written or {}).get(fmu.name)
        if build is not None and build.kind == "native":
            variables = definition(build.name).native_variables
        if variables is None or fmu.scales:
            return None
        parts[id(fmu)] = part = Part(number, variables)
        code, instance = block_files(fmu.path, digest_at(fmu.path))
        files |= {**instance, part.header: prefixed(code, f"{part.block}_")}
    return files, parts


def item_of(track: Track) -> str:
    """C type of a value of a track: a Real, or a Boolean of FMI 2.0 or 3.0."""
    return {8: "double", 4: "int32_t", 1: "bool"}[track.item]


def value_at(number: int, column: int, tracks: Sequence[Track]) -> str:
    """C expression of a value of a track at the present point.

    One row of outputs is enough, for who steps later sets from it.
    """
    return f"row{number}[{column}]" if tracks[number].signals is None else f"row{number}[{column} * points + k]"


@lru_cache(maxsize=16)
def block_files(path: Path, _sha256: str) -> tuple[str, dict[str, str]]:
    """C that an FMU carries of its block, and the headers, by name, of what an instance is.

    Read once for each content of the file: every batch asks for them. Nothing may be changed in them.
    """
    carried = {name.removeprefix(SOURCES): data.decode("utf-8") for name, data in files_in(path).items()
               if name.startswith(SOURCES)}
    return carried[BLOCK], {name: carried[name] for name in INSTANCE}


def call_lines(number: int, call: Call, parts: Mapping[int, Part], tracks: Sequence[Track]) -> Iterator[str]:
    fmu, part = call.what[0], parts[id(call.what[0])]
    if isinstance(call.moving, c_double):
        yield (f"refused = refused || {part.step}(&{part.block}, calls[{number}].time + "
               f"(double)k * calls[{number}].time_stride, calls[{number}].size) != 0;")
        return
    _, references, count, _ = call.arguments
    where, track = next((where, track) for where, track in enumerate(tracks)
                        if 0 <= call.base - track.address < track.array.nbytes)
    first = (int(call.base) - track.address) % track.stride // track.item
    getting = any(call.function is function for function in fmu.get_functions.values())
    for column, reference in enumerate(references[:count.value], first):
        variable = part.variables[reference]
        value = value_at(where, column, tracks)
        if getting:
            yield f"{value} = {part.value(variable)};"
            continue
        if not variable.boolean:
            yield f"refused = refused || {out_of_range(variable, value)};"
        yield f"{part.value(variable)} = {value}{' != 0' if variable.boolean else ''};"


def out_of_range(variable: Variable, value: str) -> str:
    """C of whether a variable cannot be set to a value, as set_reals of variables.c has it."""
    return f"!({value} >= {c_literal(float(variable.low))} && {value} <= {c_literal(float(variable.high))})"


def filled_in(file: Path, **what: object) -> str:
    """Text of a file of C, with what stands in place of its `$names`."""
    return Template(file.read_text(encoding="utf-8")).substitute(what)


def indented(lines: Iterable[str], by: int) -> str:
    return "\n".join(" " * by + line for line in lines)
