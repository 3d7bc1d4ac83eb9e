"""What fails in the C, and the message that says so: Python raises there, or has a number that C has no room for."""

import shutil
import subprocess
from pathlib import Path

import pytest
from written_blocks import load_block

from maglev.language.c_text import CText
from maglev.language.statements import Program

HEAD = "#include <math.h>\n#include <stdbool.h>\n#include <stdint.h>\n#include <stdio.h>\n\n"
LARGE, SMALL = "self.large", "self.small"   # 2^63 − 1 and −2^63
NONE, ZERO, BEYOND, SHIFT = "", "division by zero", "a whole number beyond 2^63", "a shift by less than 0"

# Expressions with their messages, in a block with nought = 0, one = 1 and minus = −1, and 0.0, 1.0 and −1.0 as x, y, z.
CASES = {
    f"{LARGE} + self.one": BEYOND, f"{SMALL} + self.minus": BEYOND, f"{LARGE} + self.minus": NONE,
    f"{SMALL} - self.one": BEYOND, f"{LARGE} - self.minus": BEYOND, f"{SMALL} - self.minus": NONE,
    "self.nought - self.small": BEYOND, "-self.small": BEYOND, "-self.large": NONE, "abs(self.small)": BEYOND,
    "abs(self.large)": NONE, f"{LARGE} * 2": BEYOND, f"{SMALL} * self.minus": BEYOND, f"{SMALL} * self.one": NONE,
    f"self.minus * {SMALL}": BEYOND, f"{LARGE} * self.minus": NONE, f"{LARGE} * self.nought": NONE,
    "4294967296 * self.one * -2147483648": NONE, "4294967296 * self.one * 2147483648": BEYOND,
    "self.one // self.nought": ZERO, f"{SMALL} // self.minus": BEYOND, f"{SMALL} // -1": BEYOND,
    f"{LARGE} // self.minus": NONE, "self.one // 0": ZERO, "self.one % self.nought": ZERO,
    f"{SMALL} % self.minus": NONE,
    f"{SMALL} % -1": NONE, "self.one << self.minus": SHIFT, "self.one << 63": BEYOND, "self.one << 62": NONE,
    "self.minus << 63": NONE, "self.nought << 64": NONE, f"{LARGE} << self.one": BEYOND,
    "self.nought << self.minus": SHIFT,
    "self.one >> self.minus": SHIFT, "self.one >> 64": NONE, "self.one / self.nought": ZERO, "self.y / self.x": ZERO,
    "self.one / 0": ZERO, "self.y / 0.0": ZERO,
    "self.x / self.y": NONE, "sqrt(self.z)": "sqrt has no result", "sqrt(self.x)": NONE,
    "log(self.x)": "log has no result", "exp(self.y * 999.0)": "exp has no result",
    "int(self.y * 9223372036854775808.0)": f"{BEYOND}, or no number",
    "int(self.z * 9223372036854775808.0)": NONE, "floor(self.y / 0.1e-300 * 1e9)": f"{BEYOND}, or no number",
    "self.three[3 * self.one]": "no such element of a list of 3", "self.three[-3 * self.one]": NONE,
    "self.three[-4 * self.one]": "no such element of a list of 3", "self.three[2 * self.one]": NONE}
BLOCK = """\
from math import exp, floor, log, sqrt


class Tank:
    def __init__(self):
        self.large, self.small = 2**63 - 1, -2**63
        self.nought, self.one, self.minus = 0, 1, -1
        self.x, self.y, self.z = 0.0, 1.0, -1.0
        self.three = [1.0, 2.0, 3.0]

"""


@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")
def test_failures_give_their_reason(tmp_path: Path) -> None:
    methods = "".join(f"    def case_{k}(self):\n        return {case}\n\n" for k, case in enumerate(CASES))
    block = load_block(tmp_path, BLOCK + methods, "Tank")
    program = Program(block)
    functions = [program.method(f"case_{k}") for k in range(len(CASES))]
    text = CText(program.layout, functions)
    calls = [f"    failure = 0; (void){each.name}(&block{', &failure' if each.fails else ''}); "
             'printf("%d ", (int)failure);' for each in functions]
    (tmp_path / "cases.c").write_text(
        "\n".join([HEAD, text.structs(), text.functions_text(), "static " + text.initial(block, "INITIAL"),
                   "int main(void)\n{\n    struct Tank block = INITIAL;\n    int64_t failure;", *calls,
                   "    return 0;\n}\n"]),
        encoding="utf-8")
    subprocess.run(["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-fsanitize=undefined",
                    "-fno-sanitize-recover=all", "-ffp-contract=off", "cases.c", "-o", "cases", "-lm"], cwd=tmp_path,
                   check=True)
    printed = subprocess.run([tmp_path / "cases"], capture_output=True, text=True, check=True).stdout
    found = ["" if number == "0" else program.sites[int(number) - 1].text for number in printed.split()]
    said = {case: text.partition(": ")[2] for case, text in zip(CASES, found, strict=True)}
    assert said == CASES
    first = BLOCK.count("\n") + 2
    assert {text.partition(": ")[0] for text in found if text} == {
        f"tank.py, line {first + 3 * k}" for k, message in enumerate(CASES.values()) if message}


@pytest.mark.parametrize("case", CASES)
def test_python_raises_or_goes_beyond_64_bits(case: str, tmp_path: Path) -> None:
    block = load_block(tmp_path, f"{BLOCK}    def step(self):\n        return {case}\n", "Tank")
    fails = False
    try:
        value = block.step()
        fails = isinstance(value, int) and not -2**63 <= value < 2**63
    except (ArithmeticError, ValueError, IndexError):
        fails = True
    assert fails == bool(CASES[case])
