"""The page on the language: its block is one, its messages are those that users see."""

import re
from collections.abc import Iterator
from pathlib import Path
from textwrap import dedent

import pytest
from written_blocks import load_module

from maglev.language.c_text import CText
from maglev.language.program import FLOAT, INT, Untranslatable
from maglev.language.statements import Program

PAGE = (Path(__file__).parents[3] / "docs" / "language.md").read_text(encoding="utf-8")


def indented() -> Iterator[str]:
    for found in re.finditer(r"(?:^    .*\n|^\n)+", PAGE, re.MULTILINE):
        if text := dedent(found[0]).strip("\n"):
            yield text


def test_lqr_of_the_page_becomes_the_c_of_the_page(tmp_path: Path) -> None:
    written, shown = next(indented()), next(text for text in indented() if text.startswith("struct "))
    block = load_module(tmp_path, written, "lqr.py").Levitation()
    program = Program(block)
    text = CText(program.layout, [program.method("step", (FLOAT,))])
    code = (text.structs() + text.functions_text()).splitlines()
    assert len(block.gains) == 3 and min(block.gains) > 0.0
    assert [line for line in shown.splitlines() if line.strip(" …") and line not in code] == []


@pytest.mark.parametrize(("line", "what"), [
    ("self.values = [x for x in self.values]", "a new list: expected"),
    ("self.count = 0.5", "self.count starts as a whole number"),
    ("if self.count > 0:\n            y = 1.0\n        self.x = y", "y may have no value yet")])
def test_messages_of_the_page(line: str, what: str, tmp_path: Path) -> None:
    shown = next(text for text in indented() if text.startswith("lqi.py, line")).splitlines()
    text = ("class Tank:\n    def __init__(self):\n        self.count, self.x, self.values = 0, 1.0, [1.0]\n\n"
            f"    def step(self):\n        {line}\n")
    with pytest.raises(Untranslatable) as refused:
        Program(load_module(tmp_path, text).Tank()).method("step")
    message = str(refused.value).partition(": ")[2]
    assert message.startswith(what)
    assert message in [each.partition(": ")[2] for each in shown]


@pytest.mark.parametrize("expression", [
    "self.count + 1", "1.0 / self.x", "self.values[self.count]", "sqrt(self.x)", "int(self.x)"])
def test_failures_of_the_page(expression: str, tmp_path: Path) -> None:
    text = ("from math import sqrt\n\nclass Tank:\n    def __init__(self):\n        self.count, self.x = 0, 1.0\n"
            f"        self.values = [1.0, 2.0, 3.0]\n\n    def step(self):\n        return {expression}\n")
    program = Program(load_module(tmp_path, text).Tank())
    assert program.method("step").results in ((FLOAT,), (INT,))
    (site,) = program.sites
    assert re.search(rf"line \d+: {re.escape(site.text.partition(': ')[2])}`", PAGE)
