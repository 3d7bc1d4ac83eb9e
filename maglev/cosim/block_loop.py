"""The steps of native FMUs of this installation as one C function, with the FMUs' blocks in it.

The calls of a step go through FMI: a function for each, a table for each variable, checks. FMUs of this installation
carry their blocks as C, so that whoever flies them often compiles these into the calls' place. The function works on
the memory of the same instances and of the same rows, and with the same operations: bits are those of the calls. It
takes a stretch of steps whole or leaves all as it was; then the calls are made, and say what is wrong.
"""

import hashlib
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from ctypes import CDLL, POINTER, Structure, c_double, c_int64, c_void_p
from math import inf
from pathlib import Path
from typing import NamedTuple

from fmpy import sharedLibraryExtension

from fmi_export.definition import FmuDefinition, Variable
from fmi_export.native.build import PREFIX, SOURCES, TABLE, host_platform
from fmi_export.native.compiler import FLAGS, library
from fmi_export.native.shells import SHELLS
from fmi_export.native.translation import literal
from maglev.cosim.fmu import Fmu
from maglev.cosim.step_loop import c_function, in_c
from maglev.cosim.versions.fmi import FMI2
from maglev.cosim.wires.wiring import Call
from maglev.own_fmus import definition, files_in, own_build
from maglev_files.cache import Kept, keep, kept

LIBRARY = f"maglev_block_loop{sharedLibraryExtension}"
FUNCTION = "maglev_blocks_over"

CONSTANT = re.compile(r"^static const \w+ (\w+) = ", re.MULTILINE)   # of a module, in its header

SOURCE = """\
#include "instance.h"
{includes}

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* The struct Moved of block_loop.py. */
struct moved {{
    char *row;
    int64_t stride;
    double time, time_stride, size;
}};

/* Whether an instance would take a step of co-simulation as it is. */
static bool ready(const struct Progress *progress)
{{
    return progress->phase == RUNNING && !progress->exchange && !progress->events && !progress->suspect;
}}

/* What take_step of life.c leaves of the time. */
static void stepped(struct Progress *progress, const struct moved *call, int64_t k)
{{
    progress->timed = true;
    progress->next_time = call->time + (double)k * call->time_stride + call->size;
}}

/* Steps first to before last, rows being counted from communication point origin. Returns 1, or 0 with all as it was,
   but the rows: an FMU would refuse something. */
EXPORT int64_t {function}(struct Instance *const *instances, const struct moved *calls, int64_t first, int64_t last,
                          int64_t origin);
int64_t {function}(struct Instance *const *instances, const struct moved *calls, int64_t first, int64_t last,
                   int64_t origin)
{{
    if ({ready}) {{
        return 0;
    }}
{begin}
    bool refused = false;
    for (int64_t k = first; k < last; ++k) {{
{step}
        if (refused) {{
            return 0;
        }}
    }}
{end}
    return 1;
}}
"""


class Moved(Structure):
    """What moves in a call from step to step, as the C function takes it."""

    _fields_ = (("row", c_void_p), ("stride", c_int64), ("time", c_double), ("time_stride", c_double),
                ("size", c_double))


class Part(NamedTuple):
    """An FMU in the loop: its place among the instances, what it is, and the files of its block by name."""

    number: int
    definition: FmuDefinition
    files: Mapping[str, str]

    @property
    def block(self) -> str:
        """Name of the C variable with its block."""
        return f"block{self.number}"

    def value(self, variable: Variable) -> str:
        """C expression of a variable."""
        return f"{self.block}.{variable.place}"


class BlockLoop:
    """The function, for the calls of a wiring."""

    def __init__(self, loop: Kept, calls: Sequence[Call], counter: memoryview):
        self.function = CDLL(str(loop.path.absolute()))[FUNCTION]
        self.function.restype = c_int64
        self.function.argtypes = [POINTER(c_void_p), POINTER(Moved), c_int64, c_int64, c_int64]
        fmus = fmus_of(calls)
        self.instances = (c_void_p * len(fmus))(*(fmu.handle() for fmu in fmus))
        self.moved = (Moved * len(calls))(*map(moved, calls))
        self.counter = counter

    def step_over(self, first: int, last: int, origin: int) -> bool:
        """Make steps as a `Stepper` does; False if the calls have to be made, of which one may be refused."""
        if not self.function(self.instances, self.moved, first, last, origin):
            return False
        self.counter[0] += len(self.moved) * (last - first)
        return True


def moved(call: Call) -> Moved:
    """What moves in a call."""
    if isinstance(call.moving, c_double):
        return Moved(None, 0, call.base, call.stride, call.arguments[2].value)
    return Moved(int(call.base), int(call.stride), 0.0, 0.0, 0.0)


def block_loop(phases: Sequence[Sequence[Call]], counter: memoryview, build: bool = False) -> BlockLoop | None:
    """The loop for the calls of a wiring, compiled now if it was not before and `build` asks for it.

    None where there is none, or can be none: the FMUs are native ones of FMI 2.0 that this installation builds, all of
    them with steps of one length. ExportError of the compiler; OSError if the result cannot be kept.
    """
    sources = sources_of(phases)
    if sources is None:
        return None
    platform, = host_platform().values()
    key = hashlib.sha256(repr((sorted(sources.items()), FLAGS, platform)).encode("utf-8")).hexdigest()[:32]
    place = f"block_loops/{key}"
    found = kept(place, LIBRARY)
    if found is None and build:
        found = keep(place, LIBRARY, library(sources, Path(LIBRARY).stem, platform))
    return None if found is None else BlockLoop(found, phases[0], counter)


def fmus_of(calls: Iterable[Call]) -> list[Fmu]:
    """FMUs of calls, each once, in the order of the calls."""
    return list({id(call.what[0]): call.what[0] for call in calls}.values())


def sources_of(phases: Sequence[Sequence[Call]]) -> dict[str, str] | None:
    """C files by name; None where there are none for these calls, see `block_loop`."""
    if len(phases) != 1 or not in_c(phases):
        return None
    parts: dict[int, Part] = {}
    for number, fmu in enumerate(fmus_of(phases[0])):
        build = own_build(fmu.path) if fmu.fmi is FMI2 and not fmu.scales else None
        if build is None or build.kind != "native":
            return None
        parts[id(fmu)] = Part(number, definition(build.name), files_of_block(fmu.path))
    files: dict[str, str] = {PREFIX: "/* Everything is one translation unit: no name is shared. */\n"}
    for part in parts.values():
        others = {name for other in parts.values() if other is not part for name in other.files}
        if any(files.setdefault(name, text) != text for name, text in with_own_names(part, others).items()):
            return None
    lines = [line for number, call in enumerate(phases[0]) for line in call_lines(number, call, parts)]
    return {**files, "loop.c": SOURCE.format(
        function=FUNCTION, step=indented(lines, 8),
        includes="\n".join(sorted({f'#include "{header_of(part.definition)}"' for part in parts.values()})),
        ready=" || ".join(f"!ready(&instances[{part.number}]->state->progress)" for part in parts.values()),
        begin=indented((f"struct {part.definition.block.__name__} {part.block} = *(const struct "
                        f"{part.definition.block.__name__} *)instances[{part.number}]->state->block;"
                        for part in parts.values()), 4),
        end=indented((line for part in parts.values() for line in (
            f"*(struct {part.definition.block.__name__} *)instances[{part.number}]->state->block = {part.block};",
            f"stepped(&instances[{part.number}]->state->progress, &calls[{last_step(phases[0], parts, part)}], "
            "last - 1);")), 4))}


def header_of(fmu: FmuDefinition) -> str:
    """Header of an FMU's block."""
    return f"{fmu.block.__module__.rpartition('.')[2]}.h"


def files_of_block(path: Path) -> dict[str, str]:
    """C files, by name, that an FMU carries of its block, without those of derivatives, and what an instance is."""
    carried = {name.removeprefix(SOURCES): data.decode("utf-8") for name, data in files_in(path).items()
               if name.startswith(SOURCES)}
    layer = {*SHELLS[2].layer, PREFIX, TABLE} - {"instance.h", "model.h"}
    return {name: text for name, text in carried.items() if name not in layer and "_tangent." not in name}


def with_own_names(part: Part, others: Collection[str]) -> dict[str, str]:
    """Files of an FMU in which those that it alone has call their constants by names that it alone has."""
    own = {name: text for name, text in part.files.items() if name not in others}
    names = [found for text in own.values() for found in CONSTANT.findall(text)]
    if not names:
        return dict(part.files)
    pattern = re.compile(rf"\b({'|'.join(names)})\b")
    return {**part.files, **{name: pattern.sub(rf"\1_OF_{part.number}", text) for name, text in own.items()}}


def last_step(calls: Sequence[Call], parts: Mapping[int, Part], part: Part) -> int:
    """Number of the last call that steps an FMU."""
    return max(number for number, call in enumerate(calls)
               if isinstance(call.moving, c_double) and parts[id(call.what[0])] is part)


def call_lines(number: int, call: Call, parts: Mapping[int, Part]) -> Iterator[str]:
    """C of a call."""
    fmu, part = call.what[0], parts[id(call.what[0])]
    if isinstance(call.moving, c_double):
        yield (f"refused = refused || {part.definition.block.__name__}__step(&{part.block}, calls[{number}].time + "
               f"(double)k * calls[{number}].time_stride, calls[{number}].size) != 0;")
        return
    _, references, count, _ = call.arguments
    variables = [part.definition.native_variables[reference] for reference in references[:count.value]]
    item = "int32_t" if variables[0].boolean else "double"
    getting = any(c_function(call) is function for function in fmu.get_functions.values())
    yield "{"
    yield (f"    {'' if getting else 'const '}{item} *row = ({'' if getting else 'const '}{item} *)"
           f"(calls[{number}].row + (k - origin) * calls[{number}].stride);")
    for column, variable in enumerate(variables):
        if getting:
            yield f"    row[{column}] = {part.value(variable)};"
            continue
        low, high = (bound if given is None else float(given)
                     for bound, given in ((-inf, variable.minimum), (inf, variable.maximum)))
        if not variable.boolean:   # as set_reals of variables.c has it
            yield f"    refused = refused || !(row[{column}] >= {literal(low)} && row[{column}] <= {literal(high)});"
        yield f"    {part.value(variable)} = row[{column}]{' != 0' if variable.boolean else ''};"
    yield "}"


def indented(lines: Iterable[str], by: int) -> str:
    """Lines in a function."""
    return "\n".join(" " * by + line for line in lines)
