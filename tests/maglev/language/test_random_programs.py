"""Random blocks compute the same in Python and as C, bit for bit, or both refuse the same step."""

import re
import shutil
import subprocess
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from textwrap import indent

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from random_programs import CLASSES, run, write_program
from written_blocks import load_module

from maglev.language.c_text import CText
from maglev.language.constants import constant_attributes
from maglev.language.layout import Layout
from maglev.language.names import identifier
from maglev.language.program import FLOAT, List, Struct, Type, Untranslatable, functions_of
from maglev.language.statements import Program

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
        step = program.method("step", (FLOAT,))
        text = CText(program.layout, [step], constant_attributes(program.layout, block, functions_of([step]), ())
                     if number % 2 else {})
        own = re.sub(r"\b\w+__\d+\b", rf"\g<0>_of_{number}", text.constants() + text.code)   # constant lists
        parts += [text.structs(), own, "static " + text.initial(block, f"INITIAL_{number}")]
        helpers |= text.helpers
        main += [f"    {{ struct Block_{number} block = INITIAL_{number};", f"      puts(\"program {number}\");",
                 f"      for (int k = 0; k < {STEPS}; ++k) {{", "        int64_t failure = 0;",
                 f"        {step.name}(&block, 0.125 * k{', &failure' if step.fails else ''});",
                 "        if (failure != 0) { puts(\"refused\"); break; }",
                 *shows(program.layout, program.layout.root, "block"), "        puts(\"\"); } }"]
    text.helpers = helpers
    return "\n".join([HEAD, text.helper_code(), *parts, "int main(void)\n{", *main, "    return 0;\n}\n"])


# Bodies of `step` with the number of steps that are not refused: what runs in which order, and exact numbers.
BODIES = {
    "self.i = 0\nself.xs[self.bump(1) % 4] = self.a": STEPS,
    "self.i = 0\nself.xs[self.bump(1) % 4] += 1.0": STEPS,
    "self.i = 0\nself.ks[self.i % 3] += self.bump(1)": STEPS,
    "self.i = 0\nself.parts[self.i % 2].x = float(self.bump(1))": STEPS,
    "self.i = 0\nself.parts[self.i % 2].double[self.bump(1) % 3] = 7.0": STEPS,
    "self.j = 0\nself.parts[self.j].x, n, self.off = self.both(2.0, 1)": STEPS,
    "n = 1\nself.xs[n], n, _ = self.both(2.0, 3)\nself.i = n": STEPS,
    "self.i = 3\nself.xs[self.i], self.i = self.parts[0].pair(2.0)": STEPS,
    "self.i = 0\nfor each in self.rows[self.i % 2]:\n    self.i += 1\n    self.b = each": STEPS,
    "self.on = 9.0e300 < t < float(self.bump(1))": STEPS,
    "self.on = 2 < 1 < self.ks[self.j * 0 + 100] < 3": STEPS,
    "self.i = 0\nself.j = abs(self.bump(1))": STEPS,
    "self.j = 0\nself.a = 1.0\nself.b = sqrt(self.shift(4.0))": STEPS,
    "n = 9007199254740993\nself.on = n == 9007199254740992.0\nself.b = n / 3": STEPS,
    "self.j = int(-9223372036854775808.0)\nself.i = -1 << 63": STEPS,
    "n = 9223372036854775803\nself.i = 0\nfor k in range(n, n + 4, 3):\n    self.i += 1": STEPS,
    "n = -9223372036854775806\nself.i = 0\nfor k in range(n, n - 2, -9):\n    self.i += 1": STEPS,
    "self.i = 0\nfor k in range(9223372036854775800, 9223372036854775807, 5):\n    self.i += 1": STEPS,
    "self.i = 0\nfor k in range(1, 9, 3):\n    self.i += k\nfor k in range(7, 2, -2):\n    self.i += 10 * k": STEPS,
    "n = 9007199254740995\nself.a = n / 2\nself.b = -n / 4\nself.i = int(n)": STEPS,
    "self.a = radians(0.1 + t) + degrees(t)": STEPS,
    "self.both(2.0, 1)\nif t > 0.1:\n    pass\nelse:\n    self.i = 2": STEPS,
    "while self.b < 4.0 + t:\n    self.b += 1.0\nreturn\nself.i = 3": STEPS,
    "self.relay(t)\nself.a = math.pi * self.leading()": STEPS,
    "self.a = self.side(t - 0.1)\nself.b = 0.0\nself.struct = self.climb(2.0 * t)": STEPS,
    "self.b = self.shift(1.0) + self.a if t > 0.1 else self.shift(2.0) - self.a": STEPS,
    "part = self.parts[self.bump(1) % 2] if t > 0.1 else self.parts[0]\npart.x = t": STEPS,
    "for k in range(2):\n    self.a = self.xs[k]\nn = 9\nfor k in range(n):\n    self.b = self.xs[k]": 0,
    "for k, each in enumerate(self.xs):\n    self.a = each\nfor k in range(2):\n    self.b = self.xs[k + 3]": 0,
}


def with_body(body: str, number: int) -> str:
    """A program whose `step` has a body."""
    zeros = {"floats": "0.0, 0.0, 0.0", "wholes": "0, 0, 0"}
    return f"{CLASSES.format(n=number, **zeros)}    def step(self, t):\n{indent(body, ' ' * 8)}\n"


def wrong_programs(programs: dict[int, str], folder: Path) -> dict[int, str]:
    """Programs that differ between Python and C, with the compiler's options."""
    expected = {number: run(text, number, STEPS) for number, text in programs.items()}
    (folder / "programs.c").write_text(c_of(programs, folder), encoding="utf-8")
    wrong: dict[int, str] = {}
    for name, options in COMPILERS.items():
        subprocess.run(["gcc", "-std=c99", "-w", "-ffp-contract=off", *options, "programs.c", "-o", "programs", "-lm"],
                       cwd=folder, check=True)
        done = subprocess.run([folder / "programs"], capture_output=True, text=True, timeout=60)
        assert not done.stderr, done.stderr[:4000]
        states = {int(each.split("\n")[0]): [line.strip() for line in each.splitlines()[1:]]
                  for each in done.stdout.split("program ")[1:]}
        wrong |= {number: name for number in programs if states[number] != expected[number]}
    return wrong


def check(random: Random, folder: Path) -> None:
    programs = dict[int, str]()
    while len(programs) < BATCH:
        number = len(programs)
        programs[number] = write_program(random, number)
        try:
            c_of({number: programs[number]}, folder)
        except Untranslatable as error:   # the one reason that such a program can have
            assert re.search(r"element -?\d+ of a list of", str(error))
            del programs[number]
    wrong = wrong_programs(programs, folder)
    shown = [f"{name}:\n{programs[number].partition('def step')[2]}" for number, name in wrong.items()]
    assert not shown, "\n".join(shown)


seeds = st.integers(0, 2**64 - 1)   # a program takes more decisions than hypothesis keeps of an example


def settings_of(examples: int) -> settings:
    return settings(max_examples=examples, derandomize=True, deadline=None, database=None, phases=[Phase.generate],
                    suppress_health_check=list(HealthCheck))


@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")
def test_order_of_evaluation_is_that_of_python(tmp_path: Path) -> None:
    programs = dict(enumerate(map(with_body, BODIES, range(len(BODIES)))))
    for (number, text), states in zip(programs.items(), BODIES.values(), strict=True):
        assert len([state for state in run(text, number, STEPS) if state != "refused"]) == states
    wrong = wrong_programs(programs, tmp_path)
    assert not [list(BODIES)[number] for number in wrong]


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
