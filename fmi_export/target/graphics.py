"""C as PTX, the text of which the driver of a graphics processor makes its code."""

import re
from collections.abc import Mapping

from fmi_export.native.compiler import UNIT, compiled, in_one_unit
from fmi_export.target.freestanding import template

# Of NVIDIA, from compute capability 8.0 on. A call puts blocks into memory: all that takes one becomes part of the
# kernel, also what is seldom called, or what the compiler takes to be so. So does a place that is computed: branches
# that read several are not merged into one that reads either.
FLAGS = ("-target", "nvptx64-cuda", "-mcpu=sm_80", "-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno",
         "-Dnoinline=always_inline", "-fno-sanitize=all", "-ffreestanding", "-g0", "-I.",
         "-mllvm", "-inline-threshold=1000000", "-mllvm", "-inline-cold-callsite-threshold=1000000",
         "-mllvm", "-sink-common-insts=false", "-S")

# What takes and gives but a number, in registers, is called: sines and their like are in a kernel once, not at each of
# some 40 places, and the driver compiles half of the code.
OF_A_NUMBER = re.compile(r"^static (?=double \w+\(double \w+\)$)", re.MULTILINE)
CALLED = "static __attribute__((unused, __noinline__)) "   # `noinline` is a macro above


def in_one_rounding(sources: Mapping[str, str]) -> dict[str, str]:
    """C files by name as they are compiled, and headers in place of a library's.

    Operations round as those of other processors: none is contracted, approximate, or a library's.
    """
    headers = {"math.h": template("arithmetic.h"), "stdlib.h": ""}
    return {**{file: OF_A_NUMBER.sub(CALLED, text) for file, text in sources.items()}, **headers}


def ptx(files: Mapping[str, str], name: str) -> bytes:
    """PTX of such files, of blocks and a kernel over them; `name` is its file name's stem.

    ExportError of the compiler.
    """
    with in_one_unit(files, name) as root:
        compiled(root, [*FLAGS, "-o", f"{name}.ptx", UNIT.format(name)])
        return (root / f"{name}.ptx").read_bytes()
