"""Closed loops as code for a graphics processor: it is made, and read for what would change a bit; nothing runs it.

A run has the bits of other processors where each operation rounds once, to the nearest, and none becomes part of
another: what is marked so (`.rn`) the driver leaves as it is.
"""

import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from native_builds import built_once, require_native_tools

from fmi_export.native.build import translated_blocks
from fmi_export.native.translation import files_of
from fmi_export.sources import carried_modules
from fmi_export.target.freestanding import template
from maglev.own_fmus import definition
from maglev.packages import PACKAGES

NAMES = ("ClosedLoop2DOF", "ClosedLoop3DOF", "ClosedLoop5DOF")

# Rounded once, to the nearest; comparisons, signs, choices; conversions from and to whole numbers, and numbers without
# their fraction.
EXACT = {*(f"{each}.rn.f64" for each in ("add", "sub", "mul", "div", "rcp", "sqrt")), "neg.f64", "abs.f64", "min.f64",
         "max.f64", "setp.f64", "selp.f64", "cvt.rn.f64.s64", "cvt.rn.f64.u64", "cvt.rn.f64.s32", "cvt.rn.f64.u32",
         "cvt.rzi.s64.f64", "cvt.rzi.s32.f64", "cvt.rzi.f64.f64"}

# One loop a thread, as many steps as are asked for.
KERNEL = """
#include "{module}.h"

__attribute__((device_kernel)) void fly(struct {name} *loops, int *statuses, int steps, double step)
{{
    int thread = __nvvm_read_ptx_sreg_ctaid_x() * __nvvm_read_ptx_sreg_ntid_x() + __nvvm_read_ptx_sreg_tid_x();
    struct {name} *loop = &loops[thread];
    {name}__init__(loop{arguments});
    statuses[thread] = (int){name}__start(loop);
    for (int k = 0; k < steps && !statuses[thread]; ++k) {{
        statuses[thread] = (int){name}__step(loop, k * step, step);
    }}
}}
"""


@pytest.fixture(scope="module")
def sources(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a folder of C for each loop, with what stands in for a library's headers."""
    require_native_tools()

    def make(folder: Path) -> None:
        chosen = [definition(name) for name in NAMES]
        translation = translated_blocks(chosen, PACKAGES)
        for each in chosen:
            module = each.block.__module__
            files = files_of(carried_modules(module, PACKAGES), translation)
            units = "".join(f'#include "{file}"\n' for file in sorted(files) if file.endswith(".c"))
            kernel = KERNEL.format(module=module.rpartition(".")[2], name=each.block.__name__,
                                   arguments="".join(f", {argument}" for argument in each.arguments))
            (folder / each.name).mkdir()
            for file, text in {**files, "prefix.h": "", "math.h": template("arithmetic.h"), "stdlib.h": "",
                               "it.c": units + kernel}.items():
                (folder / each.name / file).write_text(text, encoding="utf-8")

    return built_once(tmp_path_factory, "graphics_processor", make)


def made(sources: Path, contraction: str) -> str:
    """Code of a loop for a processor of NVIDIA, as the text that its driver takes."""
    done = subprocess.run([
        sys.executable, "-m", "ziglang", "cc", "-target", "nvptx64-cuda", "-mcpu=sm_80", "-O3", "-std=c99",
        f"-ffp-contract={contraction}", "-fno-math-errno", "-fno-sanitize=all", "-ffreestanding",
        "-DBLOCKS_IN_ONE_UNIT", "-I.", "-S", "it.c", "-o", "it.ptx"], cwd=sources, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    return (sources / "it.ptx").read_text(encoding="utf-8")


def of_numbers(code: str) -> Counter[str]:
    """How often each instruction that computes with floating-point numbers, or compares them, is in it."""
    found = re.findall(r"^\s+(?:@\S+\s+)?([a-z]\w*\.\S*\bf(?:16|32|64)\b\S*)", code, re.MULTILINE)
    return Counter(re.sub(r"^setp\.\w+\.", "setp.", each) for each in found)


@pytest.mark.parametrize("name", NAMES)
def test_it_rounds_as_other_processors_do(sources: Path, name: str) -> None:
    """Nothing is contracted, approximate, flushed to zero or in single precision; nothing is asked of a library."""
    code = made(sources / name, "off")
    found = of_numbers(code)
    assert found.keys() <= EXACT, found.keys() - EXACT
    assert min(found[f"{each}.rn.f64"] for each in ("add", "sub", "mul", "div", "sqrt")) > 0
    assert ".visible .entry fly(" in code and ".extern" not in code
    called = set(re.findall(r"^\s+call(?:\.uni)? (?:\([^)]*\), )?([\w$]+), ", code, re.MULTILINE))
    assert len(re.findall(r"^\s+call", code, re.MULTILINE)) >= len(called) > 0
    assert called <= set(re.findall(r"^\.func +(?:\([^)]*\) )?([\w$]+)\($", code, re.MULTILINE))


def test_contraction_would_be_seen(sources: Path) -> None:
    assert of_numbers(made(sources / NAMES[0], "fast"))["fma.rn.f64"] > 100
