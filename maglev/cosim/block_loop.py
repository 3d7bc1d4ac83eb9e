"""A whole run of native FMUs of this installation as one C function, with the FMUs' blocks in it.

The calls of a step go through FMI: a function for each, a table for each variable, checks. FMUs of this installation
carry their blocks as C, so that frequent runs can replace the calls with these blocks, compiled together. The function
begins with the initialised instances and with their first row, and has the operations of the calls: the bits are the
same. The results of a run are up to C that is given: it sees chosen columns at each communication point. The function
reports a run that an FMU would refuse; then the calls are made, and give the error.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from ctypes import CDLL, POINTER, Array, Structure, addressof, byref, c_double, c_int64, c_void_p
from functools import lru_cache
from pathlib import Path
from string import Template
from typing import NamedTuple

from fmpy import sharedLibraryExtension

from maglev.cosim.fmu import Fmu
from maglev.cosim.step_loop import in_c
from maglev.cosim.wiring import Call, Track, Wiring
from maglev.descriptions.own_fmus import definition, files_in, own_build
from maglev.files.cache import BLOCK_LOOPS, Kept, digest_at, keep_here, kept, key_of
from maglev.fmi.block_code import BLOCK, c_path, prefixed
from maglev.fmi.compiler import FLAGS, library
from maglev.fmi.definition import Variable
from maglev.fmi.native_build import PREFIX, SOURCES, host_platform
from maglev.language.c_text import c_literal
from maglev.user.blocks import Variables

HERE = Path(__file__).parent   # with the C around the blocks
LIBRARY = f"maglev_block_loop{sharedLibraryExtension}"
FUNCTION = "maglev_whole_run"
# Parts of blocks become part of their callers up to this size; an FMU's step takes no longer without it.
PARTS_INLINED = ("-mllvm", "-inline-threshold=1000")
LOOP_FILE, EXPORT_FILE, RUN_FILE = "loop.c", "export.h", "run.h"
DONE, REFUSED, ENDED, OTHERWISE = range(4)   # results of functions: RUN_DONE and so on of run.h

INSTANCE = {"instance.h", "model.h"}   # headers of an instance


class Moved(Structure):
    """Arguments of a call that move from step to step, as the C function takes them."""

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
    """The function for a wiring, on its instances and rows."""

    def __init__(self, loop: Kept, wiring: Wiring, sources: Mapping[str, str]):
        self.sources = sources   # C files by name
        self.function = CDLL(str(loop.path.absolute()))[FUNCTION]
        self.function.restype = c_int64
        self.function.argtypes = [POINTER(c_void_p), POINTER(Moved), POINTER(c_void_p), c_int64, POINTER(c_int64),
                                  c_void_p]
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
        return int(self.function(self.instances, self.moved, self.rows(), steps, byref(ended), addressof(observer)))

    def rows(self) -> Array[c_void_p]:
        return (c_void_p * len(self.tracks))(*(
            (track.array if track.signals is None else track.signals).ctypes.data for track in self.tracks))


def block_loop(wiring: Wiring, observer: str, seen: Mapping[str, str], build: bool = False,
               written: Mapping[str, Variables] | None = None) -> BlockLoop | None:
    """The loop for a wiring, compiled now if it was not before and `build` asks for it.

    `observer` is C with a struct seen, a struct observer and a function observe; `seen` has the recorded variable, by
    full name, for each member of the struct seen that it reads. None if no loop is there, or possible. A loop needs
    native FMUs that this installation builds, or `written` ones by name, with steps of one length and without clocks,
    and all variables of `seen` recorded. ExportError from the compiler; OSError if the result cannot be kept.
    """
    sources = loop_sources(wiring, observer, seen, written or {})
    if sources is None:
        return None
    path = loop_of(sources, build)
    return None if path is None else BlockLoop(path, wiring, sources)


def loop_of(sources: Mapping[str, str], build: bool) -> Kept | None:
    """Library of C files, compiled now if it was not before and `build` asks for it; errors as in `block_loop`."""
    platform, = host_platform().values()
    platform = platform._replace(flags=(*platform.flags, *PARTS_INLINED))
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
    """C files by name; None if this wiring has no loop, see `block_loop`."""
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
    begin = [f"{part.type} {part.block} = *(const {part.type} *)instances[{part.number}]->state->block;"
             for part in parts.values()] + [row_lines(number, track) for number, track in enumerate(wiring.tracks)]
    see = (f"seen.{member} = (double){value_at(*places[name], wiring.tracks)};" for member, name in seen.items())
    return {**files, RUN_FILE: filled_in(HERE / RUN_FILE), LOOP_FILE: filled_in(
        HERE / LOOP_FILE, observer=observer, step=indented(steps, 8), begin=indented(begin, 4), see=indented(see, 8),
        **of_parts(parts.values()))}


def of_parts(parts: Iterable[Part]) -> dict[str, str]:
    """C that includes the blocks of parts, and the test of whether an instance of one is not ready."""
    parts = list(parts)
    return {"includes": "\n".join(sorted({f'#include "{part.header}"' for part in parts})),
            "not_ready": " || ".join(f"!ready(&instances[{part.number}]->state->progress)" for part in parts)}


def row_lines(number: int, track: Track) -> str:
    """C that makes the row of a track: all points of signals, a copy of the first row of outputs."""
    item, given = c_type(track), f"(const {c_type(track)} *)rows[{number}]"
    if track.signals is not None:
        return f"const {item} *const row{number} = {given};"
    return (f"{item} row{number}[{len(track.names)}]; "
            f"for (int i = 0; i < {len(track.names)}; ++i) row{number}[i] = ({given})[i];")


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


def c_type(track: Track) -> str:
    """C type of a value of a track: a Real, or a Boolean of FMI 2.0 or 3.0."""
    return {8: "double", 4: "int32_t", 1: "bool"}[track.item]


def value_at(number: int, column: int, tracks: Sequence[Track]) -> str:
    """C expression of a value of a track at the present point.

    One row of outputs is enough, because later steps set from it.
    """
    return f"row{number}[{column}]" if tracks[number].signals is None else f"row{number}[{column} * points + k]"


@lru_cache(maxsize=16)
def block_files(path: Path, _sha256: str) -> tuple[str, dict[str, str]]:
    """C of the block in an FMU, and the headers, by name, of its instances.

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
    low, high = map(c_literal, variable.settable)
    return f"!({value} >= {low} && {value} <= {high})"


def filled_in(file: Path, **what: object) -> str:
    """Text of a file of C, with values instead of its `$names`."""
    return Template(file.read_text(encoding="utf-8")).substitute(what)


def indented(lines: Iterable[str], by: int) -> str:
    return "\n".join(" " * by + line for line in lines)
