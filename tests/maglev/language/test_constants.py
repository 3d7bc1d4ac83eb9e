"""Which attributes the C has as constants: those that are alike in all objects and that nothing assigns."""

from pathlib import Path

from written_blocks import load_block

from maglev.language.blocks import block_text

FILE = '''\
class Part:
    def __init__(self, number, same):
        self.number = number
        self.same = same


class Tank:
    def __init__(self):
        self.parts = [Part(0, 2), Part(1, 2)]
        self.order = [1, 0]
        self.swapped = [1, 0]
        self.given = [True, False]
        self.handed = [0, 0]
        self.left, self.right = [0, 0], [0, 0]
        self.count = 0
        self.kind = 1
        self.mode = 1
        self.on = True
        self.gain = 2.0
        self.level = [0.0, 0.0]

    def start(self):
        self.count = 1

    def fill(self, numbers):
        numbers[0] = 1

    def step(self, t, dt):
        self.fill(self.handed)
        swapped = self.swapped
        swapped[0] = 0
        side = self.left if t > 0.0 else self.right
        side[1] = self.left[0] + self.right[0]
        for number, part in zip(self.order, self.parts):
            self.level[number] = self.gain if self.on else t
            self.level[self.kind] += self.level[self.mode] * part.same * part.number
        if self.given[self.swapped[0]] and self.given[self.handed[1]] and self.count > 0:
            self.level[self.order[0]] = dt
'''


def test_constants_are_what_nothing_assigns(tmp_path: Path) -> None:
    block = load_block(tmp_path, FILE, "Tank")
    names = {"number", "same", "order", "swapped", "given", "handed", "left", "right", "count", "kind", "mode", "on",
             "gain"}

    def read(settable: list[str] | None) -> set[str]:
        code = block_text(block, settable=settable).functions.partition("Tank__step(")[2]
        return {name for name in names if f"->{name}" in code}

    assert read(None) == names
    assert read([]) == {"number", "swapped", "handed", "left", "right", "count", "gain"}
    assert read(["mode", "parts[1].same", "given[0]"]) == {"number", "swapped", "handed", "left", "right",
                                                          "count", "gain", "mode", "same", "given"}
