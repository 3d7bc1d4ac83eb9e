"""Which whole numbers need no check in the C: those whose values follow from constants and loops."""

from pathlib import Path

import pytest
from written_blocks import load_block

from maglev.language.blocks import block_text

FILE = '''\
ORDER = (2, 0, 1)


class Part:
    def __init__(self, place, level):
        self.place, self.level = place, level


class Tank:
    def __init__(self):
        self.levels = [1.0, 2.0, 3.0]
        self.parts = [Part(0, 1.0), Part(2, 2.0)]
        self.order = [1, 2]
        self.far = [3, 0]
        self.count = 0
        self.last = 2
        self.large = 2**62

    def start(self):
        self.count = 1

    def at(self, k):
        return self.levels[k]

    def step(self, t, dt):
{lines}
'''
SURE = (
    "for part in self.parts:\n    self.levels[part.place] = t",
    "for part in self.parts:\n    self.levels[2 - part.place] = t",
    "for k in self.order:\n    self.levels[k] = self.levels[k - 1]",
    "for k in ORDER:\n    self.levels[k] = t",
    "for k in range(self.last):\n    self.levels[k + 1] = t",
    "for k in range(2, -1, -1):\n    n = 2 - k\n    self.levels[n] = t",
    "n = self.last\nif t > 0.0:\n    n = 1\nself.levels[n] = t",
    "self.levels[0 if t > 0.0 else self.last] = t",
    "self.levels[1] = self.at(0) + self.at(self.last)",
    "self.levels[0] = float(self.large + self.last) + float(-self.last)",
    "for k in range(2):\n    self.levels[k * self.last] = t")
CHECKED = (
    "self.levels[self.count] = t",                                  # is assigned
    "for k in self.far:\n    self.levels[k] = t",                   # may be 3
    "for part in self.parts:\n    self.levels[part.place - 2] = t",   # may be below 0
    "for k in range(self.last + 1):\n    self.levels[k + 1] = t",
    "n = 0\nwhile t > float(n):\n    n = n + 1",                    # depends on itself
    "n = 0\nif t > 0.0:\n    n = self.count\nself.levels[n] = t",
    "self.levels[1] = self.at(0) + self.at(self.count)",
    "self.levels[1] = self.at(0)\nself.levels[0] = self.at(self.count) if t > 0.0 else t",
    "n = int(t)\nself.levels[n] = t",
    "self.levels[self.last if t > 0.0 else self.count] = t",
    "self.levels[0] = float(self.large + self.large)",              # 2^63
    "self.levels[0] = float(self.large * self.last)")


def step_of(lines: str, folder: Path, settable: list[str]) -> str:
    """The C of `step` and of what it calls."""
    text = FILE.format(lines="\n".join(f"        {line}" for line in lines.splitlines()))
    return block_text(load_block(folder, text, "Tank"), settable=settable).functions.partition("/* tank.py")[2]


@pytest.mark.parametrize("lines", SURE)
def test_sure_number_has_no_check(lines: str, tmp_path: Path) -> None:
    assert "failure, " not in step_of(lines, tmp_path, [])


@pytest.mark.parametrize("lines", CHECKED)
def test_other_number_has_a_check(lines: str, tmp_path: Path) -> None:
    assert "failure, " in step_of(lines, tmp_path, [])


@pytest.mark.parametrize(("lines", "place"), [
    (SURE[0], "parts[1].place"), (SURE[2], "order[0]"), (SURE[6], "last"), (SURE[8], "last")])
def test_number_from_outside_has_a_check(lines: str, place: str, tmp_path: Path) -> None:
    assert "failure, " in step_of(lines, tmp_path, [place])
