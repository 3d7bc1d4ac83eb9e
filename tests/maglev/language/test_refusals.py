"""What no block can have: each construct with its message, which says where it is, what it is, and what to write."""

from pathlib import Path
from textwrap import indent

import pytest
from written_blocks import load_block

from maglev.language.blocks import block_text
from maglev.language.program import Untranslatable

# A file with a block, whose `step` is one of those below; the line that is refused ends with "# <".
FILE = '''\
import math
import random

LIMIT = 2.0
TABLE = (1.0, 2.0)
LISTED = [1.0, 2.0]
UNLIKE = (1.0, 2)
NAME = "tank"


def share(x, y=1.0):
    return x * y


def pair(x):
    return x, -x


def idle(x):
    x = 2.0


def falls(n):  # <
    return n if n < 1 else falls(n - 1) + 1


def collected(*values):
    return 0.0


def doubled(function):
    return function


def times(factor):
    def product(x):
        return factor * x
    return product


twice = times(2.0)


class Part:
    def __init__(self, gain):
        self.gain = gain
        self.label = "part"


class Other:
    def __init__(self):
        self.gain = 1.0


class Tank:
    size = 3.0

    def __init__(self):
        self.level = 0.0
        self.count = 0
        self.on = False
        self.levels = [0.0, 0.0, 0.0]
        self.counts = [1, 2]
        self.none = []
        self.part = Part(1.0)
        self.parts = [Part(1.0), Part(2.0)]
        self.mixed = [1.0, 2]
        self.unlike = [Part(1.0), Other()]
        self.name = "tank"
        self.nothing = None
        self.table = {"a": 1.0}

    @property
    def half(self):
        return self.level / 2

    @doubled
    def decorated(self):  # <
        return 1.0

    @staticmethod
    def plain():
        return 1.0

    def maybe(self):  # <
        if self.on:
            return 1.0

    def either(self):
        if self.on:
            return 1.0
        return 1  # <

    def mutual(self):  # <
        return self.mutual_too()

    def mutual_too(self):
        return self.mutual()

    def start(self):
        pass

    def step(self, t, dt):
'''

# Construct, and its message without file and line.
EXPRESSIONS = {
    "self.level ** 2": "**: expected a product",
    "self.levels @ self.levels": "@: expected sums of products in a for",
    "self.level // 2.0": "// of floats: expected floor of math",
    "self.level % 2.0": "% of floats: expected fmod of math",
    "self.level << 1": "<< of floats: expected whole numbers",
    "~self.level": "~ of a float: expected a whole number",
    "self.on + 1": "self.on + 1 has a Boolean: expected numbers, such as 1.0 if … else 0.0",
    "-self.on": "-self.on has a Boolean: expected numbers, such as 1.0 if … else 0.0",
    "not self.level": "self.level is a float: expected a Boolean or a comparison",
    "self.level and self.on": "self.level is a float: expected a Boolean or a comparison",
    "1.0 if self.level else 0.0": "self.level is a float: expected a Boolean or a comparison",
    "1.0 if self.on else 0": "1.0 if self.on else 0 is a float or a whole number: expected one type, such as 0.0 for 0",
    "self.level is None": "None: expected a number, or a Boolean next to it",
    "self.level in self.levels": "self.level in self.levels: expected <, <=, >, >=, == or !=",
    "self.part == self.part": "self.part == self.part has an object of Part: expected numbers",
    "sum(self.levels)": "sum() of floats differs from Python 3.12 on: expected a for",
    "sum(x for x in self.levels)": "a generator: expected a for, any() or all()",
    "max(x for x in self.levels)": "a generator: expected a for, any() or all()",
    "any(x > 0.0 for x in self.levels if x < 1.0)":
        "any((x > 0.0 for x in self.levels if x < 1.0)): expected one for over a list, without an if",
    "any(self.levels)": "any(self.levels): expected a list of Booleans",
    "all(self.level)": "all(self.level): self.level is a float, expected a list",
    "max(self.levels)": "max(self.levels): expected two numbers or more",
    "max(1, 2.0)": "max(1, 2.0): expected numbers of one type, such as 0.0 for 0",
    "max(self.level)": "max(self.level): expected two numbers or more",
    "min(self.level, key=abs)": "min() with names or *: expected values alone",
    "max(*self.levels)": "max() with names or *: expected values alone",
    "len(self.level)": "len(self.level): self.level is a float, expected a list",
    "len()": "len(): expected one list",
    "abs(self.on)": "abs(self.on) has a Boolean: expected numbers, such as 1.0 if … else 0.0",
    "abs(self.level, self.level)": "abs(self.level, self.level): expected one value",
    "round(self.level)":
        "round(): expected a def, a function of math, abs, min, max, len, any, all, int, float or bool",
    "pow(self.level, 2.0)":
        "pow(): expected a def, a function of math, abs, min, max, len, any, all, int, float or bool",
    "divmod(self.count, 2)":
        "divmod(): expected a def, a function of math, abs, min, max, len, any, all, int, float or bool",
    "print(self.level)":
        "print(): expected a def, a function of math, abs, min, max, len, any, all, int, float or bool",
    "isinstance(self.level, float)":
        "isinstance(): expected a def, a function of math, abs, min, max, len, any, all, int, float or bool",
    "random.random()":
        "random.random(): expected a def, a function of math, abs, min, max, len, any, all, int, float or bool",
    "math.gamma(self.level)":
        "math.gamma(): expected one of acos, asin, atan, atan2, ceil, cos, cosh, erf, erfc, exp, expm1, floor, "
        "fmod, isfinite, isinf, isnan, log, log10, log1p, log2, pow, remainder, sin, sinh, sqrt, tan, tanh, "
        "trunc, or of pmlsm",
    "math.fsum(self.levels)":
        "math.fsum(self.levels) has a list of 3 elements: expected numbers, such as its elements in a for",
    "math.no_such_thing": "there is no no_such_thing in math: expected a name of it",
    "unknown": "there is no unknown: expected a name of the file",
    "unknown(self.level)": "unknown(): there is no such function, expected a def of the file",
    "UNLIKE[0]": "UNLIKE: expected numbers of one type",
    "NAME": "text: expected numbers only",
    "'tank'": "text: expected numbers only",
    "f'{self.level}'": "text: expected numbers only",
    "None": "None: expected a number, or a Boolean next to it",
    "9223372036854775808": "9223372036854775808: expected a whole number below 2^63",
    "1j": "1j is of complex: expected a number, or an attribute that __init__ sets",
    "share": "share is of function: expected a number, or an attribute that __init__ sets",
    "Part": "Part is of type: expected a number, or an attribute that __init__ sets",
    "Part(1.0)": "Part(): expected a def, a function of math, abs, min, max, len, any, all, int, float or bool",
    "[1.0, 2.0]": "a new list: expected one that __init__ sets, and assignments to its elements",
    "[0.0] * 3": "a new list: expected one that __init__ sets, and assignments to its elements",
    "(1.0, 2.0)": "a tuple that is kept: expected a name for each value",
    "{1.0, 2.0}": "a set: expected attributes",
    "{'a': 1.0}": "a dict: expected attributes",
    "[x for x in self.levels]": "a new list: expected one that __init__ sets, and a for",
    "{x for x in self.levels}": "a set: expected attributes",
    "{x: x for x in self.levels}": "a dict: expected attributes",
    "(x for x in self.levels)": "a generator: expected a for, any() or all()",
    "lambda: 1.0": "lambda: expected a def",
    "(y := 1.0)": ":=: expected a line of its own",
    "self.levels[0:2]": "a part of a list: expected a for over its elements",
    "self.levels[3]": "element 3 of a list of 3: expected -3 to 2",
    "self.levels[-4]": "element -4 of a list of 3: expected -3 to 2",
    "self.levels[1.0]": "self.levels[1.0]: expected a list and a whole number",
    "self.levels[self.on]": "self.levels[self.on]: expected a list and a whole number",
    "self.none[self.count]": "an element of an empty list: expected one with elements",
    "self.level[0]": "self.level[0]: expected a list and a whole number",
    "self.levels + self.levels":
        "self.levels + self.levels has a list of 3 elements: expected numbers, such as its elements in a for",
    "self.none[0]": "element 0 of a list of 0: expected a longer one",
    "self.levels.copy()": "self.levels.copy(): lists have no methods: expected a for over its elements",
    "self.level.real": "self.level.real: self.level is a float, expected an object",
    "self.mixed[0]":
        "self.mixed[1] is unlike self.mixed[0]: expected a list of numbers of one type, or of objects of one "
        "class with attributes of the same types",
    "self.unlike[0].gain":
        "self.unlike[1] is unlike self.unlike[0]: expected a list of numbers of one type, or of objects of one "
        "class with attributes of the same types",
    "self.name": "self.name is of str: expected a number, a Boolean, an object or a list",
    "self.part.label": "self.label is of str: expected a number, a Boolean, an object or a list",   # as Part has it
    "self.nothing": "self.nothing is None: expected a number, a Boolean, an object or a list",
    "self.table['a']": "self.table is of dict: expected a number, a Boolean, an object or a list",
    "self.missing":
        "self.missing is no attribute with a number, an object or a list: expected one that __init__ of Tank sets",
    "self.half": "self.half is a property: expected a call of a method",
    "self.maybe": "self.maybe is a method: expected a call of a method",
    "self.missing()": "self.missing(): Tank has no such method: expected a def in it",
    "super().step(t, dt)": "super(): expected the method of the base class under another name",
    "self.part.missing()": "self.part.missing(): Part has no such method: expected a def in it",
    "self.plain()": "self.plain() is a staticmethod: expected a method with self, or a def next to the class",
    "self.level()": "self.level(): Tank has no such method: expected a def in it",
    "self.decorated()": "a decorator of decorated: expected a plain def",
    "self.maybe()": "maybe may end without a return: expected one on every way",
    "self.either()": "return 1 has a whole number, another return a float: expected the same, such as 0.0 for 0",
    "self.mutual()": "mutual calls itself: expected a loop",
    "falls(3)": "falls calls itself: expected a loop",
    "collected(1.0)": "collected() has * or / in its def: expected every parameter by itself",
    "twice(1.0)": "twice() is a def in a function: expected one of a module",
    "LISTED(1.0)": "LISTED(): expected a def, a function of math, abs, min, max, len, any, all, int, float or bool",
    "self.level.hypot()": "self.level.hypot(): self.level is a float, expected an object",
    "any(x > 0.0 for x in self.level)": "self.level is a float: expected a list",
    "share()": "share(): missing a required argument: 'x', expected share(x, y=1.0)",
    "share(1.0, z=2.0)": "share(): got an unexpected keyword argument 'z', expected share(x, y=1.0)",
    "share(*self.levels)": "share() with * or **: expected every value by itself",
    "share(**self.table)": "share() with * or **: expected every value by itself",
    "share(idle(1.0))": "idle() has no value: expected a return in it",
    "idle(1.0)": "idle() has no value: expected a return in it",
    "pair(1.0)": "pair() has 2 values: expected one, or a name for each",
    "(yield 1.0)": "yield: expected a return",
}
STATEMENTS = {
    "self.level = 1":
        "self.level starts as a float and is assigned a whole number: expected a float, such as 0.0 for 0",
    "self.count = 1.0":
        "self.count starts as a whole number and is assigned a float: expected int() of it, or a float from the start",
    "self.count /= 2":
        "self.count starts as a whole number and is assigned a float: expected int() of it, or a float from the start",
    "self.count = self.on": "self.count starts as a whole number and is assigned a Boolean: expected the same type",
    "self.on = 1": "self.on starts as a Boolean and is assigned a whole number: expected a Boolean, such as True",
    "self.new = 1.0":
        "self.new is no attribute with a number, an object or a list: expected one that __init__ of Tank sets",
    "self.part = self.parts[0]":
        "self.part is an object of Part, which cannot be replaced: expected assignments to its attributes or elements",
    "self.levels = self.levels":
        "self.levels is a list of 3 elements, which cannot be replaced: expected assignments to its attributes "
        "or elements",
    "self.levels = [1.0]": "a new list: expected one that __init__ sets, and assignments to its elements",
    "self.levels.append(1.0)":
        "self.levels.append(): a list keeps its length and order: expected assignments to its elements",
    "self.levels[0:1] = self.levels": "a part of a list: expected a for over its elements",
    "self.parts[0] = self.parts[1]":
        "self.parts[0] is an object of Part, which cannot be replaced: expected assignments to its attributes or "
        "elements",
    "self.half = 1.0": "self.half is a property: expected a call of a method",
    "Tank.size = 1.0": "Tank is of type: expected a number, or an attribute that __init__ sets",
    "self.size = 1.0": "self.size cannot be assigned: expected an attribute that __init__ sets",
    "TABLE[self.count] = 1.0": "TABLE is a constant of a module, which cannot change: expected an attribute",
    "table = TABLE\ntable[0] = 1.0": "TABLE is a constant of a module, which cannot change: expected an attribute",
    "x = self.part\nx = self": "x is an object of Part and becomes an object of Tank: expected an object whose "
                              "attributes have the same types",
    "for (x, y), z in enumerate(self.levels):  # <\n    pass": "(x, y): expected a name for the number",
    "for self.count in range(2):  # <\n    pass":
        "self.count in range(2): expected a name, and one to three whole numbers",
    "for k in range():  # <\n    pass": "k in range(): expected a name, and one to three whole numbers",
    "for t in range(2):  # <\n    pass": "t is a float and becomes a whole number: expected a float, such as 0.0 for 0",
    "TABLE[0] = 1.0": "TABLE[0] cannot be assigned: expected an attribute that __init__ sets",
    "x = 1.0\nx = 1": "x is a float and becomes a whole number: expected a float, such as 0.0 for 0",
    "x = 1.0\nx += self.on": "x += self.on has a Boolean: expected numbers, such as 1.0 if … else 0.0",
    "x = self.part\nx = self.levels": "x is an object of Part and becomes a list of 3 elements: expected the same type",
    "if self.on:\n    x = 1.0\nself.level = x  # <":
        "x may have no value yet: expected one on every way that leads here",
    "for k in range(self.count):\n    x = 1.0\nself.level = x  # <":
        "x may have no value yet: expected one on every way that leads here",
    "for k in range(3, 3):\n    x = 1.0\nself.level = x  # <": "x has no value yet: expected an assignment before",
    "while self.on:\n    x = 1.0\n    break\nself.level = x  # <":
        "x may have no value yet: expected one on every way that leads here",
    "for k in range(2):\n    if self.on:\n        continue\n    for m in range(2):\n        pass\n    x = 1.0\n"
    "self.level = x  # <": "x may have no value yet: expected one on every way that leads here",
    "self.level = y  # <\ny = 1.0": "y has no value yet: expected an assignment before",
    "x, y = 1.0": "1.0 for 2 names: expected as many values",
    "x, y = pair(1.0), 1.0\n": "pair() has 2 values: expected one, or a name for each",
    "x, y, z = pair(1.0)": "pair(1.0) for 3 names: expected as many values",
    "x, y = 1.0, 2.0, 3.0": "3 values for 2 names: expected as many",
    "x, *y = 1.0, 2.0": "*: expected every value by itself",
    "x, y = self.levels": "self.levels for 2 names: expected as many values",
    "del self.level": "del: expected an assignment",
    "assert self.on": "assert: expected an if",
    "raise ValueError": "raise: expected a value that says so",
    "try:  # <\n    pass\nfinally:\n    pass": "try: expected an if before it can fail",
    "with open(NAME):  # <\n    pass": "with: expected numbers only",
    "match self.count:  # <\n    case 1:\n        pass": "match: expected an if",
    "import os": "an import in a function: expected it at the top of the file",
    "from math import pi": "an import in a function: expected it at the top of the file",
    "global LIMIT": "global: expected an attribute",
    "def inner():  # <\n    return 1.0": "a def in a function: expected it next to the class",
    "class Inner:  # <\n    pass": "a class in a function: expected it next to that of the block",
    "for k in self.count:  # <\n    pass":
        "self.count is a whole number: expected range(), a list, enumerate() or zip() of lists",
    "for k in reversed(self.levels):  # <\n    pass":
        "k in reversed(self.levels): expected a name in range(), in a list, enumerate() or zip() of lists",
    "for k, in self.levels:  # <\n    pass":
        "(k,) in self.levels: expected a name in range(), in a list, enumerate() or zip() of lists",
    "for k in range(self.level):  # <\n    pass": "self.level is a float: expected a whole number",
    "for k in range(0, 5, self.count):  # <\n    pass":
        "range(0, 5, self.count): expected a step that is written there, other than 0",
    "for k in range(0, 5, 0):  # <\n    pass": "range(0, 5, 0): expected a step that is written there, other than 0",
    "for k, x in enumerate(self.levels, 1):  # <\n    pass":
        "enumerate(self.levels, 1): expected enumerate() of one list",
    "for k in enumerate(self.levels):  # <\n    pass": "k in enumerate(self.levels): expected a name for each value",
    "for x, y in zip(self.levels, self.counts):  # <\n    pass":
        "zip(self.levels, self.counts): lists of 2 and 3 elements, expected equal lengths",
    "for x, y in zip(self.levels):  # <\n    pass": "(x, y) in zip(self.levels): expected a name for each value",
    "for x in self.levels:  # <\n    pass\nelse:\n    pass": "an else of a loop: expected an if behind the loop",
    "while self.on:  # <\n    pass\nelse:\n    pass": "an else of a loop: expected an if behind the loop",
    "while self.count:  # <\n    pass": "self.count is a whole number: expected a Boolean or a comparison",
    "if self.count:  # <\n    pass": "self.count is a whole number: expected a Boolean or a comparison",
    "return self.levels": "return self.levels: expected numbers or Booleans",
    "return [1.0]": "a new list: expected one that __init__ sets, and assignments to its elements",
    "self.level": "self.level: expected an assignment, an if, a for, a while or a return",
    "self.level: float": "self.level: float: expected an assignment, an if, a for, a while or a return",
}


def file_of(body: str) -> str:
    """Text of a file whose `step` has a body; its first line is marked if no other one is."""
    lines = body.splitlines()
    marked = body if any(line.endswith("# <") for line in lines) else "\n".join([*lines[:-1], f"{lines[-1]}  # <"])
    return FILE + indent(marked, " " * 8) + "\n"


def message(folder: Path, text: str) -> str:
    """The message for a file without file and line, which is that of a mark."""
    with pytest.raises(Untranslatable) as refused:
        block_text(load_block(folder, text, "Tank"))
    place, _, rest = str(refused.value).partition(": ")
    line = text.splitlines()[int(place.removeprefix("tank.py, line ")) - 1]
    assert "# <" in line, f"{place}: {line}"
    return rest


@pytest.mark.parametrize("construct", EXPRESSIONS)
def test_refuses_expression(construct: str, tmp_path: Path) -> None:
    assert message(tmp_path, file_of(f"_ = {construct}")) == EXPRESSIONS[construct]


@pytest.mark.parametrize("construct", STATEMENTS)
def test_refuses_statement(construct: str, tmp_path: Path) -> None:
    assert message(tmp_path, file_of(construct)) == STATEMENTS[construct]


@pytest.mark.parametrize("body", ["self.level = 1.0", "return\nself.level = self.name"])
def test_accepts_block_without_refused_statement(body: str, tmp_path: Path) -> None:
    assert "Tank__step" in block_text(load_block(tmp_path, file_of(body), "Tank")).functions


def test_accepts_a_tuple_in_two_places(tmp_path: Path) -> None:
    text = FILE.replace("self.name =", "self.one = self.two = (1.0, 2.0)\n        self.name =")
    assert "Tank__step" in block_text(load_block(tmp_path, f"{text}        pass\n", "Tank")).functions


@pytest.mark.parametrize(("head", "expected"), [
    ("def step(self, t, *rest):", "step with * or /: expected every parameter by itself"),
    ("def step(self, t, dt, /):", "step with * or /: expected every parameter by itself"),
    ("def step(self, t):", "step(self, t) is called with 3 values: expected as many parameters"),
    ("async def step(self, t, dt):", "async: expected a plain def")])
def test_refuses_head_of_step(head: str, expected: str, tmp_path: Path) -> None:
    text = FILE.replace("def step(self, t, dt):", f"{head}  # <") + " " * 8 + "pass\n"
    assert message(tmp_path, text) == expected


@pytest.mark.parametrize(("line", "expected"), [
    ("self.other = self.part", "self.other is the same object as self.part: expected one of its own, or a number that "
                               "says which one is meant"),
    ("self.other = Part(self.part)", "self.other.gain is the same object as self.part: expected one of its own, or a "
                                     "number that says which one is meant"),
    ("self.other = [self.part]", "self.other[0] is the same object as self.part: expected one of its own, or a number "
                                 "that says which one is meant"),
    ("self.other = self.levels", "self.other is the same object as self.levels: expected one of its own, or a number "
                                 "that says which one is meant"),
    ("self.other = 2**63", "self.other = 9223372036854775808: a whole number is below 2^63")])
def test_refuses_attribute_in_its_line(line: str, expected: str, tmp_path: Path) -> None:
    text = FILE.replace("    @property\n", f"        {line}  # <\n\n    @property\n", 1)
    text = text.replace("\n\n        self.other", "\n        self.other")
    assert message(tmp_path, text + " " * 8 + "pass\n") == expected
