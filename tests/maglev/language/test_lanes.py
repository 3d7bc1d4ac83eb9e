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
from random_programs import CLASSES, Writer
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
            programs.append(LaneProgram(number, blocks_of(Writer(random, number).program(), number, folder, random,
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


def own_program(body: str, folder: Path) -> list[object]:
    """Blocks with a body of `step`, whose attribute i is 0, 1, …"""
    text = CLASSES.format(n=0, floats="1.0, 0.0, 0.0", wholes="0, 0, 0")
    text += "    def step(self, t):\n" + "".join(f"        {line}\n" for line in body.splitlines())
    made = [load_module(folder, text, "program_0.py").Block_0() for _ in range(BLOCKS)]
    for k, block in enumerate(made):
        block.i = k
    return made


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
    assert varying_in("x = 1.0\nif self.i > 2:\n    x = 2.0\nself.b = x", tmp_path) == {"i", "b"}
