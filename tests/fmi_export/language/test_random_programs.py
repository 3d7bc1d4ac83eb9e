"""Random blocks compute the same in Python and as C, bit for bit, or both refuse the same step."""

import re
import shutil
import subprocess
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from random_programs import Writer, run
from written_blocks import load_module

from fmi_export.language.c_text import CText
from fmi_export.language.layout import Layout
from fmi_export.language.names import identifier
from fmi_export.language.program import FLOAT, List, Struct, Type, Untranslatable
from fmi_export.language.statements import Program

STEPS = 4
BATCH = 24
HEAD = """\
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

static void show_float(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    if (isnan(x)) printf("nan "); else printf("%016" PRIx64 " ", bits);
}

static void show_whole(int64_t x) { printf("%" PRId64 " ", x); }

"""
COMPILERS = {"O0": ["-O0"], "O2, sanitizers": ["-O2", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]}


def shows(layout: Layout, kind: Type, place: str) -> list[str]:
    if isinstance(kind, Struct):
        return [line for name, part in layout.fields[kind.name].items()
                for line in shows(layout, part, f"{place}.{identifier(name)}")]
    if isinstance(kind, List):
        assert kind.item is not None
        return [line for k in range(kind.length) for line in shows(layout, kind.item, f"{place}[{k}]")]
    return [f"show_{'float' if kind == FLOAT else 'whole'}({place});"]


def c_of(programs: dict[int, str], folder: Path) -> str:
    """A C program that prints for each program its number, and its states in lines."""
    parts, main, helpers = [], [], set[str]()
    for number, written in programs.items():
        block = getattr(load_module(folder, written, f"program_{number}.py"), f"Block_{number}")()
        program = Program(block)
        text = CText(program.layout, [program.method("step", (FLOAT,))])
        step, = (each for each in text.functions if each.name == f"Block_{number}__step")
        parts += [text.structs(), text.constants(), text.code, "static " + text.initial(block, f"INITIAL_{number}")]
        helpers |= text.helpers
        main += [f"    {{ struct Block_{number} block = INITIAL_{number};", f"      puts(\"program {number}\");",
                 f"      for (int k = 0; k < {STEPS}; ++k) {{", "        int64_t failure = 0;",
                 f"        {step.name}(&block, 0.125 * k{', &failure' if step.fails else ''});",
                 "        if (failure != 0) { puts(\"refused\"); break; }",
                 *shows(program.layout, program.layout.root, "block"), "        puts(\"\"); } }"]
    text.helpers = helpers
    return "\n".join([HEAD, text.helper_code(), *parts, "int main(void)\n{", *main, "    return 0;\n}\n"])


def check(random: Random, folder: Path) -> None:
    programs = dict[int, str]()
    while len(programs) < BATCH:
        number = len(programs)
        programs[number] = Writer(random, number).program()
        try:
            c_of({number: programs[number]}, folder)
        except Untranslatable as error:   # the one reason that such a program can have
            assert re.search(r"element -?\d+ of a list of", str(error))
            del programs[number]
    expected = {number: run(text, number, STEPS) for number, text in programs.items()}
    (folder / "programs.c").write_text(c_of(programs, folder), encoding="utf-8")
    for name, options in COMPILERS.items():
        subprocess.run(["gcc", "-std=c99", "-w", "-ffp-contract=off", *options, "programs.c", "-o", "programs", "-lm"],
                       cwd=folder, check=True)
        done = subprocess.run([folder / "programs"], capture_output=True, text=True, timeout=60)
        assert not done.stderr, done.stderr[:4000]
        found = {int(each.split("\n")[0]): [line.strip() for line in each.splitlines()[1:]]
                 for each in done.stdout.split("program ")[1:]}
        for number, states in expected.items():
            assert found[number] == states, f"{name}:\n{programs[number].partition('def step')[2]}"


seeds = st.integers(0, 2**64 - 1)   # a program takes more decisions than hypothesis keeps of an example


def settings_of(examples: int) -> settings:
    return settings(max_examples=examples, derandomize=True, deadline=None, database=None, phases=[Phase.generate],
                    suppress_health_check=list(HealthCheck))


@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")
@given(seeds)
@settings_of(2)
def test_random_programs_agree_in_python_and_c(seed: int) -> None:
    with TemporaryDirectory() as folder:
        check(Random(seed), Path(folder))


@pytest.mark.thorough
@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")
@given(seeds)
@settings_of(60)
def test_many_random_programs_agree_in_python_and_c(seed: int) -> None:
    with TemporaryDirectory() as folder:
        check(Random(seed), Path(folder))
