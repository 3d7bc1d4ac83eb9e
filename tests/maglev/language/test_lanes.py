"""Blocks in lanes have the bits of single ones, whatever they differ in, and fail by themselves."""

import shutil
import subprocess
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from lane_programs import LaneProgram, c_program, states, vary
from random_programs import CLASSES, write_program
from written_blocks import load_module

from maglev.language.lanes import LanesText
from maglev.language.program import FLOAT, Untranslatable
from maglev.language.statements import Program

STEPS = 4
BLOCKS = 5   # so that the last lanes of 2, 4 and 8 have none
WIDTHS = (1, 2, 4, 8)
ATTRIBUTES = ("a", "b", "struct", "i", "j", "int64_t", "on", "off", "xs", "ks", "x", "k", "double")
SANITIZED = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")


def blocks_of(text: str, number: int, folder: Path, random: Random, attributes: set[str]) -> list[object]:
    made = [getattr(load_module(folder, text, f"program_{number}.py"), f"Block_{number}")() for _ in range(BLOCKS)]
    for lane, block in enumerate(made):
        vary(block, random, attributes, lane)
    return made


def printed(programs: list[LaneProgram], folder: Path, options: list[str]) -> dict[str, list[str]]:
    (folder / "lanes.c").write_text(c_program(programs), encoding="utf-8")
    subprocess.run(["gcc", "-std=c99", "-w", "-ffp-contract=off", *options, "lanes.c", "-o", "lanes", "-lm"],
                   cwd=folder, check=True, stderr=subprocess.DEVNULL)
    done = subprocess.run([folder / "lanes"], capture_output=True, text=True, timeout=60)
    assert not done.stderr, done.stderr[:4000]
    return states(done.stdout)


def check(random: Random, folder: Path, many: int, width: int, options: list[str]) -> None:
    programs: list[LaneProgram] = []
    while len(programs) < many:
        number = len(programs)
        attributes = {name for name in ATTRIBUTES if random.random() < 0.4}
        try:
            programs.append(LaneProgram(number, blocks_of(write_program(random, number), number, folder, random,
                                                          attributes), STEPS, width))
        except Untranslatable:
            continue
    found = printed(programs, folder, options)
    for program in programs:
        for k in range(BLOCKS):
            assert found[f"{program.number} lane {k}"] == found[f"{program.number} block {k}"]
    assert not [head for head in found if "unlike" in head]


@pytest.mark.parametrize("width", WIDTHS)
def test_random_programs_have_the_same_bits_in_lanes(width: int, tmp_path: Path) -> None:
    check(Random(width), tmp_path, 4, width, ["-O0"])


@pytest.mark.thorough
@given(st.integers(0, 2**64 - 1), st.sampled_from(WIDTHS))
@settings(max_examples=24, derandomize=True, deadline=None, database=None, phases=[Phase.generate],
          suppress_health_check=list(HealthCheck))
def test_many_random_programs_have_the_same_bits_in_lanes(seed: int, width: int) -> None:
    with TemporaryDirectory() as folder:
        check(Random(seed), Path(folder), 12, width, SANITIZED)


def own_program(body: str, folder: Path, number: int = 0) -> list[object]:
    """Blocks with a body of `step`, whose attribute i is 0, 1, …"""
    text = CLASSES.format(n=number, floats="1.0, 0.0, 0.0", wholes="0, 0, 0")
    body = body.replace("TABLE", f"TABLE_{number}")
    text += "    def step(self, t):\n" + "".join(f"        {line}\n" for line in body.splitlines())
    made = [getattr(load_module(folder, text, f"program_{number}.py"), f"Block_{number}")() for _ in range(BLOCKS)]
    for k, block in enumerate(made):
        block.i = k
    return made


# What lanes do apart: `a` and `on` are set from `i`, in which they differ.
BODIES = (
    "self.off = self.on == (self.i > 2)", "self.off = self.on != (self.i > 2)", "self.off = self.on & (self.i > 2)",
    "self.off = self.on | (self.i > 2)", "self.off = not self.on", "self.off = self.on and self.i > 2",
    "self.off = self.on or self.i > 2", "self.off = self.on and self.i > 0 and self.flip(self.a)",
    "self.off = self.on or self.flip(self.a) or self.flip(2.0)", "self.off = self.on and 6 // (self.i % 2) > 5",
    "self.off = self.on or 6 // (self.i % 2) > 5", "self.off = self.j == 0 and self.on",
    "self.off = self.j == 1 or self.on", "self.off = self.j == 1 and 6 // self.i > 2",
    "self.off = self.j == 0 or 6 // self.i > 2", "self.off = self.flip(t) and self.on",
    "self.off = self.b == 0.0 and self.j == 0", "self.off = self.b == 1.0 or self.shift(t) > 0.0",
    "self.b = self.a if self.on else 2.0", "self.b = self.shift(self.a) if self.on else self.a",
    "self.b = self.a if self.j == 0 else 2.0", "self.b = self.shift(self.a) if self.j == 0 else 2.0",
    "self.b = self.xs[self.i % 4] if self.on else self.xs[self.i]", "self.j = 7 if self.on else self.ks[self.i % 3]",
    "self.off = self.i < 2.5 <= self.a", "self.off = 1.5 > self.i", "self.off = self.j < t",
    "self.b = min(self.a, 0.25) - max(self.a, self.b)", "self.j = min(self.i, 2) - max(1, self.i)",
    "self.j = ~self.i - -self.i + abs(self.i - 2)", "self.j = (self.i << 2) + (self.i - 2) // 2 * 3 % 2",
    "self.j = (self.i - 2 >> 1) + (self.i ^ 5) - (self.i | 1) + (self.i & 6)", "self.j = 1 << self.i - 1",
    "self.j = 9223372036854775804 + self.i", "self.j = -9223372036854775806 - self.i",
    "self.j = 4611686018427387904 * self.i", "self.b = self.i / 3 + 1 / self.i", "self.b = self.a / (self.a + 0.5)",
    "self.b = sqrt(self.a + 0.5) + fabs(self.a)", "self.b = fmod(self.a, 0.3) - remainder(0.7, self.a + 0.1)",
    "self.j = floor(self.a * 1.5) + ceil(self.a * 1.5) * 8 + trunc(self.a * 1.5) * 64",
    "self.j = int(4503599627370497.5 * self.a) + int(9.0e18 * self.a)", "self.b = copysign(3.0, self.a)",
    "self.off = isfinite(1.0e308 * self.a * 10.0) == isnan(self.a) or isinf(self.a)",
    "self.b = float(self.on) + float(self.i)", "self.parts[self.i % 2].x = 4.0 + t",
    "self.parts[self.i % 2].double[1] += self.a", "part = self.parts[self.i % 2]\npart.x += part.take(1.0)",
    "part = self.parts[0] if self.on else self.parts[1]\npart.k = 2",
    "part = self.parts[0] if self.j == 0 else self.parts[1]\npart.x = self.a",
    "(self.parts[0] if self.on else self.parts[1]).x = 3.0", "part = self.parts[0]\nif self.on:\n"
    "    part = self.parts[1]\npart.k += 1", "rows = self.rows[self.i % 2]\nrows[0] = self.a + rows[1]",
    "rows = self.rows[0] if self.on else self.rows[1]\nself.b = rows[self.j]\nrows[0] = 9.0", "self.xs[self.i] = t",
    "self.xs[self.ks[self.i % 3]] += self.xs[self.i % 4]", "xs = self.xs\nxs[self.j] = self.a\nself.b = xs[1]",
    "for k in range(self.i):\n    self.b += self.xs[k]", "for k in range(self.i, 4):\n    self.b += float(k)",
    "for k in range(4, self.i, -2):\n    self.b = 2.0 * self.b + float(k)",
    "for k in range(4):\n    if k == self.i:\n        break\n    self.b += 1.0",
    "for k in range(4):\n    if k == self.i:\n        continue\n    self.b += float(k)\nself.j += 1",
    "for k in range(4):\n    if k == self.i:\n        return\n    self.b += self.shift(1.0)\nself.j += 1",
    "for k in range(self.i):\n    for m in range(k, 3):\n        if m == 2:\n            break\n"
    "        self.b += 1.0\n    self.j += 1",
    "while self.i < 3:\n    self.i += 1\n    self.b += self.shift(1.0)",
    "n = 0\nwhile True:\n    n += 1\n    if n > self.i:\n        break\n    if n == 2:\n        continue\n"
    "    self.b += self.a\nself.j = n", "n = 0\nwhile n < 3:\n    n += 1\n    self.b += 1.0",
    "n = 4\nwhile n > self.i and self.flip(t):\n    n -= 1\nself.j = n",
    "if self.i > 1:\n    return\nself.b = 2.0", "if self.i > 1:\n    return\nfor k in range(3):\n    self.b += 1.0",
    "if self.on:\n    self.b = self.shift(self.a)\nelse:\n    self.b, self.j, self.off = self.both(self.a, 2)",
    "self.b, self.j, self.off = self.both(self.a, self.i)", "x, y = 1.0, self.a\nif self.on:\n    x, y = y, x\n"
    "self.b, self.struct = x, y", "x = t\nfor k in range(3):\n    if k < self.i:\n        x += 1.0\nself.b = x",
    "for part in self.parts:\n    if part.x > self.a:\n        part.x = self.a",
    "n = 0\nif self.on:\n    n = 3\nelif self.i > 2:\n    n = 1\nself.j = n", "self.j = self.bump(self.i)",
    "self.on = any(each > self.a for each in self.xs)", "self.on = all(one.x < self.a for one in self.parts)",
    "if self.j == 0:\n    self.b = self.a\nelse:\n    self.b = 1.0", "self.b = self.at(self.i - 4)",
    "self.b = self.above(self.a, self.i)",
    "self.b, self.off = self.limited(self.a + 1.0)",
    "if self.on:\n    self.b = self.above(self.a, 3)",
    "if self.on:\n    self.b, self.off = self.limited(self.a + 1.0)",
    "self.b = self.above(self.parts[self.i % 2].x, 2)",
    "x = 1.0\nif self.on:\n    x = 2.0\nself.b = x if self.i > 2 else 0.5",
    "self.b = self.shift(self.a) + self.a if self.on else self.shift(2.0) - self.a",
    "self.b = self.side(self.a)", "self.struct = self.climb(self.a)", "self.b = self.side(t) + self.a",
    "self.both(self.a, self.i)", "while self.b < 3.0:\n    self.b += 1.0\nself.struct = self.a + self.b",
    "while (self.parts[0] if self.off else self.parts[1]).x < 3.0:\n    self.parts[0].x += 1.0\n"
    "    self.parts[1].x += 1.0", "while any(each > self.b + 8.0e9 for each in self.xs):\n    self.b += 1.0e9",
    "self.put(self.xs, self.i % 4, self.a)", "self.put(self.rows[self.i % 2], 1, self.a)\nself.put(self.xs, 2, t)",
    "self.b = self.larger(TABLE) + self.a", "self.parts[0].double[1] = self.a\nself.b = self.chosen(TABLE)",
    "self.put(self.rows[0], 1, self.a)\nself.b = self.larger(self.rows[0]) + self.larger(self.xs)")


def test_lanes_apart_have_the_same_bits(tmp_path: Path) -> None:
    first = "self.a = 0.5 * float(self.i) - 1.0\nself.on = self.i % 2 == 0\n"
    programs = [LaneProgram(number, own_program(first + body, tmp_path, number), STEPS, 4)
                for number, body in enumerate(BODIES)]
    found = printed(programs, tmp_path, ["-O0"])
    wrong = {BODIES[number] for number in range(len(BODIES)) for k in range(BLOCKS)
             if found[f"{number} lane {k}"] != found[f"{number} block {k}"]}
    assert not wrong
    assert len({tuple(found[f"{number} block {k}"]) for number in range(len(BODIES)) for k in range(BLOCKS)}) > 200


def test_lanes_fail_by_themselves(tmp_path: Path) -> None:
    """A division by zero in step i, an index outside its list in step 2 of the last one."""
    blocks = own_program("n = 10 // (self.i - int(8.0 * t))\nself.a += self.xs[self.i % 4] / float(n + 20)", tmp_path)
    found = printed([LaneProgram(0, blocks, STEPS, 4)], tmp_path, ["-O0"])
    for k in range(BLOCKS):
        assert found[f"0 lane {k}"] == found[f"0 block {k}"]
        assert len(found[f"0 lane {k}"]) == min(k + 1, STEPS)
        assert ("refused" in found[f"0 lane {k}"]) == (k < STEPS)


def varying_in(body: str, folder: Path) -> set[str]:
    blocks = own_program(body, folder)
    program = Program(blocks[0])
    text = LanesText(program.layout, [program.method("step", (FLOAT,))], {("Block_0", "i")}, 4)
    return {name for struct, name in text.varying if struct == "Block_0"}


def test_only_what_follows_from_a_difference_is_a_vector(tmp_path: Path) -> None:
    assert varying_in("self.a = self.b + t\nif self.j > 0:\n    self.on = False", tmp_path) == {"i"}
    assert varying_in("self.a = self.b + float(self.i)\nself.struct = self.a", tmp_path) == {"i", "a", "struct"}
    assert varying_in("if self.i > 2:\n    self.b = 1.0\nself.a = 2.0", tmp_path) == {"i", "b"}
    assert varying_in("if self.i > 2:\n    return\nself.a = 2.0", tmp_path) == {"i", "a"}
    assert varying_in("xs = self.xs\nself.a = xs[self.j]\nxs[0] = 2.0", tmp_path) == {"i"}
    assert varying_in("x = 1.0\nif self.i > 2:\n    x = 2.0\nself.b = x", tmp_path) == {"i", "b"}
