"""The limit of a native co-simulation: controller and plant block, translated to C, all of it inlined into one C loop.

The loop does what a master does: references, measurements, controller, currents, plant, and a record of every output.
"""

import ctypes
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import Any

from loops import PAIRS, PHASES, Pair, outputs, place

from fmi_export.definition import FmuDefinition
from fmi_export.native.build import PREFIX, host_platform, translated_blocks
from fmi_export.native.compiler import INLINED
from fmi_export.native.compiler import library as compile_library
from fmi_export.native.prefix import prefix_header
from fmi_export.native.shells import SHELLS
from fmi_export.native.translation import files_of, literal
from fmi_export.sources import carried_modules
from maglev.own_fmus import definition
from maglev.packages import PACKAGES

LOOP = """\
#include "{controller_header}"
#include "{plant_header}"

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

EXPORT int run(int steps, double dt, const double *references, double *record)
{{
    struct {controller} controller;
    struct {plant} plant;
    {controller}__init__(&controller{arguments});
    {plant}__init__(&plant);
    if ({controller}__start(&controller) || {plant}__start(&plant)) {{
        return 1;
    }}
    for (int k = 0; k < steps; ++k) {{
{before}
        if ({controller}__step(&controller, k * dt, dt)) {{
            return 2;
        }}
{between}
        if ({plant}__step(&plant, k * dt, dt)) {{
            return 3;
        }}
{after}
    }}
    return 0;
}}
"""


def c_loop(pair: Pair, steps: int) -> Callable[[], float]:
    """Measurement of the time of one step of a pair's loop, s; references are constant."""
    controller, plant = definition(pair.controller), definition(pair.plant)
    texts = {**carried_modules(controller.block.__module__, PACKAGES),
             **carried_modules(plant.block.__module__, PACKAGES)}
    recorded = [f"{name}.{output}" for name, fmu in (("controller", controller), ("plant", plant))
                for output in outputs(fmu)]
    before = [f"controller.{axis}.reference = references[{i}];" for i, axis in enumerate(pair.rig.axis_names)]
    before += [f"controller.{place(controller, to)} = plant.{place(plant, source)};" for source, to in pair.measured]
    between = [f"plant.{motor}.{phase} = controller.{motor}.{phase};" for motor in pair.rig.motor_names
               for phase in PHASES]
    after = [f"*record++ = {each};" for each in recorded]
    arguments = "".join(f", {literal(argument)}" for argument in controller.arguments)
    source = LOOP.format(
        controller=controller.block.__name__, controller_header=header(controller), plant=plant.block.__name__,
        plant_header=header(plant), arguments=arguments, before=indented(before), between=indented(between),
        after=indented(after))
    platform = next(iter(host_platform().values()))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"loop{platform.ending}"
        blocks = files_of(texts, all_blocks())
        headers = [text for name, text in blocks.items() if name.endswith(".h")]
        prefix = prefix_header("loop", headers, SHELLS[2].headers[0])
        path.write_bytes(compile_library({**blocks, PREFIX: prefix, "loop.c": source}, "loop", platform, INLINED))
        library = ctypes.CDLL(str(path))
    return timed_loop(library["run"], pair, steps, len(recorded))


def timed_loop(run: Any, pair: Pair, steps: int, outputs: int) -> Callable[[], float]:
    """Measurement of the time of one step of a loop in C with so many outputs, s."""
    run.argtypes = [ctypes.c_int, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p]
    record = (ctypes.c_double * (steps * outputs))()
    given = (ctypes.c_double * len(pair.starts))(*pair.starts)

    def measure() -> float:
        begin = perf_counter()
        if run(steps, pair.dt, given, record) != 0:
            sys.exit("the C loop was refused a step")
        return (perf_counter() - begin) / steps

    return measure


@cache
def all_blocks() -> dict[str, str]:
    """C files by name of the blocks of all pairs: pyccel takes longer to start than to translate one."""
    return translated_blocks([definition(name) for pair in PAIRS for name in (pair.controller, pair.plant)], PACKAGES)


def header(fmu: FmuDefinition) -> str:
    """Header of an FMU's block."""
    return f"{import_module(fmu.block.__module__).__name__.rpartition('.')[2]}.h"


def indented(lines: Sequence[str]) -> str:
    """Lines inside the loop."""
    return "\n".join(f"        {line}" for line in lines)
